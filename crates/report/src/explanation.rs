//! One family of effects in depth: its law, parameters, an example, what it is confused with, what to look at.
//!
//! The texts are in `effects/`, one file a family: a line `example: …` for lists, then sections that begin with `##`.

/// Family and text of every built-in effect.
const TEXTS: [(&str, &str); 18] = [
    ("backlash", include_str!("../effects/backlash.md")),
    ("base_compliance", include_str!("../effects/base_compliance.md")),
    ("coupling", include_str!("../effects/coupling.md")),
    ("drift", include_str!("../effects/drift.md")),
    ("expansion", include_str!("../effects/expansion.md")),
    ("geometric", include_str!("../effects/geometric.md")),
    ("guideway", include_str!("../effects/guideway.md")),
    ("instrument", include_str!("../effects/instrument.md")),
    ("joint_compliance", include_str!("../effects/joint_compliance.md")),
    ("landmarks", include_str!("../effects/landmarks.md")),
    ("link_compliance", include_str!("../effects/link_compliance.md")),
    ("load_nonlinearity", include_str!("../effects/load_nonlinearity.md")),
    ("observed", include_str!("../effects/observed.md")),
    ("polynomial", include_str!("../effects/polynomial.md")),
    ("session", include_str!("../effects/session.md")),
    ("shift", include_str!("../effects/shift.md")),
    ("thermal", include_str!("../effects/thermal.md")),
    ("transmission", include_str!("../effects/transmission.md")),
];

/// A family of effects in depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Explanation {
    /// One line that declares it, or says where it comes from.
    pub example: &'static str,
    /// Law, parameters with units, example, what it is confused with and what would tell them apart, what to look at: Markdown.
    pub text: &'static str,
}

/// The explanation of a built-in family; none of others.
pub fn explanation(family: &str) -> Option<Explanation> {
    let (_, whole) = TEXTS.iter().find(|(known, _)| *known == family)?;
    let (first, text) = whole.split_once('\n')?;
    Some(Explanation { example: first.strip_prefix("example: ")?, text: text.trim_start() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::EffectRegistry;

    #[test]
    fn every_built_in_family_is_explained_in_all_its_sections() {
        for (family, _) in EffectRegistry::builtin().kinds() {
            let known = explanation(family).unwrap_or_else(|| panic!("{family} is not explained"));
            let heads: Vec<&str> = known.text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
            let expected = ["Law", "Parameters", "Example", "Confused with", "What to look at"];
            assert_eq!(heads, expected, "{family}");
            assert!(!known.example.is_empty() && known.text.lines().all(|line| line.chars().count() <= 160));
        }
        assert_eq!(explanation("acme/belt"), None);
    }
}
