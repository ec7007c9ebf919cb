//! Results in JSON that are the same but for rounding.

use serde_json::Value;

/// `Err` is the place of a difference. Lines of the file may be others, where it has comments; parameters are differences of large
/// numbers in mm.
pub fn result(a: &str, b: &str) -> Result<(), String> {
    let read = |text: &str| {
        let mut json: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let worst = json["worst"].as_array_mut().ok_or("no `worst`")?;
        worst.iter_mut().for_each(|error| drop(error["line"].take()));
        json["parameters"].take();
        Ok::<_, String>(json)
    };
    near(&read(a)?, &read(b)?, "")
}

/// Numbers to 1e-6 of their size, and of what is next to nothing beside it.
fn near(a: &Value, b: &Value, at: &str) -> Result<(), String> {
    let same = match (a, b) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            return a.iter().zip(b).enumerate().try_for_each(|(k, (a, b))| near(a, b, &format!("{at}/{k}")));
        }
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            return a.iter().try_for_each(|(key, a)| near(a, &b[key], &format!("{at}/{key}")));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            // A gap above round-off is a ratio to round-off: its order of magnitude is all that it tells.
            let gap = a.min(b) > 1e10;
            if gap { a.max(b) < 10.0 * a.min(b) } else { (a - b).abs() <= 1e-6 * a.abs().max(b.abs()) + 1e-9 }
        }
        (a, b) => a == b,
    };
    if same { Ok(()) } else { Err(format!("{at}: {a} and {b}")) }
}
