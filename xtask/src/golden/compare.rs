//! Two snapshots: equal, equal but for the last digits of numbers, or different.

/// Numbers agree to this part of their size, sums of a list to this part of its norm, and below 1e-15 all do.
const SAME: f64 = 1e-9;

#[derive(Debug, PartialEq)]
pub enum Level {
    SameBytes,
    /// All words are the same, and numbers agree.
    SameFindings,
    /// Where the first difference is, and how many lines differ.
    Different(String),
}

pub fn compare(before: &str, now: &str) -> Level {
    if before == now {
        return Level::SameBytes;
    }
    let kept = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|line| !line.trim_start_matches("! ").starts_with("sha256 "))
            .map(String::from)
            .collect()
    };
    let (before, now) = (kept(before), kept(now));
    let differing: Vec<usize> = (0..before.len().max(now.len()))
        .filter(|&k| match (before.get(k), now.get(k)) {
            (Some(before), Some(now)) => !same_line(before, now),
            _ => true,
        })
        .collect();
    let Some(&first) = differing.first() else { return Level::SameFindings };
    let line = |lines: &[String]| lines.get(first).map_or("(no line)", String::as_str).to_owned();
    Level::Different(format!(
        "{} of {} lines differ, the first:\n  - {}\n  + {}",
        differing.len(),
        before.len().max(now.len()),
        line(&before),
        line(&now)
    ))
}

fn same_line(before: &str, now: &str) -> bool {
    let words = |line: &str| -> Vec<String> {
        line.split([' ', ',', '(', ')', '[', ']', '=', '"', ';']).map(String::from).collect()
    };
    let (before, now) = (words(before), words(now));
    let mut norm = 0.0f64;
    before.len() == now.len()
        && before.iter().zip(&now).enumerate().all(|(k, (a, b))| {
            let (Ok(x), Ok(y)) = (a.parse::<f64>(), b.parse::<f64>()) else { return a == b };
            let behind = k.checked_sub(1).map_or("", |k| before[k].as_str());
            let size = x.abs().max(y.abs()).max(if behind == "sum" { norm } else { 0.0 });
            if behind == "norm" {
                norm = size;
            }
            a == b || (x - y).abs() <= SAME * size || (x - y).abs() < 1e-15
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_digits_are_no_difference_and_words_are() {
        let before = "$ identify\nsha256 ab\n.rms 1.00000000000e0\n.c[9] n 9 norm 2.0 sum 1e-13\nadequate";
        let near = "$ identify\nsha256 cd\n.rms 1.00000000001e0\n.c[9] n 9 norm 2.0 sum -2e-13\nadequate";
        assert_eq!(compare(before, before), Level::SameBytes);
        assert_eq!(compare(before, near), Level::SameFindings);
        for other in [
            near.replace("adequate", "undecided"),
            near.replace("1.00000000001e0", "1.00000001e0"),
            near.replace("norm 2.0", "norm 2.1"),
        ] {
            assert!(matches!(compare(before, &other), Level::Different(_)), "{other}");
        }
        assert!(matches!(compare(before, &near.replace("\nadequate", "")), Level::Different(_)));
    }
}
