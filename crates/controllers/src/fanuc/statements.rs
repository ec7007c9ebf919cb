//! The statements of the section /MN: `12:L P[3] 100mm/sec FINE ;`, with lines that go on behind a bare `:`.

use crate::lines::Line;

/// Words behind which lines are left out or run in another order.
const JUMPS: [&str; 6] = ["JMP", "SPRUNG", "IF", "WENN", "SELECT", "FOR"];

/// Whether lines behind a statement may be left out or run in another order.
pub(super) fn jumps(text: &str) -> bool {
    JUMPS.iter().any(|word| text.starts_with(word))
}

/// Statements without comments, with their first lines.
pub(super) fn statements(lines: &[Line<'_>]) -> Vec<(String, usize)> {
    let mut all: Vec<(String, usize)> = Vec::new();
    let mut open = false;
    for line in lines {
        let text = String::from_utf8_lossy(line.trimmed());
        let unnumbered = text.trim_start_matches(|c: char| c.is_ascii_digit());
        let numbered = unnumbered.len() < text.len();
        // A line without its colon is none of the language, but it must not hide a motion.
        let rest = unnumbered.strip_prefix(':').unwrap_or(unnumbered).trim();
        if let Some((statement, _)) = all.last_mut().filter(|_| open && !numbered) {
            statement.push(' ');
            statement.push_str(rest);
        } else {
            all.push((rest.to_owned(), line.number));
        }
        open = !rest.ends_with(';') && !all.last().is_some_and(|(text, _)| is_comment(text));
    }
    all.retain(|(text, _)| !text.is_empty() && !is_comment(text));
    all
}

fn is_comment(text: &str) -> bool {
    text.starts_with(['!', '/', '-'])
}

/// The beginning of a statement, for messages.
pub(super) fn shown(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches(" ;").chars().take(60).collect()
}

/// Names of the programs that a statement calls or runs.
pub(super) fn called(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '-')));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let calls = |pair: &&[&str]| matches!(pair[0], "CALL" | "AUFRUF" | "RUN");
    words.windows(2).filter(calls).map(|pair| pair[1].to_uppercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::lines;

    #[test]
    fn a_statement_ends_at_its_semicolon_or_the_next_number() {
        let text = ":L P[1] 100mm/sec FINE ;\n:L P[2] 100mm/sec FINE ;\n  1:C P[3]\n   :  P[4] 5mm/sec FINE ;\n  2:!note\n   :J P[5] ;\nL P[6] 5mm/sec FINE ;\n  3:  IF R[1]=1,CALL A-1 ;\n";
        let found = statements(&lines(text.as_bytes()));
        let lines: Vec<usize> = found.iter().map(|(_, line)| *line).collect();
        assert_eq!(lines, [1, 2, 3, 6, 7, 8]);
        assert_eq!(found[2].0, "C P[3] P[4] 5mm/sec FINE ;");
        assert_eq!(called(&found[5].0), ["A-1"]);
    }
}
