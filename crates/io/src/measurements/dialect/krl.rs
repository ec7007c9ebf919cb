//! Logs of a KUKA controller: rows of structures, `{E6AXIS: A1 50.2, A2 …} {FRAME: X 1802.3, …, C 8.4}`.
//!
//! Lengths are mm and angles degrees, as everywhere in KRL. Text in front of the structures names the row.

use super::Rewritten;
use crate::IoError;
use std::path::Path;

/// Words of a structure: axes, and poses.
const AXES: [&str; 2] = ["AXIS", "E6AXIS"];
const POSES: [&str; 3] = ["FRAME", "POS", "E6POS"];

/// Whether a line has a structure.
pub(super) fn has(line: &str) -> bool {
    AXES.iter()
        .chain(&POSES)
        .any(|word| line.contains(&format!("{{{word}:")) || line.contains(&format!("{{{word} :")))
}

/// A column's name, and the number.
type Field = (String, String);

/// The structures of a line as columns and texts of numbers, and the text in front of them.
fn fields(line: &str) -> Result<(String, Vec<Field>), String> {
    let (before, mut rest) = line.split_once('{').ok_or("has no structure such as {E6AXIS: A1 0, …}")?;
    let mut all: Vec<Field> = Vec::new();
    loop {
        let (inside, after) =
            rest.split_once('}').ok_or("has a structure that does not end; close it with `}`")?;
        let (word, parts) =
            inside.split_once(':').ok_or("has a structure without a word such as `FRAME:`")?;
        let word = word.trim();
        let axes = AXES.contains(&word);
        if !axes && !POSES.contains(&word) {
            return Err(format!("has a structure `{word}`; AXIS, E6AXIS, FRAME, POS and E6POS are read"));
        }
        for part in parts.split(',').map(str::trim) {
            let (name, number) = part
                .split_once(char::is_whitespace)
                .ok_or(format!("has `{part}` where a name and a number belong"))?;
            let number = number.trim();
            if number.parse::<f64>().is_err() {
                return Err(format!("has `{number}`, which is not a number, for {name} of {word}"));
            }
            let unit = match name {
                "X" | "Y" | "Z" => "mm",
                // Status and turn say how the robot stands, and not where.
                "S" | "T" => continue,
                _ if axes || ["A", "B", "C"].contains(&name) => "deg",
                // An external axis of a pose may be a slide or a table.
                _ => "1",
            };
            let header = if unit == "1" { name.to_owned() } else { format!("{name}[{unit}]") };
            match all.iter_mut().filter(|(known, _)| *known == header).count() {
                0 => all.push((header, number.to_owned())),
                _ if axes || unit == "1" => {
                    return Err(format!("has {name} twice; a row has one structure of axes"));
                }
                _ => return Err(format!("has {name} of {word} twice; keep the measured pose alone")),
            }
        }
        match after.split_once('{') {
            Some((_, next)) => rest = next,
            None => {
                return Ok((
                    before.trim().trim_end_matches([',', ';', '=', ':']).trim().replace(['"', ','], " "),
                    all,
                ));
            }
        }
    }
}

/// The whole text as a table; lines of comments stay empty.
///
/// # Errors
/// At the first line that is no row of the log.
pub(super) fn rewrite(file: &Path, text: &str) -> Result<Rewritten, IoError> {
    let (mut out, mut names, mut first, mut header_line) = (String::new(), Vec::new(), 0, None);
    let mut moved = Vec::new();
    let mut body: Vec<String> = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let bare = line.trim();
        if !bare.contains('{') && (names.is_empty() || bare.is_empty() || bare.starts_with([';', '&', '#'])) {
            body.push(String::new());
            continue;
        }
        let wrong = |message: String| IoError::line(file, at as u64 + 1, message);
        let (id, all) = fields(bare).map_err(wrong)?;
        if names.is_empty() {
            names = all.iter().map(|(name, _)| name.clone()).collect();
            first = at;
            header_line = at.checked_sub(1);
        }
        let here: Vec<String> = all.iter().map(|(name, _)| name.clone()).collect();
        if here != names {
            let message = format!("has {}, and line {} has {}", here.join(" "), first + 1, names.join(" "));
            return Err(IoError::line(file, at as u64 + 1, message));
        }
        moved.push(id.clone());
        let numbers: Vec<String> = all.into_iter().map(|(_, number)| number).collect();
        body.push(format!("{id},{}", numbers.join(",")));
    }
    let named = moved.iter().any(|id| !id.is_empty());
    let header = format!("{},{}", if named { "id" } else { "" }, names.join(","));
    if header_line.is_none() {
        out.push_str(&header);
        out.push('\n');
    }
    for (at, line) in body.iter().enumerate() {
        out.push_str(if Some(at) == header_line { &header } else { line });
        out.push('\n');
    }
    let remark = format!("read with structures of KRL as columns: {} (mm, deg)", names.join(" "));
    Ok(Rewritten { text: out.into_bytes(), remarks: vec![remark], header_added: header_line.is_none() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<String, String> {
        rewrite(Path::new("k.log"), text)
            .map(|found| String::from_utf8(found.text).unwrap())
            .map_err(|error| error.to_string())
    }

    #[test]
    fn rows_of_structures() {
        let rows = "; a log\n7 {E6AXIS: A1 1.5, A2 -2} {FRAME: X 1, Y 2, Z 3, A 4, B 5, C 6}\n\n";
        assert_eq!(
            of(rows).unwrap(),
            "id,A1[deg],A2[deg],X[mm],Y[mm],Z[mm],A[deg],B[deg],C[deg]\n7,1.5,-2,1,2,3,4,5,6\n\n"
        );
        assert_eq!(of("{AXIS: A1 1}\n{AXIS: A1 2}\n").unwrap(), ",A1[deg]\n,1\n,2\n");
    }

    #[test]
    fn lines_that_are_no_rows() {
        for (text, message) in [
            ("{AXIS: A1 1}\n{AXIS: A1 1", "k.log:2: has a structure that does not end; close it with `}`"),
            ("{AXIS: A1 1}\nend", "k.log:2: has no structure such as {E6AXIS: A1 0, …}"),
            ("{AXIS: A1 1}\n{AXIS: A2 1}", "k.log:2: has A2[deg], and line 1 has A1[deg]"),
            ("{AXIS: A1 x}", "k.log:1: has `x`, which is not a number, for A1 of AXIS"),
            (
                "{LOAD: M 1} {AXIS: A1 1}",
                "k.log:1: has a structure `LOAD`; AXIS, E6AXIS, FRAME, POS and E6POS are read",
            ),
        ] {
            assert_eq!(of(text).unwrap_err(), message);
        }
    }
}
