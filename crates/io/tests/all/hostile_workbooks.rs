//! Workbooks that take more memory than a table may: refused with a message, before anything is allocated.

use std::io::{Cursor, Write};
use truepose_io::{MeasurementsOptions, read_measurements};
use truepose_kinematics::{JointKind, samples};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";

/// A workbook of one sheet.
fn book(dimension: &str, rows: &str, strings: &str) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let parts = [
        (
            "_rels/.rels",
            format!(
                "<Relationships xmlns=\"{PACKAGE}\"><Relationship Id=\"r1\" Type=\"{OFFICE}/officeDocument\" \
                 Target=\"xl/workbook.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{OFFICE}\"><sheets><sheet name=\"s\" sheetId=\"1\" r:id=\"r1\"/>\
                 </sheets></workbook>"
            ),
        ),
        (
            "xl/_rels/workbook.xml.rels",
            format!(
                "<Relationships xmlns=\"{PACKAGE}\"><Relationship Id=\"r1\" Type=\"{OFFICE}/worksheet\" \
                 Target=\"worksheets/sheet1.xml\"/></Relationships>"
            ),
        ),
        ("xl/sharedStrings.xml", format!("<sst xmlns=\"{MAIN}\" {strings}</sst>")),
        (
            "xl/worksheets/sheet1.xml",
            format!("<worksheet xmlns=\"{MAIN}\">{dimension}<sheetData>{rows}</sheetData></worksheet>"),
        ),
    ];
    for (name, text) in parts {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A row of texts and numbers from column A on.
fn row(number: usize, cells: &[&str]) -> String {
    let cell = |(k, text): (usize, &&str)| {
        let at = char::from(b'A' + k as u8);
        format!("<c r=\"{at}{number}\" t=\"inlineStr\"><is><t>{text}</t></is></c>")
    };
    format!("<row r=\"{number}\">{}</row>", cells.iter().enumerate().map(cell).collect::<String>())
}

/// Three measurements, and these cells behind them.
fn table(more: &str) -> String {
    let chain = samples::scara();
    let names: Vec<String> = chain
        .movable()
        .iter()
        .map(|&j| {
            format!(
                "{}[{}]",
                chain.joint(j).name,
                if chain.joint(j).kind == JointKind::Prismatic { "m" } else { "rad" }
            )
        })
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).chain(["x[m]", "y[m]", "z[m]"]).collect();
    let mut rows = row(1, &names);
    for k in 2..5 {
        let values: Vec<String> = (0..names.len()).map(|c| format!("0.{k}{c}")).collect();
        rows += &row(k, &values.iter().map(String::as_str).collect::<Vec<_>>());
    }
    rows + more
}

fn read(bytes: &[u8]) -> Result<usize, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.xlsx");
    std::fs::write(&path, bytes).unwrap();
    let chain = samples::scara();
    let read = read_measurements(&path, &chain, &MeasurementsOptions::default());
    read.map(|(data, ..)| data.len())
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

const NO_STRINGS: &str = "><si/>";

#[test]
fn a_good_workbook_is_read_whatever_its_dimension_declares() {
    for dimension in ["", "<dimension ref=\"A1:E4\"/>", "<dimension ref=\"A1:XFD1048576\"/>"] {
        assert_eq!(read(&book(dimension, &table(""), NO_STRINGS)), Ok(3), "{dimension}");
    }
}

#[test]
fn cells_at_the_end_of_a_sheet_and_beyond_are_no_rectangle() {
    let last = "<row r=\"1048576\"><c r=\"XFD1048576\"><v>1</v></c></row>";
    let error = read(&book("", &table(last), NO_STRINGS)).unwrap_err();
    assert!(error.contains("16384 columns are more than a table of measurements has"), "{error}");
    for beyond in ["XFE1", "A1048577", "ZZZZZZZZ1", "A99999999999"] {
        let cell = format!("<row><c r=\"{beyond}\"><v>1</v></c></row>");
        let error = read(&book("", &table(&cell), NO_STRINGS)).unwrap_err();
        assert_eq!(error, format!("d.xlsx: has a cell `{beyond}`; a sheet ends at XFD1048576"));
    }
    let back = read(&book("<dimension ref=\"C3:A1\"/>", &table(""), NO_STRINGS)).unwrap_err();
    assert_eq!(back, "d.xlsx: has a cell `C3:A1`; a sheet ends at XFD1048576");
}

#[test]
fn counts_that_are_declared_are_not_allocated() {
    let absurd = read(&book("", &table(""), "uniqueCount=\"18446744073709551615\"><si/>")).unwrap_err();
    assert!(absurd.contains("declares 18446744073709551615 shared texts"), "{absurd}");
}

#[test]
fn what_unpacks_to_much_more_is_refused() {
    let long = format!("><si><t>{}</t></si>", "x".repeat(3 << 20));
    let bytes = book("", &table(""), &long);
    assert!(bytes.len() < 20_000);
    assert!(read(&bytes).unwrap_err().contains("has a text of more than 1 MiB"));
    let many = format!(">{}", "<si/>".repeat(12 << 20));
    let error = read(&book("", &table(""), &many)).unwrap_err();
    assert!(error.contains("unpacks to more than 512 MiB"), "{error}");
}
