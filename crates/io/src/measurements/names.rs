//! Headers of a file as names and units of ours: mapped by the user, or in another spelling of the unit.

use super::columns::Role;
use super::constants;
use super::mapping::ColumnMap;
use crate::{Quantity, Unit};
use std::borrow::Cow;
use truepose_kinematics::Chain;

/// What headers can mean.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    pub chain: &'a Chain,
    pub map: &'a ColumnMap,
}

/// What a header is.
#[derive(Debug, PartialEq)]
pub(crate) enum Named<'h> {
    /// Left out by the user.
    Ignored,
    /// A header of ours: `name` or `name[unit]`.
    Header(Cow<'h, str>),
}

impl Names<'_> {
    /// The header of ours that a header of the file stands for.
    pub fn resolve<'h>(&self, header: &'h str) -> Named<'h> {
        let (name, unit) = split_unit(header);
        let ColumnMap { names, usual_names, ignore, usual_ignore, .. } = self.map;
        if ignore.iter().any(|word| same(header, word)) {
            return Named::Ignored;
        }
        let usual = usual_names.iter().filter(|(ours, _)| names.iter().all(|(own, _)| own != ours));
        let mapped = names.iter().chain(usual).find(|(_, theirs)| same(header, theirs));
        if mapped.is_none() && usual_ignore.iter().any(|word| same(header, word)) {
            return Named::Ignored;
        }
        if let Some((ours, theirs)) = mapped {
            let unit = unit.or(split_unit(theirs).1).or(unit_in_words(header));
            return Named::Header(match unit {
                Some(unit) => Cow::Owned(format!("{ours}[{unit}]")),
                None => Cow::Owned(ours.clone()),
            });
        }
        // A spelling of our own is left as it is, to the last character.
        if header.contains(['[', ']']) || self.role(header.trim()).is_some() {
            return Named::Header(Cow::Borrowed(header));
        }
        if let Some(unit) = unit
            && let Some(role) = self.role(name)
            && role.quantity(self.chain) == Unit::named(unit).map(|unit| unit.quantity)
        {
            return Named::Header(Cow::Owned(format!("{name}[{unit}]")));
        }
        // Of channels the unit matters where it makes them temperatures.
        if let Some(unit) = unit.filter(|unit| unit.contains('C'))
            && Unit::named(unit).is_some_and(|unit| unit.quantity == Quantity::Temperature)
        {
            return Named::Header(Cow::Owned(format!("{name}[{unit}]")));
        }
        Named::Header(Cow::Borrowed(header))
    }

    /// Entries of the map that match no header of the file, in words; a column that the file has under our own name needs no entry, and
    /// measured columns are missing where nothing has to be measured.
    pub fn unmatched(&self, headers: &[&str], measured: bool) -> Vec<String> {
        let has = |word: &str| headers.iter().any(|header| same(header, word));
        let optional = |name: &str| {
            let role = self.role(name);
            !measured
                && matches!(
                    role,
                    Some(Role::Position(_) | Role::Quaternion(_) | Role::RotationVector(_) | Role::Angle(_))
                )
        };
        let mapped =
            self.map.names.iter().filter(|(ours, theirs)| !has(theirs) && !has(ours) && !optional(ours));
        let mapped = mapped.filter(|(ours, theirs)| constants::length((ours, theirs)).is_none());
        let mapped = mapped.map(|(ours, theirs)| {
            format!("`{ours}` is mapped to the column `{theirs}`, which is not in this file")
        });
        let ignored = self.map.ignore.iter().filter(|word| !has(word));
        mapped
            .chain(
                ignored.map(|word| format!("the column `{word}` is to be left out, and is not in this file")),
            )
            .collect()
    }

    /// The meaning of a name, channels apart.
    pub fn role(&self, name: &str) -> Option<Role> {
        if let Some(role) = self.oriented(name) {
            return Some(role);
        }
        Role::of(name, self.chain, 0).ok().filter(|role| !matches!(role, Role::Channel(_)))
    }

    /// The meaning of a name in the convention of the orientations.
    pub fn oriented(&self, name: &str) -> Option<Role> {
        let convention = self.map.orientation?;
        let angle = convention.angle(name).map(Role::Angle);
        angle.or_else(|| convention.quaternion(name).map(Role::Quaternion))
    }

    /// Whether a header of the file has this meaning.
    pub fn means(&self, header: &str, role: Role) -> bool {
        match self.resolve(header) {
            Named::Ignored => false,
            Named::Header(header) => self.role(split_unit(&header).0) == Some(role),
        }
    }

    /// Whether a header of the file has a meaning.
    pub fn knows(&self, header: &str) -> bool {
        match self.resolve(header) {
            Named::Ignored => true,
            Named::Header(header) => self.role(split_unit(&header).0).is_some(),
        }
    }

    /// Whether the cells below a header are texts.
    pub fn is_text(&self, header: &str) -> bool {
        match self.resolve(header) {
            Named::Ignored => true,
            Named::Header(header) => {
                matches!(
                    self.role(split_unit(&header).0),
                    Some(
                        Role::Target
                            | Role::Note
                            | Role::Id
                            | Role::Session
                            | Role::Kind
                            | Role::Landmark
                            | Role::Tool
                    )
                )
            }
        }
    }
}

