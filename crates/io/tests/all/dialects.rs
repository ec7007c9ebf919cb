//! Exports as ten offices write them: each is read, at the latest after what the first error proposes.

use truepose_errormodel::Dataset;
use truepose_io::{ColumnMap, MeasurementsOptions, OrientationConvention, read_measurements};
use truepose_kinematics::{Chain, Load, Pose, Target, nalgebra::Vector3, samples};

/// A robot of four joints, r1, r2, slide, r4, with two targets.
fn robot() -> Chain {
    let target = |name: &str| Target {
        name: name.into(),
        position: Vector3::zeros(),
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    samples::scara().with_targets(vec![target("P1"), target("P2")]).unwrap()
}

type Read = Result<(Dataset, Vec<String>), String>;

fn read_with(bytes: &[u8], columns: ColumnMap) -> Read {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, bytes).unwrap();
    let here = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let options = MeasurementsOptions { columns, ..MeasurementsOptions::default() };
    read_measurements(&path, &robot(), &options)
        .map(|(data, _, warnings)| (data, warnings.iter().map(|w| here(w.to_string())).collect()))
        .map_err(|error| here(error.to_string()))
}

fn read(bytes: &[u8]) -> Read {
    read_with(bytes, ColumnMap::default())
}

/// The two rows that every office measured: 10.5° and -20.25°, 12.5 mm, 90°; 1234.5, -0.25, 100 mm; and another one.
#[track_caller]
fn is_right(data: &Dataset) {
    assert_eq!(data.len(), 2);
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    for (row, joints, position) in [
        (0, [10.5f64, -20.25, 12.5, 90.0], [1234.5, -0.25, 100.0]),
        (1, [11.5, -21.25, 13.5, -90.0], [1334.5, 0.75, 101.125]),
    ] {
        for (joint, value) in joints.into_iter().enumerate() {
            let wanted = if joint == 2 { value / 1e3 } else { value.to_radians() };
            near(data.joints[joint][row], wanted);
        }
        for (found, wanted) in data.position[row].into_iter().zip(position) {
            near(found, wanted / 1e3);
        }
    }
}

/// The mappings that a message proposes.
fn proposed(message: &str) -> ColumnMap {
    let pairs = message.split("--map \"").skip(1).filter_map(|rest| rest.split('"').next()?.split_once('='));
    let names = pairs.map(|(name, column)| (name.to_owned(), column.to_owned())).collect();
    ColumnMap { names, ..ColumnMap::default() }
}

const PLAIN: &str = "r1[deg],r2[deg],slide[mm],r4[deg],x[mm],y[mm],z[mm]\n\
                     10.5,-20.25,12.5,90,1234.5,-0.25,100\n11.5,-21.25,13.5,-90,1334.5,0.75,101.125\n";

#[test]
fn german_spreadsheet() {
    let text = "r1[deg];r2[deg];slide[mm];r4[deg];x[mm];y[mm];z[mm];;\r\n\
                10,5;-20,25;12,5;90;1.234,5;-0,25;100;;\r\n11,5;-21,25;13,5;-90;1334,5;0,75;101,125;;\r\n;;;;;;;;\r\n";
    let (data, warnings) = read(text.as_bytes()).unwrap();
    is_right(&data);
    assert_eq!(data.line, [2, 3]);
    assert_eq!(warnings, ["d.csv: read with columns separated by `;`, decimal commas"]);
    let mut marked = b"\xef\xbb\xbf".to_vec();
    marked.extend_from_slice(text.as_bytes());
    is_right(&read(&marked).unwrap().0);
}

#[test]
fn unicode_text_of_a_spreadsheet() {
    let text = PLAIN.replace(',', "\t").replace('\n', "\r\n");
    for mark in [true, false] {
        let units: Vec<u16> = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16()).collect();
        let bytes: Vec<u8> = units.into_iter().flat_map(u16::to_le_bytes).collect();
        is_right(&read(&bytes).unwrap().0);
    }
}

