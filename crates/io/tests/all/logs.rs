//! Tables of logs and inspection programs: columns between blanks, names in a comment, units below names, thousands, commanded values.

use truepose_errormodel::Dataset;
use truepose_io::{ColumnMap, MeasurementsOptions, read_measurements};
use truepose_kinematics::samples;

type Read = Result<(Dataset, String), String>;

/// A table of a robot of four joints, r1, r2, slide, r4.
fn read_with(text: &str, names: &[(&str, &str)]) -> Read {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, text).unwrap();
    let here = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let names = names.iter().map(|(ours, theirs)| ((*ours).to_owned(), (*theirs).to_owned())).collect();
    let columns = ColumnMap { names, ..ColumnMap::default() };
    let options = MeasurementsOptions { columns, ..MeasurementsOptions::default() };
    read_measurements(&path, &samples::scara(), &options)
        .map(|(data, _, warnings)| {
            let said: Vec<String> = warnings.iter().map(|w| here(w.to_string())).collect();
            (data, said.join("\n"))
        })
        .map_err(|error| here(error.to_string()))
}

fn read(text: &str) -> Read {
    read_with(text, &[])
}

/// 10.5°, -20.25°, 12.5 mm, 90° at 1234.5, -0.25, 100 mm.
#[track_caller]
fn is_right(data: &Dataset) {
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    let joints = [10.5f64.to_radians(), -20.25f64.to_radians(), 0.0125, 90f64.to_radians()];
    joints.into_iter().enumerate().for_each(|(k, q)| near(data.joints[k][0], q));
    [1.2345, -0.00025, 0.1].into_iter().zip(data.position[0]).for_each(|(wanted, found)| near(found, wanted));
}

const NAMES: &str = "r1[deg] r2[deg] slide[mm] r4[deg] x[mm] y[mm] z[mm]";
const ROWS: &str = "10.5 -20.25  12.5 90 1234.5 -0.25 100\n11.5 -21.25 13.5 -90 1334.5 0.75 101.125\n";

#[test]
fn columns_between_blanks() {
    let (data, said) = read(&format!("{NAMES}\n{ROWS}")).unwrap();
    is_right(&data);
    assert_eq!((data.line, said.as_str()), (vec![2, 3], "d.csv: read with columns separated by blanks"));
    let (data, said) = read(&format!("Log of Monday, hall 3\n{NAMES}\n{}", ROWS.replace('.', ","))).unwrap();
    is_right(&data);
    assert!(said.contains("separated by blanks, decimal commas, the header in line 2"), "{said}");
}

#[test]
fn names_in_a_comment_above_the_numbers() {
    for (separator, mark) in [(" ", "# "), (",", "#"), (";", "# ")] {
        let table = format!("# of Monday\n{mark}{NAMES}\n{ROWS}").replace("  ", " ").replace(' ', separator);
        let table = table.replacen(&format!("#{separator}"), "# ", 2);
        let (data, _) = read(&table).unwrap_or_else(|error| panic!("{table}{error}"));
        is_right(&data);
    }
    let said = read(&ROWS.replace("  ", " ").replace(' ', ",")).unwrap_err();
    assert!(
        said.contains("d.csv:1: holds numbers alone, where the names of the columns are expected"),
        "{said}"
    );
}

#[test]
fn a_column_called_number_sign_and_units_below_names() {
    let table = "Messprotokoll;;;;;;;\n#;r1;r2;slide;r4;Tracker;;\n;deg;deg;mm;deg;x [mm];y [mm];z [mm]\n\
                 1;10.5;-20.25;12.5;90;1234.5;-0.25;100\n;;;;;;;\nMittelwert;;;;;;;\n";
    let (data, said) = read(table).unwrap();
    is_right(&data);
    assert_eq!(data.len(), 1);
    assert!(said.contains("names completed from line 2"), "{said}");
    assert!(said.contains("lines that hold a text alone are not read: 6 (`Mittelwert`)"), "{said}");
}

#[test]
fn thousands_in_quotes() {
    let table = format!("{}\n10.5,-20.25,12.5,90,\"1,234.5\",-0.25,100\n", NAMES.replace(' ', ","));
    is_right(&read(&table).unwrap().0);
    // One of two readings is asked back.
    let said = read(&table.replace("\"1,234.5\"", "\"1,234\"")).unwrap_err();
    assert!(said.contains("is 1.234 or 1234"), "{said}");
}

#[test]
fn empty_columns_are_left_out_and_temperatures_are_known() {
    let table =
        format!("{},Remark,Oil (°C)\n10.5,-20.25,12.5,90,1234.5,-0.25,100,,21.5\n", NAMES.replace(' ', ","));
    let (data, said) = read(&table).unwrap();
    is_right(&data);
    assert!(said.contains("column `Remark` (8): is empty, and is not read"), "{said}");
    let [oil] = &data.schema.channels[..] else { panic!("{:?}", data.schema.channels) };
    assert!((oil.name.as_str(), oil.temperature) == ("Oil", true), "{oil:?}");
}

#[test]
fn deviations_are_no_channels() {
    let table = format!(
        "{},Nominal X,Nominal Y,Nominal Z,Dev X,Dev Y,Dev Z\n10.5,-20.25,12.5,90,1234.5,-0.25,100,1,2,3,.1,.2,.3\n",
        NAMES.replace(' ', ",")
    );
    let (_, said) = read(&table).unwrap();
    assert!(said.contains("columns are read as channels that are none"), "{said}");
    assert!(
        said.contains(
            "ignore = [\"Nominal X\", \"Nominal Y\", \"Nominal Z\", \"Dev X\", \"Dev Y\", \"Dev Z\"]"
        ),
        "{said}"
    );
}

#[test]
fn targets_of_the_file_are_proposed_with_their_deviations() {
    let mut table =
        String::from("r1[deg],r2[deg],slide[mm],r4[deg],Reflector,X,Y,Z,Sigma X,Sigma Y,Sigma Z\n");
    for k in 0..9 {
        let target = ["R1", "R2", "R3"][k % 3];
        table +=
            &format!("10.5,{k},12.5,90,{target},{},{},{},0.02,0.02,0.02\n", 900 - 60 * k, 80 * k, 10 * k);
    }
    let said = read(&table).unwrap_or_else(|error| (Dataset::default(), error)).1;
    for words in [
        "target = \"Reflector\"",
        "sx = \"Sigma X[mm]\"",
        "[[targets]]\nname = \"R1\"\nknown = false\n[[targets]]\nname = \"R2\"",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("ignore"), "{said}");
}

#[test]
fn a_row_for_each_coordinate_is_said_to_be_one() {
    let rows: String = (0..9).map(|k| format!("10.5,{k},12.5,90,{},{k}\n", ["X", "Y", "Z"][k % 3])).collect();
    let said = read(&format!("r1[deg],r2[deg],slide[mm],r4[deg],Control,Meas\n{rows}")).unwrap_err();
    assert!(said.contains("`Control` names coordinates, with a row for each"), "{said}");
}
