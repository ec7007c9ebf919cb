//! Cells of a line: where they end, and the numbers in them.

use crate::Unit;
use std::borrow::Cow;

/// Why a line cannot be cut into cells.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Unquoted;

/// The cell that begins at `at`, without blanks and quotes around it, and where its comma (or the line's end) is.
pub(crate) fn cell(line: &[u8], at: usize) -> Result<(Cow<'_, str>, usize), Unquoted> {
    let rest = &line[at..];
    let blanks = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    if rest.get(blanks) != Some(&b'"') {
        let end = memchr::memchr(b',', rest).unwrap_or(rest.len());
        // Lines are UTF-8 and commas are characters, so that this never replaces anything.
        let text = match String::from_utf8_lossy(&rest[..end]) {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_string()),
        };
        return Ok((text, at + end));
    }
    let mut text = Vec::new();
    let mut k = blanks + 1;
    loop {
        match (rest.get(k), rest.get(k + 1)) {
            (None, _) => return Err(Unquoted),
            (Some(b'"'), Some(b'"')) => {
                text.push(b'"');
                k += 2;
            }
            (Some(b'"'), _) => break,
            (Some(&byte), _) => {
                text.push(byte);
                k += 1;
            }
        }
    }
    k += 1;
    k += rest[k..].iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    match rest.get(k) {
        None | Some(b',') => Ok((Cow::Owned(String::from_utf8_lossy(&text).trim().to_string()), at + k)),
        Some(_) => Err(Unquoted),
    }
}

/// All cells of a line.
pub(crate) fn cells(line: &[u8]) -> Result<Vec<Cow<'_, str>>, Unquoted> {
    let mut all = Vec::new();
    let mut at = 0;
    loop {
        let (text, end) = cell(line, at)?;
        all.push(text);
        if end == line.len() {
            return Ok(all);
        }
        at = end + 1;
    }
}

/// A finite number that begins directly at `at` and fills its cell, and where the cell ends: the common case.
#[inline]
pub(crate) fn plain_number(line: &[u8], at: usize) -> Option<(f64, usize)> {
    let rest = line.get(at..)?;
    // Tables are full of zeros.
    if let [digit @ b'0'..=b'9', b',', ..] | [digit @ b'0'..=b'9'] = rest {
        return Some((f64::from(digit - b'0'), at + 1));
    }
    if !matches!(rest.first()?, b'0'..=b'9' | b'-' | b'.') {
        return None;
    }
    let (value, length) = fast_float2::parse_partial::<f64, _>(rest).ok()?;
    let ends = matches!(rest.get(length), None | Some(b','));
    (ends && value.is_finite()).then_some((value, at + length))
}

/// The number in a cell's text; none for an empty cell.
///
/// # Errors
/// What is wrong with the text.
pub(crate) fn number(text: &str) -> Result<Option<f64>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    let digits = text.strip_prefix('+').filter(|rest| !rest.starts_with(['+', '-'])).unwrap_or(text);
    match fast_float2::parse::<f64, _>(digits) {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        Ok(_) if text.contains(|c: char| c.is_ascii_digit()) => {
            Err(format!("`{}` is too large for a number", shown(text)))
        }
        Ok(_) => Err(format!(
            "`{}` is not a finite number; leave the cell empty if nothing was measured",
            shown(text)
        )),
        Err(_) => Err(format!("`{}` is not a number{}", shown(text), advice(text))),
    }
}

/// What to do about a text that is no number.
#[cold]
fn advice(text: &str) -> &'static str {
    let reads = |text: &str| fast_float2::parse::<f64, _>(text).is_ok();
    let blank = |c: char| matches!(c, ' ' | '\'' | '\u{2019}' | '\u{a0}' | '\u{202f}');
    let units = text.trim_start_matches(|c: char| c.is_ascii_digit() || "+-.".contains(c)).trim_start();
    if matches!(text.to_lowercase().as_str(), "na" | "n/a" | "null" | "none" | "-") {
        "; leave the cell empty if nothing was measured"
    } else if decimal_comma(text) {
        "; write decimals with a point"
    } else if reads(&text.replace(['\u{2212}', '\u{2013}'], "-")) {
        "; write its minus as `-`"
    } else if reads(&text.replace(blank, "").replace(',', ""))
        && text.starts_with(|c: char| c.is_ascii_digit() || c == '-')
    {
        "; write it without separators between thousands"
    } else if reads(text.trim_end_matches(units).trim_end()) && Unit::named(units).is_some() {
        "; put the unit into the header, as in `x[mm]`"
    } else if Unit::named(text).is_some() {
        "; if this is a row of units, put them into the header, as in `x[mm]`"
    } else if text.split(':').count() > 1 && text.chars().all(|c| c.is_ascii_digit() || ":.-T ".contains(c)) {
        "; write a time as seconds"
    } else {
        ""
    }
}