#[test]
fn latin_1_with_degree_signs_and_a_row_of_units() {
    let text = "Me\u{df}protokoll, Halle 3\nr1;r2;slide;r4;x;y;z;Pr\u{fc}fer\n\u{b0};\u{b0};mm;\u{b0};mm;mm;mm;\n\
                10,5;-20,25;12,5;90;1234,5;-0,25;100;M\u{fc}ller\n11,5;-21,25;13,5;-90;1334,5;0,75;101,125;M\u{fc}ller\n";
    let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let (data, warnings) = read(&bytes).unwrap();
    is_right(&data);
    assert_eq!(data.line, [4, 5]);
    assert_eq!(
        warnings,
        [
            "d.csv: read with text in Windows-1252 (Latin-1), columns separated by `;`, decimal commas, the units in line 3, \
             the header in line 2",
            "d.csv:2: column `Prüfer` (8): holds text, and is not read",
        ]
    );
}

#[test]
fn titles_above_the_header_and_trailing_separators() {
    let text = format!("Robot 7, cell B\nOperator: A. Nother,2024-03-11\n\n{}", PLAIN.replace('\n', ",\n"));
    let (data, _) = read(text.as_bytes()).unwrap();
    is_right(&data);
    assert_eq!(data.line, [5, 6]);
    // In the rows alone.
    let (header, rows) = PLAIN.split_once('\n').unwrap();
    is_right(&read(format!("{header}\n{}", rows.replace('\n', ",,\n")).as_bytes()).unwrap().0);
    let more = format!("{header}\n{}", rows.replace('\n', ",7\n"));
    assert!(read(more.as_bytes()).unwrap_err().contains("d.csv:2: the row has 8 cells, the header 7"));
}

#[test]
fn names_of_a_controller() {
    let text = PLAIN.replace(
        "r1[deg],r2[deg],slide[mm],r4[deg],x[mm],y[mm],z[mm]",
        "A1 (°),A2 (°),A3 (mm),A4 (°),X (mm),Y (mm),Z (mm)",
    );
    let error = read(text.as_bytes()).unwrap_err();
    let begins = "d.csv:1: joints `r1`, `r2`, `slide`, `r4` have no columns (columns here: A1 (°), ";
    assert!(error.starts_with(begins) && error.contains("\nperhaps they are meant by: --map"), "{error}");
    is_right(&read_with(text.as_bytes(), proposed(&error)).unwrap().0);
}

#[test]
fn names_of_an_instrument() {
    let text = PLAIN.replace(
        "r1[deg],r2[deg],slide[mm],r4[deg],x[mm],y[mm],z[mm]",
        "Joint 1[degrees],Joint 2[degrees],Joint 3[millimeters],Joint 4[degrees],Pos X mm,Pos Y mm,Pos Z mm",
    );
    let error = read(text.as_bytes()).unwrap_err();
    is_right(&read_with(text.as_bytes(), proposed(&error)).unwrap().0);
}

#[test]
fn dates_texts_and_empty_columns() {
    let (header, rows) = PLAIN.split_once('\n').unwrap();
    let mut rows = rows.lines();
    let text = format!(
        "{header},target,,time,remark\n{},P1,,11.03.2024 08:15:00,ok\n{},P2,,11.03.2024 08:15:30,\n",
        rows.next().unwrap(),
        rows.next().unwrap()
    );
    let (data, warnings) = read(text.as_bytes()).unwrap();
    is_right(&data);
    assert!((data.time[1] - data.time[0] - 30.0).abs() < 1e-6);
    assert_eq!(
        warnings,
        [
            "d.csv:1: column `time` (10): holds dates or clock times, and is read in seconds",
            "d.csv:1: column `remark` (11): holds text, and is not read",
        ]
    );
}

#[test]
fn spellings_of_units() {
    let text = PLAIN.replace(
        "r1[deg],r2[deg],slide[mm],r4[deg],x[mm],y[mm],z[mm]",
        "r1 [°],r2°,slide_mm,r4 (deg),x / mm,y in mm,z(mm)",
    );
    is_right(&read(text.as_bytes()).unwrap().0);
}

#[test]
fn quoted_decimal_commas() {
    let text = "r1[deg],r2[deg],slide[mm],r4[deg],x[mm],y[mm],z[mm]\n\
                \"10,5\",\"-20,25\",\"12,5\",90,\"1234,5\",\"-0,25\",100\n\"11,5\",\"-21,25\",\"13,5\",-90,\"1334,5\",\"0,75\",\"101,125\"\n";
    is_right(&read(text.as_bytes()).unwrap().0);
}