/// Whether a header is what the user calls so, with its unit or without.
fn same(header: &str, word: &str) -> bool {
    let word = word.trim();
    word == header.trim() || split_unit(word).0 == split_unit(header).0
}

/// Name and unit of a header in any of the usual spellings: `x[mm]`, `x (mm)`, `x mm`, `x_mm`, `x/mm`, `x in mm`, `x°`.
pub(super) fn split_unit(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, rest)) = header.rsplit_once(open)
            && let Some(unit) = rest.trim_end().strip_suffix(close)
            && (open == '[' || Unit::named(unit.trim()).is_some())
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    let known = |unit: &str| Unit::named(unit).is_some_and(|unit| unit.quantity != Quantity::Ratio);
    if let Some((name, unit)) = header.rsplit_once([' ', '_', '/', ','])
        && known(unit.trim())
    {
        let name = name.trim_end().trim_end_matches(['/', ',']).trim_end();
        return (name.strip_suffix(" in").unwrap_or(name).trim_end(), Some(unit.trim()));
    }
    match header.strip_suffix('°') {
        Some(name) if !name.trim().is_empty() => (name.trim(), Some("°")),
        _ => (header, None),
    }
}

/// The unit that stands among other words in brackets: `Rx (Fixed XYZ deg)`; none where there are several.
pub(super) fn unit_in_words(header: &str) -> Option<&'static str> {
    let inside = header.trim().strip_suffix([')', ']'])?.rsplit_once(['(', '['])?.1;
    // Letters alone (m, s, h, N) are rather something else, and so is `in`.
    let long = |word: &&str| (word.chars().count() > 1 && *word != "in") || *word == "°";
    let unit = |word: &str| Unit::named(word).filter(|unit| unit.quantity != Quantity::Ratio);
    let mut units = inside.split([' ', ',', ';', '/']).filter(long).filter_map(unit);
    units.next().filter(|_| units.next().is_none()).map(|unit| unit.word)
}

/// Whether a cell of a row below the header is a unit.
pub(super) fn is_unit_word(cell: &str) -> bool {
    let word = cell.trim_matches(['[', ']', '(', ')']).trim();
    matches!(word, "-" | "–") || (word.parse::<f64>().is_err() && Unit::named(word).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn spellings_of_units() {
        for (header, expected) in [
            ("x[mm]", ("x", Some("mm"))),
            ("x (mm)", ("x", Some("mm"))),
            ("x_mm", ("x", Some("mm"))),
            ("x / mm", ("x", Some("mm"))),
            ("x in mm", ("x", Some("mm"))),
            ("Joint 1[°]", ("Joint 1", Some("°"))),
            ("Joint 1°", ("Joint 1", Some("°"))),
            ("Joint 1", ("Joint 1", None)),
            ("approach_d1", ("approach_d1", None)),
            ("temp (outside)", ("temp (outside)", None)),
        ] {
            assert_eq!(split_unit(header), expected);
        }
    }

    #[test]
    fn units_among_words() {
        assert_eq!(unit_in_words("Rx (Fixed XYZ deg)"), Some("deg"));
        assert_eq!(unit_in_words("X (world, mm)"), Some("mm"));
        assert_eq!(unit_in_words("X (from mm to um)"), None);
        assert_eq!(unit_in_words("temp (outside in s)"), None);
        assert_eq!(unit_in_words("temp"), None);
    }

    #[test]
    fn headers_are_resolved() {
        let chain = samples::scara();
        let map = ColumnMap {
            names: vec![("r1".into(), "Joint 1[°]".into()), ("x".into(), "X (mm)".into())],
            ignore: vec!["Operator".into()],
            ..ColumnMap::default()
        };
        let names = Names { chain: &chain, map: &map };
        let header = |text: &str| match names.resolve(text) {
            Named::Ignored => "-".to_owned(),
            Named::Header(header) => header.into_owned(),
        };
        assert_eq!(header("Joint 1"), "r1[°]");
        assert_eq!(header("Joint 1 [deg]"), "r1[deg]");
        assert_eq!(header("X (mm)"), "x[mm]");
        assert_eq!(header("X"), "x[mm]");
        assert_eq!(header("Operator"), "-");
        assert_eq!(header("y (mm)"), "y[mm]");
        assert_eq!(header("slide mm"), "slide[mm]");
        // No length, so no unit of it.
        assert_eq!(header("slide_deg"), "slide_deg");
        assert_eq!(header("oil (bar)"), "oil (bar)");
        assert_eq!(header("oil (°C)"), "oil[°C]");
        assert_eq!(header("oil (K)"), "oil (K)");
        assert!(names.knows("r2 (°)") && !names.knows("oil (degC)"));
    }
}
