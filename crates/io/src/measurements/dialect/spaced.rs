//! Columns separated by blanks, as logs of controllers and numerical programs have them.

use super::cut::{is_row_of_numbers, split};

/// The line of the header and the separator, where most lines are rows of numbers between blanks and no other mark separates them; where no
/// line above has a name for each, the first row of numbers.
pub(super) fn table(lines: &[(usize, &str)]) -> Option<(usize, char)> {
    let cut = |line: &str| -> Option<Vec<String>> {
        let apart = !line.contains(['\t', ';', '|']);
        let cells = split(line, ' ');
        let ended = cells.iter().any(|cell| cell.ends_with(',') || cell.starts_with(','));
        (apart && cells.len() > 2 && !ended && is_row_of_numbers(&cells)).then_some(cells)
    };
    let count = cut(lines.last()?.1)?.len();
    let is_row = |line: &str| cut(line).is_some_and(|cells| cells.len() == count);
    if 2 * lines.iter().filter(|(_, line)| is_row(line)).count() < lines.len() {
        return None;
    }
    let first = lines.iter().position(|(_, line)| is_row(line))?;
    let header = lines[..first].iter().rev().find(|(_, line)| split(line, ' ').len() == count);
    Some((header.unwrap_or(&lines[first]).0, ' '))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Option<(usize, char)> {
        let lines: Vec<(usize, &str)> = text.lines().enumerate().collect();
        table(&lines)
    }

    #[test]
    fn rows_of_numbers_between_blanks() {
        assert_eq!(of("a log\nq1 q2 x\n1 2 3\n1.5  -2 3e-3\n"), Some((1, ' ')));
        assert_eq!(of("q1 q2 x\n1,5 2,0 3\n1,5 -2,1 3\n"), Some((0, ' ')));
        assert_eq!(of("1 2 3\n1 2 3\n"), Some((0, ' ')));
        for other in
            ["q1, q2, x\n1, 2, 3\n4, 5, 6\n", "a b c\nd e f\n", "a b\n1 2\n1 2\n", "x\ty\tz\n1\t2\t3\n"]
        {
            assert_eq!(of(other), None, "{other}");
        }
    }
}