#[test]
fn thousands_between_marks_that_separate_no_decimals() {
    for grouped in ["1'234.5", "1\u{2019}234.5", "1 234.5", "1\u{202f}234.5"] {
        let (data, warnings) = read(PLAIN.replace("1234.5", grouped).as_bytes()).unwrap();
        is_right(&data);
        assert!(warnings.iter().any(|w| w.contains("read with thousands separated by ")), "{warnings:?}");
    }
    // With decimal commas: of a Swiss and of a French office.
    for mark in ["'", "\u{a0}"] {
        let text = PLAIN.replace(',', ";").replace('.', ",").replace("1234,5", &format!("1{mark}234,5"));
        is_right(&read(text.as_bytes()).unwrap().0);
    }
}

/// [`PLAIN`] with a further column: its header and its two cells.
fn with_a_column(header: &str, cells: [&str; 2]) -> String {
    let ends = [header, cells[0], cells[1]];
    PLAIN.lines().zip(ends).map(|(line, end)| format!("{line},{end}\n")).collect()
}

#[test]
fn the_only_mass_is_what_is_carried() {
    let payloads = |data: &Dataset| -> Vec<(f64, [f64; 3])> {
        let one = |load: &Load| match load {
            Load::Payload(payload) => (payload.mass, payload.com.into()),
            _ => (f64::NAN, [f64::NAN; 3]),
        };
        data.load.iter().map(one).collect()
    };
    let text = with_a_column("Last [kg]", ["0", "12"]);
    let (data, warnings) = read(text.as_bytes()).unwrap();
    is_right(&data);
    assert_eq!(payloads(&data), [(0.0, [0.0; 3]), (12.0, [0.0; 3])]);
    assert!(warnings.iter().any(|w| w.contains("`Last [kg]` is read as payload")), "{warnings:?}");
    // The same centre of gravity in all rows.
    let centre = ColumnMap { names: vec![("cz".into(), "120mm".into())], ..ColumnMap::default() };
    let (data, warnings) = read_with(text.as_bytes(), centre).unwrap();
    assert_eq!(payloads(&data)[1], (12.0, [0.0, 0.0, 0.12]));
    assert!(
        !warnings.iter().any(|w| w.contains("centre of gravity") || w.contains("not in this file")),
        "{warnings:?}"
    );
    // Left out, or called something else, it is none.
    let ignored = ColumnMap { ignore: vec!["Last".into()], ..ColumnMap::default() };
    assert!(payloads(&read_with(text.as_bytes(), ignored).unwrap().0)[1].0.is_nan());
    let named = ColumnMap { names: vec![("flow".into(), "Last [kg]".into())], ..ColumnMap::default() };
    let (data, _) = read_with(text.as_bytes(), named).unwrap();
    assert_eq!((payloads(&data)[1].0.is_nan(), data.schema.channels[0].name.as_str()), (true, "flow"));
    // One of two is asked back.
    let two = text
        .replace("Last [kg]", "Last [kg],Werkzeug [kg]")
        .replace(",0\n", ",0,3\n")
        .replace(",12\n", ",12,3\n");
    let (data, warnings) = read(two.as_bytes()).unwrap();
    assert!(payloads(&data)[1].0.is_nan() && !warnings.iter().any(|w| w.contains("is read as payload")));
    // Without a unit it is proposed.
    let (_, warnings) = read(with_a_column("Nutzlast", ["0", "12"]).as_bytes()).unwrap();
    assert!(warnings.iter().any(|w| w.contains("--map \"payload=Nutzlast[kg]\"")), "{warnings:?}");
}

#[test]
fn rows_that_are_not_used() {
    let text = format!("{PLAIN}99,0,0,0,0,1,2\n");
    let exclude = ColumnMap { exclude: vec![4], ..ColumnMap::default() };
    is_right(&read_with(text.as_bytes(), exclude).unwrap().0);
    let mut lines = text.lines();
    let text = format!(
        "{},use\n{},1\n{},yes\n{}broken,0\n",
        lines.next().unwrap(),
        lines.next().unwrap(),
        lines.next().unwrap(),
        lines.next().unwrap()
    );
    is_right(&read(text.as_bytes()).unwrap().0);
}

