//! Groups as a person reads them: `y@j2 − 0.612 m·turn(j2)`.

use super::groups::Group;
use super::priority::column_word;
use truepose_errormodel::ErrorModel;

/// A grouped error in words, with coefficients in SI units, and the sign with which its coefficient is what the words say: −1 where they begin
/// with the motion of a joint whose axis is a negative one of its frame.
pub fn group_words(model: &ErrorModel, group: &Group) -> (String, f64) {
    let (head, head_sign) = column_word(model, group.column);
    let unit = &model.columns()[group.column].unit;
    let mut text = head;
    for &(column, coefficient) in &group.members {
        let (word, sign) = column_word(model, column);
        let value = coefficient * sign * head_sign;
        let minus = value < 0.0;
        text.push_str(if minus { " − " } else { " + " });
        let ratio = ratio_unit(unit, &model.columns()[column].unit);
        let number = number(value.abs());
        match (number.as_str(), ratio.as_str()) {
            ("1", "") => {}
            (_, "") => text.push_str(&format!("{number}·")),
            _ => text.push_str(&format!("{number} {ratio}·")),
        }
        text.push_str(&word);
    }
    (text, head_sign)
}

/// Unit of a coefficient; radians count as numbers, so that a lever arm is in metres.
fn ratio_unit(kept: &str, dropped: &str) -> String {
    match (kept, dropped) {
        (a, b) if a == b => String::new(),
        ("m", "rad") => "m".into(),
        ("rad", "m") => "1/m".into(),
        (a, b) => format!("({a})/({b})"),
    }
}

fn number(value: f64) -> String {
    let digits = if (0.01..100.0).contains(&value) { format!("{value:.4}") } else { format!("{value:.3e}") };
    if digits.contains('e') || !digits.contains('.') {
        return digits;
    }
    digits.trim_end_matches('0').trim_end_matches('.').into()
}
