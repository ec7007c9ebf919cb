//! A row of names that begins with `#`: a column that is called so, or a comment above rows without names.

use super::cut::{is_row_of_numbers, split};
use super::skipped;

/// Whether a line begins with a cell `#`, as tables number their rows; `# ` begins a comment.
pub(super) fn begins_with_a_number_sign(line: &str) -> bool {
    let mut rest = line.strip_prefix('#').unwrap_or_default().chars();
    let Some(separator) = rest.next().filter(|c| [',', ';', '\t', '|'].contains(c)) else { return false };
    rest.any(|c| c == separator)
}

/// The names of a header, whose line may be a comment.
pub(super) fn cells(line: &str, separator: char) -> Vec<String> {
    match line.trim_start_matches([' ', '\t']).strip_prefix('#') {
        Some(rest) if !rest.starts_with(separator) || separator == ' ' => {
            split(rest.trim_start_matches('#').trim_start(), separator)
        }
        _ => split(line, separator),
    }
}

/// The comment nearest above a row of numbers that has a name for each of them.
pub(super) fn in_a_comment(text: &str, row: usize, separator: char, count: usize) -> Option<usize> {
    let above: Vec<&str> = text.lines().take(row).collect();
    let names = |line: &str| {
        let cells = cells(line, separator);
        line.contains('#') && cells.len() == count && !is_row_of_numbers(&cells)
    };
    let comments = above.iter().enumerate().rev().take_while(|(_, line)| skipped(line));
    comments.filter(|(_, line)| names(line)).map(|(at, _)| at).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_a_comment() {
        let text = "# run of 11 March\n# q1 q2 x\n#\n1 2 3\n";
        assert_eq!(in_a_comment(text, 3, ' ', 3), Some(1));
        assert_eq!(cells("# q1 q2 x", ' '), ["q1", "q2", "x"]);
        assert_eq!(in_a_comment("#q1,q2,x\n1,2,3\n", 1, ',', 3), Some(0));
        assert_eq!(in_a_comment("# a comment\n1,2,3\n", 1, ',', 3), None);
        assert_eq!(in_a_comment("# 4,5,6\n1,2,3\n", 1, ',', 3), None);
    }

    #[test]
    fn a_column_of_numbers_of_rows() {
        assert!(begins_with_a_number_sign("#;Zeit;x"));
        assert!(!begins_with_a_number_sign("# a; comment; of three parts"));
        assert_eq!(cells("#;Zeit;x", ';'), ["#", "Zeit", "x"]);
    }
}