#[test]
fn two_readings_are_asked_back() {
    let text = "r1[deg];r2[deg];slide[mm];r4[deg];x[mm];y[mm];z[mm]\n10,5;-20,25;12,5;90;1.234;-0,25;100\n";
    assert_eq!(
        read(text.as_bytes()).unwrap_err(),
        "d.csv:2: column `x[mm]` (5): `1.234` is 1.234 or 1234: other numbers have decimal commas; write the number in a \
         form that has one reading"
    );
    let text = "r1[deg];r2[deg];slide[mm];r4[deg];x[mm];y[mm];z[mm]\n10;20;12;90;1,234;2,345;100\n";
    let error = read(text.as_bytes()).unwrap_err();
    assert!(error.contains("`1,234` is 1.234 or 1234: no number of the file shows which"), "{error}");
    // Decimal points throughout: what has three decimals is a number like any other.
    let text = PLAIN.replace(',', ";");
    is_right(&read(text.as_bytes()).unwrap().0);
    let text = PLAIN.replace('\n', ",03/11/2024 08:15\n").replacen("03/11/2024 08:15", "time", 1);
    let error = read(text.as_bytes()).unwrap_err();
    assert!(error.contains("is 2024-11-03 or 2024-03-11"), "{error}");
}

#[test]
fn every_error_in_one_run() {
    let header = PLAIN.lines().next().unwrap();
    let text = format!("{header}\nabc,,1,2,3,4,5\n1,2,3,4,5,6,7\n1,2,3,4,5,6,seven\n1,2,3\n");
    assert_eq!(
        read(text.as_bytes()).unwrap_err(),
        "d.csv:2: column `r1[deg]` (1): `abc` is not a number\n\
         d.csv:2: column `r2[deg]` (2): is empty; every row needs all joint values\n\
         d.csv:4: column `z[mm]` (7): `seven` is not a number\n\
         d.csv:5: column `r4[deg]` (4): is missing: the row has 3 cells, the header 7"
    );
    let rows: String = (0..100).map(|_| "1,2,3,4,5,6,seven\n").collect();
    let error = read(format!("{header}\n{rows}").as_bytes()).unwrap_err();
    assert_eq!(error.lines().count(), 1);
    assert!(error.ends_with("`seven` is not a number; the same in 99 other rows"), "{error}");
    // Of the header as well.
    let text = PLAIN.replace("r1[deg]", "r1[furlong]").replace("x[mm]", "x[deg]");
    assert_eq!(read(text.as_bytes()).unwrap_err().lines().count(), 2);
}

#[test]
fn orientations_by_name() {
    let (header, rows) = PLAIN.split_once('\n').unwrap();
    let rotation = Pose::rot(2, 0.3).rotation * Pose::rot(1, 0.2).rotation * Pose::rot(0, 0.1).rotation;
    for (convention, names, cells) in [
        (OrientationConvention::Rpy, "rx[rad],ry[rad],rz[rad]", "0.1,0.2,0.3"),
        (OrientationConvention::FanucWpr, "W[rad],P[rad],R[rad]", "0.1,0.2,0.3"),
        (OrientationConvention::KukaAbc, "A[rad],B[rad],C[rad]", "0.3,0.2,0.1"),
    ] {
        let text = format!("{header},{names}\n{}", rows.replace('\n', &format!(",{cells}\n")));
        let columns = ColumnMap { orientation: Some(convention), ..ColumnMap::default() };
        let (data, warnings) = read_with(text.as_bytes(), columns).unwrap();
        is_right(&data);
        assert_eq!(warnings, Vec::<String>::new());
        let found = data.measured_rotation(0).unwrap();
        assert!((found - rotation).amax() < 1e-15, "{convention:?}");
    }
    let q = Pose::new(rotation, Vector3::zeros()).quaternion().map(|v| format!("{v:?}")).join(",");
    let text = format!("{header},q1,q2,q3,q4\n{}", rows.replace('\n', &format!(",{q}\n")));
    let columns =
        ColumnMap { orientation: Some(OrientationConvention::AbbQuaternion), ..ColumnMap::default() };
    let found = read_with(text.as_bytes(), columns).unwrap().0.measured_rotation(0).unwrap();
    assert!((found - rotation).amax() < 1e-12);
}

