//! Names that a joint or a target can bear.

use crate::frame_names::FRAMES;
use crate::table::unprefixed;

/// Columns of measurements that have a meaning of their own.
const COLUMNS: [&str; 33] = [
    "x", "y", "z", "qw", "qx", "qy", "qz", "rx", "ry", "rz", "target", "visit", "payload", "cx", "cy", "cz",
    "fx", "fy", "fz", "tx", "ty", "tz", "time", "sx", "sy", "sz", "srx", "sry", "srz", "status", "base",
    "tool", "targets",
];

/// Characters that a name has at most.
const LONGEST: usize = 200;

/// Ends a line for some reader (YAML, JavaScript), or is no character of XML 1.0; control characters apart.
pub(crate) fn unprintable(c: char) -> bool {
    matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
}

/// Why a joint cannot bear this name, if it cannot.
pub(crate) fn joint_name_problem(name: &str) -> Option<String> {
    if FRAMES.contains(&name) {
        return Some(format!("a joint cannot be called `{name}`, which is the name of a frame; rename it"));
    }
    if COLUMNS.contains(&name) || name.starts_with("approach_") {
        return Some(format!(
            "a joint cannot be called `{name}`, which is a column of measurements with another meaning; rename it"
        ));
    }
    if name.contains(['[', ']']) {
        return Some(format!("the name `{name}` cannot be used in the header of a column; use no brackets"));
    }
    cell_problem(name)
}

/// Why a name cannot be used in a cell of a table, if it cannot.
pub(crate) fn cell_problem(name: &str) -> Option<String> {
    let shown = name.escape_debug();
    if name.is_empty() {
        Some("the name is empty; give one".into())
    } else if name.chars().count() > LONGEST {
        let begins: String = name.chars().take(20).collect();
        Some(format!("the name `{}…` is longer than {LONGEST} characters", begins.escape_debug()))
    } else if name.trim() != name {
        Some(format!("the name `{shown}` begins or ends with a space; remove it"))
    } else if name.chars().any(unprintable) {
        Some(format!(
            "the name `{shown}` has a character that no file can show (line separators, U+FFFE); remove it"
        ))
    } else if name.starts_with('\'') && unprefixed(name) != name {
        Some(format!("the name `{shown}` begins with an apostrophe and a sign; remove the apostrophe"))
    } else if name.contains([',', '"', '#']) || name.chars().any(char::is_control) {
        Some(format!(
            "the name `{shown}` cannot be used in a cell; use no commas, quotes, `#` or control characters"
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reserved_names() {
        for name in ["x", "rx", "time", "visit", "target", "payload", "qw", "sx", "fx", "approach_j1", "tool"]
        {
            assert!(joint_name_problem(name).is_some(), "{name}");
        }
        for name in ["", " a", "a,b", "a[b", "a\nb", &"a".repeat(201)] {
            assert!(joint_name_problem(name).is_some(), "{name}");
        }
        for name in ["j1", "theta", "roll", "shoulder pan", "α"] {
            assert_eq!(joint_name_problem(name), None);
        }
        assert_eq!(
            joint_name_problem("x").unwrap(),
            "a joint cannot be called `x`, which is a column of measurements with another meaning; rename it"
        );
    }
}
