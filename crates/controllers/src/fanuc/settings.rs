//! Statements that select user frame, tool and payload: `UFRAME_NUM=2`, `UTOOL_NUM[GP1]=3`, `PAYLOAD[2]`.

use crate::reference::Reference;

/// What is selected, in the order of [`Selected`].
pub(super) const WHAT: [&str; 3] = ["UFRAME_NUM", "UTOOL_NUM", "PAYLOAD"];

/// The place of the payload.
pub(super) const PAYLOAD: usize = 2;

/// User frame, tool and payload.
pub(super) type Selected = [Reference; 3];

/// What a statement selects.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Setting {
    To(usize, Reference),
    OfAnotherGroup,
}

/// What selects a payload, in the languages of the controllers.
const PAYLOADS: [&str; 2] = ["PAYLOAD[", "TRAGLST["];

/// The setting of a statement; none where it selects nothing.
pub(super) fn setting(text: &str, line: usize) -> Option<Setting> {
    let shown = || super::statements::shown(text);
    if let Some(rest) = PAYLOADS.iter().find_map(|word| text.strip_prefix(word)) {
        let inside = rest.split(']').next().unwrap_or("");
        let (group, number) = grouped(inside).unwrap_or(("GP1", inside));
        if group != "GP1" {
            return Some(Setting::OfAnotherGroup);
        }
        let number: Result<u32, _> = number.split(':').next().unwrap_or("").trim().parse();
        let computed = |_| Reference::Unknown(format!("{} in line {line} is computed", shown()));
        let to = number.map_or_else(computed, |number| Reference::Named(format!("PAYLOAD[{number}]")));
        return Some(Setting::To(PAYLOAD, to));
    }
    let plain: String = text.chars().filter(|c| !c.is_whitespace() && *c != ';').collect();
    for (which, word) in WHAT.iter().enumerate().take(PAYLOAD) {
        let Some(at) = plain.find(word) else { continue };
        let rest = &plain[at + word.len()..];
        let (group, rest) = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((inside, rest)) => (inside, rest),
            None => ("GP1", rest),
        };
        let Some(value) = rest.strip_prefix('=') else { continue };
        if at == 0 && group != "GP1" {
            return Some(Setting::OfAnotherGroup);
        }
        let to = match value.parse::<u32>() {
            _ if at > 0 => Reference::Unknown(format!("{} in line {line} depends on a condition", shown())),
            Ok(0) => Reference::Identity,
            Ok(number) => Reference::Named(format!("{}{number}", ["UF", "UT"][which])),
            Err(_) => Reference::Unknown(format!("{} in line {line} is computed", shown())),
        };
        return Some(Setting::To(which, to));
    }
    None
}

/// `GP1:2`
fn grouped(inside: &str) -> Option<(&str, &str)> {
    let (group, number) = inside.split_once(':')?;
    group.trim().starts_with("GP").then(|| (group.trim(), number.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_tools_and_payloads_are_selected_by_number() {
        let named = |which, name: &str| Some(Setting::To(which, Reference::Named(name.into())));
        assert_eq!(setting("UFRAME_NUM=2 ;", 1), named(0, "UF2"));
        assert_eq!(setting("UFRAME_NUM[GP1] = 0 ;", 1), Some(Setting::To(0, Reference::Identity)));
        assert_eq!(setting("UTOOL_NUM=11 ;", 1), named(1, "UT11"));
        assert_eq!(setting("UTOOL_NUM[GP2]=11 ;", 1), Some(Setting::OfAnotherGroup));
        assert_eq!(setting("PAYLOAD[GP1:3] ;", 1), named(2, "PAYLOAD[3]"));
        assert_eq!(setting("R[1]=UFRAME_NUM ;", 1), None);
        for open in ["UTOOL_NUM=R[3] ;", "IF R[1]=1,UFRAME_NUM=2 ;", "PAYLOAD[R[2]] ;"] {
            assert!(
                matches!(setting(open, 7), Some(Setting::To(_, Reference::Unknown(words))) if words.contains("line 7")),
                "{open}"
            );
        }
    }
}