#[test]
fn entries_that_match_nothing_are_remarked_upon() {
    let pair = |ours: &str, theirs: &str| (ours.to_owned(), theirs.to_owned());
    let columns = ColumnMap {
        // The first is not needed, since the file has `r1`.
        names: vec![pair("r1", "Joint 1[deg]"), pair("time", "Clock[s]")],
        ignore: vec!["Operator".into()],
        ..ColumnMap::default()
    };
    let (data, warnings) = read_with(PLAIN.as_bytes(), columns).unwrap();
    is_right(&data);
    assert_eq!(
        warnings,
        [
            "d.csv:1: `time` is mapped to the column `Clock[s]`, which is not in this file",
            "d.csv:1: the column `Operator` is to be left out, and is not in this file",
        ]
    );
}

#[cfg(feature = "xlsx")]
#[test]
fn a_workbook() {
    let bytes = include_bytes!("workbooks/office.xlsx");
    let (data, warnings) = read(bytes).unwrap();
    is_right(&data);
    // 11 March 2024 is day 19793; rows of the sheet are lines.
    assert_eq!(data.line, [4, 5]);
    let morning = 19_793.0 * 86_400.0 + 8.25 * 3600.0;
    assert!(
        (data.time[0] - morning).abs() < 1e-3 && (data.time[1] - morning - 60.0).abs() < 1e-3,
        "{:?}",
        data.time
    );
    assert_eq!(
        warnings,
        [
            "d.csv: read from the sheet `Messung 3`",
            "d.csv: read with the header in line 3",
            "d.csv:3: column `time` (8): holds dates or clock times, and is read in seconds",
            "d.csv:3: column `Operator` (9): holds text, and is not read",
        ]
    );
    // Whatever happened to a byte, nothing panics.
    for at in (0..bytes.len()).step_by(11) {
        let mut other = bytes.to_vec();
        other[at] ^= 0x55;
        let _ = read(&other);
    }
    // A workbook that ends early is refused.
    let error = read(&bytes[..bytes.len() / 2]).unwrap_err();
    assert!(error.contains("d.csv: is no workbook that can be read"), "{error}");
}

#[test]
fn names_of_rows_are_passed_through() {
    use truepose_io::{
        CommandRow, CommandStatus, MeasurementsReader, Prediction, read_poses, write_commands,
        write_predictions,
    };
    let folder = tempfile::tempdir().unwrap();
    let (path, out) = (folder.path().join("d.csv"), folder.path().join("o.csv"));
    let named =
        PLAIN.replacen("r1", "id,r1", 1).replace("\n10.5", "\nP-07,10.5").replace("\n11.5", "\n12,11.5");
    std::fs::write(&path, &named).unwrap();
    let chain = robot();
    let (data, info, warnings) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
    is_right(&data);
    // It is no channel, and nothing to remark upon.
    assert_eq!(
        (info.ids.as_slice(), data.schema.channels.len(), warnings.len()),
        (&["P-07".to_owned(), "12".into()][..], 0, 0)
    );
    let predicted =
        vec![Prediction { pose: Pose::IDENTITY, oriented: false, within_95: 0.0, extrapolates: false }; 2];
    write_predictions(&out, &chain, &data, &info, &predicted).unwrap();
    let first_cells = || -> Vec<String> {
        let text = std::fs::read_to_string(&out).unwrap();
        text.lines().map(|line| line.split(',').next().unwrap().to_owned()).collect()
    };
    assert_eq!(first_cells(), ["id", "P-07", "12"]);
    let (poses, ..) = read_poses(&path, &chain, &ColumnMap::default()).unwrap();
    let command = CommandRow {
        joints: vec![0.0; 4],
        status: CommandStatus::Ok,
        within_95: 0.0,
        corrected: true,
        beyond: String::new(),
    };
    write_commands(&out, &chain, &poses, &[command.clone(), command]).unwrap();
    assert_eq!(first_cells(), ["id", "P-07", "12"]);
    // Row by row, where a block ends between visits.
    let mut reader = MeasurementsReader::open(&path, &chain, &MeasurementsOptions::default()).unwrap();
    let mut block = Dataset::default();
    for name in ["P-07", "12"] {
        assert_eq!(reader.read_block(1, &mut block).unwrap(), 1);
        assert_eq!(reader.block_ids(), [name]);
    }
}
