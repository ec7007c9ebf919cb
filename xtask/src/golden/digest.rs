//! Files in a form that a person can read and that numbers can be compared in.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Longer lists are given by their number of entries, norm and sum.
const LONGEST: usize = 6;
/// Lines of a text that are kept whole.
const LINES: usize = 60;

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// What a command printed; JSON like a file of it.
pub fn printed(text: &str) -> String {
    match serde_json::from_str::<Value>(text) {
        Ok(value @ (Value::Object(_) | Value::Array(_))) => json(&value),
        _ => without_times(text),
    }
}

/// The text without the last column of its tables where that is a time, under a heading that ends with `ms`.
fn without_times(text: &str) -> String {
    let mut timed = false;
    text.split_inclusive('\n').fold(String::new(), |all, line| {
        let cells: Vec<&str> = line.split_whitespace().collect();
        timed = if timed { cells.len() > 1 } else { cells.len() > 1 && cells.last() == Some(&"ms") };
        let last = line.trim_end().rfind(' ').filter(|_| timed && cells.last() != Some(&"ms"));
        all + &last.map_or_else(|| line.to_owned(), |at| line[..at].trim_end().to_owned() + "\n")
    })
}

/// The digest of a file: lines of figures for JSON and CSV, words for pages, nothing for pictures, the beginning for other texts.
pub fn readable(name: &str, bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "json" => serde_json::from_str(&text).map_or_else(|error| error.to_string(), |value| json(&value)),
        "csv" => csv(&text),
        "html" => page(&text),
        "svg" | "png" => String::new(),
        _ => text.lines().take(LINES).fold(String::new(), |all, line| all + line + "\n"),
    }
}

fn number(value: f64) -> String {
    format!("{value:.11e}")
}

fn sums(values: &[f64]) -> String {
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    format!("n {} norm {} sum {}", values.len(), number(norm), number(values.iter().sum()))
}

fn json(value: &Value) -> String {
    let mut lines = String::new();
    flat(value, "", &mut lines);
    lines
}

fn flat(value: &Value, path: &str, lines: &mut String) {
    match value {
        Value::Object(entries) if !entries.is_empty() => {
            for (key, inner) in entries {
                flat(inner, &format!("{path}.{key}"), lines);
            }
        }
        Value::Array(entries) if entries.len() > LONGEST => {
            let (mut numbers, mut words) = (Vec::new(), String::new());
            gather(value, &mut numbers, &mut words);
            let words = if words.is_empty() {
                String::new()
            } else {
                format!(" words {}", &sha256(words.as_bytes())[..16])
            };
            let _ = writeln!(lines, "{path}[{}] {}{words}", entries.len(), sums(&numbers));
        }
        Value::Array(entries) if !entries.is_empty() => {
            for (k, inner) in entries.iter().enumerate() {
                flat(inner, &format!("{path}[{k}]"), lines);
            }
        }
        Value::Number(given) if given.is_f64() => {
            let _ = writeln!(lines, "{path} {}", number(given.as_f64().unwrap_or(f64::NAN)));
        }
        // Digests of files have their own lines.
        Value::String(word) if word.len() == 64 && word.bytes().all(|b| b.is_ascii_hexdigit()) => {
            let _ = writeln!(lines, "sha256 {word} {path}");
        }
        other => {
            let _ = writeln!(lines, "{path} {other}");
        }
    }
}

fn gather(value: &Value, numbers: &mut Vec<f64>, words: &mut String) {
    match value {
        Value::Object(entries) => entries.iter().for_each(|(key, inner)| {
            words.push_str(key);
            gather(inner, numbers, words);
        }),
        Value::Array(entries) => entries.iter().for_each(|inner| gather(inner, numbers, words)),
        Value::Number(given) => numbers.extend(given.as_f64()),
        Value::String(word) => words.push_str(word),
        other => words.push_str(&other.to_string()),
    }
}

/// Number of rows, and for each column its numbers' sums or the hash of its words.
fn csv(text: &str) -> String {
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = rows.next().unwrap_or_default().split(',').collect();
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    let mut lines = format!("rows {}\n", rows.len());
    for (k, name) in names.iter().enumerate() {
        let cells: Vec<&str> = rows.iter().filter_map(|row| row.get(k).copied()).collect();
        let numbers: Vec<f64> = cells.iter().filter_map(|cell| cell.parse().ok()).collect();
        let words: String = cells.iter().filter(|cell| cell.parse::<f64>().is_err()).copied().collect();
        let words = if words.is_empty() {
            String::new()
        } else {
            format!(" words {}", &sha256(words.as_bytes())[..16])
        };
        let _ = writeln!(lines, "{name} {}{words}", sums(&numbers));
    }
    lines
}

/// Words of a page, without pictures, styles and scripts.
fn page(html: &str) -> String {
    let mut rest = html;
    let mut text = String::new();
    while let Some((before, tag)) = rest.split_once('<') {
        text.push_str(before);
        let skipped = ["svg", "style", "script"].iter().find(|name| tag.starts_with(**name));
        let end = skipped.map_or(Some(">".into()), |name| Some(format!("</{name}>")));
        let (_, after) = end.and_then(|end| tag.split_once(end.as_str())).unwrap_or_default();
        text.push(
            if ["td", "th", "/td", "/th", "span", "/span", "b>", "/b>"].iter().any(|t| tag.starts_with(t)) {
                ' '
            } else {
                '\n'
            },
        );
        rest = after;
    }
    text.push_str(rest);
    text.lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|line| !line.is_empty())
        .fold(String::new(), |all, line| all + &line + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_no_part_of_a_table() {
        let text = "a: b, ms per fit\n  solver  rank   ms\n  qr        36  9.5\n  svd       36   12\n\nrank 36 9.5\n";
        assert_eq!(
            printed(text),
            "a: b, ms per fit\n  solver  rank   ms\n  qr        36\n  svd       36\n\nrank 36 9.5\n"
        );
    }

    #[test]
    fn lists_become_sums_and_pages_words() {
        let text = readable("a.json", br#"{"a":{"b":[3.0,4.0,0.0,0.0,0.0,0.0,0.0],"c":"x","d":[0.5,true]}}"#);
        assert_eq!(
            text,
            ".a.b[7] n 7 norm 5.00000000000e0 sum 7.00000000000e0\n.a.c \"x\"\n.a.d[0] 5.00000000000e-1\n.a.d[1] true\n"
        );
        assert_eq!(readable("a.html", b"<h1>A <i>b</i></h1><svg><text>no</text></svg>c"), "A\nb\nc\n");
        let table = readable("a.csv", b"x,name\n3,a\n4,b\n");
        assert!(
            table.starts_with("rows 2\nx n 2 norm 5.00000000000e0 sum 7.00000000000e0\nname n 0 "),
            "{table}"
        );
    }
}