/// `1,5`, and not `1,234.5`.
fn decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && fast_float2::parse::<f64, _>(text.replace(',', ".")).is_ok()
}

/// A text for a message: printable and not too long.
pub(crate) fn shown(text: &str) -> String {
    let one = |c: char| {
        let plain = matches!(c, '\'' | '"' | '\\');
        plain.then_some(c).into_iter().chain(c.escape_debug().take(if plain { 0 } else { 12 }))
    };
    let mut shown: String = text.chars().take(40).flat_map(one).collect();
    if text.chars().nth(40).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lines_are_cut() {
        let cut = |line: &str| cells(line.as_bytes()).map(|all| all.join("|"));
        assert_eq!(cut("a, b ,c").unwrap(), "a|b|c");
        assert_eq!(cut("").unwrap(), "");
        assert_eq!(cut(",").unwrap(), "|");
        assert_eq!(cut("\"a,b\", \"c\"\"d\" ,").unwrap(), "a,b|c\"d|");
        assert_eq!(cut("\"a"), Err(Unquoted));
        assert_eq!(cut("\"a\"b,c"), Err(Unquoted));
        assert_eq!(cut("a\"b,c").unwrap(), "a\"b|c");
    }

    #[test]
    fn numbers_and_what_is_none() {
        assert_eq!(number("+1.5").unwrap(), Some(1.5));
        assert_eq!(number("").unwrap(), None);
        for (text, message) in [
            ("abc", "`abc` is not a number"),
            ("nan", "`nan` is not a finite number; leave the cell empty if nothing was measured"),
            ("-inf", "`-inf` is not a finite number; leave the cell empty if nothing was measured"),
            ("1e999", "`1e999` is too large for a number"),
            ("1,5", "`1,5` is not a number; write decimals with a point"),
            ("1 234.5", "`1 234.5` is not a number; write it without separators between thousands"),
            ("1,234.5", "`1,234.5` is not a number; write it without separators between thousands"),
            ("1'234.5", "`1'234.5` is not a number; write it without separators between thousands"),
            ("\u{2212}1.5", "`\u{2212}1.5` is not a number; write its minus as `-`"),
            ("12.5 mm", "`12.5 mm` is not a number; put the unit into the header, as in `x[mm]`"),
            (
                "deg",
                "`deg` is not a number; if this is a row of units, put them into the header, as in `x[mm]`",
            ),
            ("12:30:05", "`12:30:05` is not a number; write a time as seconds"),
            ("1/2", "`1/2` is not a number"),
            ("+-1", "`+-1` is not a number"),
            ("0x10", "`0x10` is not a number"),
            ("N/A", "`N/A` is not a number; leave the cell empty if nothing was measured"),
        ] {
            assert_eq!(number(text).unwrap_err(), message);
        }
        assert_eq!(plain_number(b"1.5,2", 0), Some((1.5, 3)));
        assert_eq!(plain_number(b"1.5,2", 4), Some((2.0, 5)));
        for other in ["", " 1", "1 ", "x", "nan", "inf", "1e999", "-inf", "1x", "\"1\""] {
            assert_eq!(plain_number(other.as_bytes(), 0), None, "{other}");
        }
    }

    proptest! {
        #[test]
        fn digits_are_read_exactly(value in prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO) {
            let text = format!("{value:?}");
            prop_assert_eq!(plain_number(text.as_bytes(), 0).map(|(v, n)| (v.to_bits(), n)), Some((value.to_bits(), text.len())));
            prop_assert_eq!(number(&text).unwrap().map(f64::to_bits), Some(value.to_bits()));
        }

        #[test]
        fn nothing_makes_it_panic(line in ".{0,40}") {
            let _ = cells(line.as_bytes());
            let _ = number(&line);
            let _ = plain_number(line.as_bytes(), 0);
        }
    }
}
