//! A number of a program: where it stands, and how another one is written in its place.
//!
//! The new number has as many decimals as the old one, and at least those that its quantity needs; a column that was padded with blanks
//! keeps its width as long as one blank is left. `.5` stays without its leading zero, `+5` keeps its sign.

use std::ops::Range;

/// A number in the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slot {
    /// Its bytes, with its sign, and with the blanks in front of it where there are two or more.
    pub(crate) range: Range<usize>,
    pub(crate) form: Form,
}

/// How a number is written.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// Decimal fraction with at least so many decimals.
    Real(usize),
    /// Whole number.
    Whole,
    /// KRL's `'B0101'`.
    Bits,
    /// An attribute that is absent, because it is zero: its name, and the least decimals.
    Absent(&'static str, usize),
}

impl Slot {
    /// The number of a range of a text; padding is taken in.
    pub(crate) fn padded(text: &[u8], range: Range<usize>, form: Form) -> Slot {
        let blanks = text[..range.start].iter().rev().take_while(|&&byte| byte == b' ').count();
        let start = if blanks >= 2 { range.start - blanks } else { range.start };
        Slot { range: start..range.end, form }
    }

    /// What stands there when the number is this one.
    pub(crate) fn written(&self, text: &[u8], value: f64) -> String {
        let old = String::from_utf8_lossy(&text[self.range.clone()]).into_owned();
        let digits = old.trim_start();
        let decimals = decimals_of(digits);
        let new = match self.form {
            Form::Real(least) => real(digits, value, decimals.max(least)),
            Form::Whole => format!("{value:.0}"),
            Form::Bits => bits(digits, value),
            Form::Absent(name, least) => format!(" {name}=\"{}\"", real("0", value, least)),
        };
        let before = self.range.start.checked_sub(1).map_or(b' ', |before| text[before]);
        match old.len() - digits.len() {
            // `X+5` is X and +5; `X5` would be a name.
            0 if is_word(before) && new.starts_with(is_word_start) => format!(" {new}"),
            0 => new,
            _ => format!(" {new:>width$}", width = old.len() - 1),
        }
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

fn is_word_start(c: char) -> bool {
    c.is_ascii_digit() || c == '.'
}

/// Digits behind the point; a number with an exponent counts as having none.
fn decimals_of(digits: &str) -> usize {
    if digits.contains(['e', 'E']) {
        return 0;
    }
    digits.split_once('.').map_or(0, |(_, behind)| behind.len())
}

fn real(old: &str, value: f64, decimals: usize) -> String {
    let mut new = format!("{value:.decimals$}");
    if !new.contains(|c: char| c.is_ascii_digit() && c != '0') {
        new = new.trim_start_matches('-').into();
    }
    if old.ends_with('.') && decimals == 0 {
        new.push('.');
    }
    let (sign, unsigned) = new.strip_prefix('-').map_or(("", new.as_str()), |rest| ("-", rest));
    let bare = old.trim_start_matches(['+', '-']).starts_with('.');
    let unsigned = if bare { unsigned.strip_prefix('0').unwrap_or(unsigned) } else { unsigned };
    let sign = if sign.is_empty() && old.starts_with('+') { "+" } else { sign };
    format!("{sign}{unsigned}")
}

/// `'B0101'` with as many digits as it had.
fn bits(old: &str, value: f64) -> String {
    let width = old.chars().filter(|c| matches!(c, '0' | '1')).count();
    let letter = if old.contains('b') { 'b' } else { 'B' };
    format!("'{letter}{:0width$b}'", value as u64)
}

/// The value of a decimal number as controllers write it, and its length in bytes; signs directly in front of it belong to it.
pub(crate) fn number_at(text: &[u8]) -> Option<(f64, usize)> {
    let digits = |from: usize| text[from.min(text.len())..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if text.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return None;
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    if text.get(end).is_some_and(|&byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.')) {
        return None;
    }
    let shown = std::str::from_utf8(&text[..end]).ok()?;
    shown.parse::<f64>().ok().filter(|value| value.is_finite()).map(|value| (value, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn replaced(line: &str, number: &str, form: Form, value: f64) -> String {
        let at = line.rfind(number).unwrap();
        let slot = Slot::padded(line.as_bytes(), at..at + number.len(), form);
        let new = slot.written(line.as_bytes(), value);
        format!("{}{new}{}", &line[..slot.range.start], &line[slot.range.end..])
    }

    #[test]
    fn numbers_keep_their_look() {
        assert_eq!(replaced("{X 100,Y", "100", Form::Real(3), 100.1234), "{X 100.123,Y");
        assert_eq!(replaced("{X 100.000000,Y", "100.000000", Form::Real(3), 99.5), "{X 99.500000,Y");
        assert_eq!(replaced("X =   500.000  mm", "500.000", Form::Real(3), -1500.5), "X = -1500.500  mm");
        assert_eq!(replaced("Y =      .000  mm", ".000", Form::Real(3), -0.25), "Y =     -.250  mm");
        assert_eq!(replaced("Y =      .000  mm", ".000", Form::Real(3), 1.25), "Y =     1.250  mm");
        assert_eq!(replaced("[+5,", "+5", Form::Real(1), 4.96), "[+5.0,");
        assert_eq!(replaced("[1.5E+2,", "1.5E+2", Form::Real(3), 149.9), "[149.900,");
        assert_eq!(replaced("X  1,", "1", Form::Real(3), 123.456), "X 123.456,");
        assert_eq!(replaced("T 'B010',", "'B010'", Form::Bits, 35.0), "T 'B100011',");
        assert_eq!(replaced("[0,", "0", Form::Real(3), -0.0001), "[0.000,");
    }

    #[test]
    fn numbers_are_read_whole_or_not_at_all() {
        let of = |text: &str| number_at(text.as_bytes());
        assert_eq!(of("-1.5e-3,"), Some((-1.5e-3, 7)));
        assert_eq!(of(".5}"), Some((0.5, 2)));
        assert_eq!(of("5.]"), Some((5.0, 2)));
        for bad in ["", "-", ".", "1a", "1.2.3", "e5", "1e5x", "--1", "1e999"] {
            assert_eq!(of(bad), None, "{bad}");
        }
    }
}
