//! A sheet of an Excel workbook as lines of text, for the readers of text. Needs the feature `xlsx`.
//!
//! A row of the sheet is a line of the same number. Of several sheets, the one is read in which a row has the most names that the robot's table knows.

use super::names::Names;
use crate::IoError;
use std::path::Path;

/// Whether a file begins as a workbook does: it is a zip archive.
pub(super) fn is_workbook(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04")
}

/// Lines of text, and what there is to say about their origin.
#[cfg(not(feature = "xlsx"))]
pub(super) fn lines(path: &Path, _: Vec<u8>, _: &Names<'_>) -> Result<(Vec<u8>, Vec<String>), IoError> {
    let message = "is a workbook, which this program was built without: build it with `--features full`, or save the sheet as CSV";
    Err(IoError::file(path, message))
}

/// Lines of text, and what there is to say about their origin.
#[cfg(feature = "xlsx")]
pub(super) fn lines(
    path: &Path,
    bytes: Vec<u8>,
    names: &Names<'_>,
) -> Result<(Vec<u8>, Vec<String>), IoError> {
    use calamine::{Reader, Xlsx, open_workbook_from_rs};
    let wrong = |error: calamine::XlsxError| {
        IoError::file(path, format!("is no workbook that can be read ({error}); save the sheet as CSV"))
    };
    let mut book: Xlsx<_> = open_workbook_from_rs(std::io::Cursor::new(bytes)).map_err(wrong)?;
    let sheets = book.sheet_names();
    let mut best: Option<(usize, &str, String)> = None;
    for sheet in &sheets {
        let range = book.worksheet_range(sheet).map_err(wrong)?;
        let above = range.start().map_or(0, |(row, _)| row as usize);
        let mut text = "\n".repeat(above);
        let mut most = 0;
        for row in range.rows() {
            let cells: Vec<String> = row.iter().map(cell).collect();
            most = most.max(cells.iter().filter(|cell| !cell.is_empty() && names.knows(cell)).count());
            put(&mut text, &cells);
        }
        if best.as_ref().is_none_or(|(known, ..)| most > *known) {
            best = Some((most, sheet, text));
        }
    }
    let (_, sheet, text) = best.ok_or_else(|| IoError::file(path, "is a workbook without a sheet"))?;
    let remark = (sheets.len() > 1).then(|| format!("read from the sheet `{sheet}`"));
    Ok((text.into_bytes(), remark.into_iter().collect()))
}

/// A row as a line; an empty one as an empty line.
#[cfg(feature = "xlsx")]
fn put(text: &mut String, cells: &[String]) {
    if cells.iter().any(|cell| !cell.is_empty()) {
        for (k, cell) in cells.iter().enumerate() {
            if k > 0 {
                text.push(',');
            }
            if cell.contains([',', '"']) {
                text.push('"');
                text.push_str(&cell.replace('"', "\"\""));
                text.push('"');
            } else {
                text.push_str(cell);
            }
        }
    }
    text.push('\n');
}

/// A cell as text: numbers with all their digits, dates as in ISO 8601.
#[cfg(feature = "xlsx")]
fn cell(data: &calamine::Data) -> String {
    use calamine::Data;
    match data {
        Data::Empty => String::new(),
        Data::Int(value) => value.to_string(),
        Data::Float(value) => value.to_string(),
        Data::Bool(value) => u8::from(*value).to_string(),
        Data::DateTime(at) => {
            let (year, month, day, hour, minute, second, milli) = at.to_ymd_hms_milli();
            let clock = format!("{hour:02}:{minute:02}:{second:02}.{milli:03}");
            // A clock time alone is the fraction of a day.
            if at.as_f64() < 1.0 { clock } else { format!("{year:04}-{month:02}-{day:02}T{clock}") }
        }
        Data::Error(error) => error.to_string(),
        Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => {
            text.trim().replace(char::is_control, " ")
        }
    }
}
