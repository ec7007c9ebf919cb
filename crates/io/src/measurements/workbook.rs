//! A sheet of an Excel workbook as lines of text, for the readers of text. Needs the feature `xlsx`.
//!
//! A row of the sheet is a line of the same number. Of several sheets, the one is read in which a row has the most names that the robot's table knows.
//! Cells are collected one by one, never as a rectangle: what a far cell spans is bounded before it is allocated ([`super::unpacked`]: what the
//! archive unpacks to).

use super::names::Names;
#[cfg(feature = "xlsx")]
use super::sheet::Sheet;
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
    use calamine::{Reader, Xlsx, XlsxError, open_workbook_from_rs};
    let wrong = |error: XlsxError| {
        IoError::file(path, format!("is no workbook that can be read ({error}); save the sheet as CSV"))
    };
    let refused = |words: String| IoError::file(path, words);
    super::unpacked::bounded(&bytes).map_err(refused)?;
    let mut book: Xlsx<_> = open_workbook_from_rs(std::io::Cursor::new(bytes)).map_err(wrong)?;
    let sheets = book.sheet_names();
    let mut best: Option<(usize, &str, String)> = None;
    for name in &sheets {
        let mut sheet = Sheet::default();
        match book.worksheet_cells_reader(name) {
            Ok(mut cells) => {
                while let Some(of) = cells.next_cell().map_err(wrong)? {
                    let text = cell(&of.get_value().clone().into());
                    sheet.add(of.get_position(), &text).map_err(refused)?;
                }
            }
            // A sheet of charts has no cells.
            Err(XlsxError::NotAWorksheet(_)) => {}
            Err(error) => return Err(wrong(error)),
        }
        let most = sheet.known(|cell| names.knows(cell));
        let text = sheet.text().map_err(refused)?;
        if best.as_ref().is_none_or(|(known, ..)| most > *known) {
            best = Some((most, name, text));
        }
    }
    let (_, sheet, text) = best.ok_or_else(|| IoError::file(path, "is a workbook without a sheet"))?;
    let remark = (sheets.len() > 1).then(|| format!("read from the sheet `{sheet}`"));
    Ok((text.into_bytes(), remark.into_iter().collect()))
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
