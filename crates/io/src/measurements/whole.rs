//! A whole file: rows, visits, directions of approach, and what is suspicious about them.

use super::copies::without;
use super::header::{Header, Needs};
use super::info::CsvInfo;
use super::mapping::ColumnMap;
use super::memory::MemoryTable;
use super::reader::{MeasurementsOptions, MeasurementsReader};
use super::suspicious;
use super::visits::{check_standstills, grouping};
use crate::{IoError, Warning};
use std::path::Path;
use truepose_errormodel::{Dataset, DwellTolerance, approach_from_order, configurations, visits_from_rows};
use truepose_kinematics::Chain;

/// Reads a file of measurements.
///
/// Directions of approach that the file does not state are derived from the order of its visits.
///
/// # Errors
/// When the file cannot be read, lacks a column, or at the first cell that is wrong.
pub fn read_measurements(
    path: impl AsRef<Path>,
    chain: &Chain,
    options: &MeasurementsOptions,
) -> Result<(Dataset, CsvInfo, Vec<Warning>), IoError> {
    measurements(From::File(path.as_ref()), chain, options)
}

/// Reads a table of measurements in memory: the same as a file of its columns.
///
/// # Errors
/// When it lacks a column, or at the first cell that is wrong, with its row (from 1) and column.
pub fn measurements_in_memory(
    table: MemoryTable,
    chain: &Chain,
    options: &MeasurementsOptions,
) -> Result<(Dataset, CsvInfo, Vec<Warning>), IoError> {
    measurements(From::Memory(table), chain, options)
}

fn measurements(
    from: From<'_>,
    chain: &Chain,
    options: &MeasurementsOptions,
) -> Result<(Dataset, CsvInfo, Vec<Warning>), IoError> {
    let needs = Needs { joints: true, measured: options.measured_required, position: false };
    let mut table = read_table(from, chain, needs, options.dwell, &options.columns)?;
    let data = &mut table.data;
    if !data.schema.approach {
        let derived = approach_from_order(data);
        for ((column, derived), slot) in
            data.approach.iter_mut().zip(derived).zip(&table.header.slots.approach)
        {
            if slot.is_none() {
                *column = derived;
            }
        }
        data.schema.approach = true;
    }
    Ok((table.data, table.info, table.warnings))
}

/// Where a whole table comes from.
pub(crate) enum From<'a> {
    File(&'a Path),
    Memory(MemoryTable),
}

/// A file as read, without derived columns.
pub(crate) struct Table {
    pub data: Dataset,
    pub header: Header,
    pub info: CsvInfo,
    pub warnings: Vec<Warning>,
}

pub(crate) fn read_table(
    from: From<'_>,
    chain: &Chain,
    needs: Needs,
    dwell: DwellTolerance,
    columns: &ColumnMap,
) -> Result<Table, IoError> {
    let mut reader = match from {
        From::File(path) => MeasurementsReader::open_for(path, chain, needs, dwell, columns)?,
        From::Memory(table) => MeasurementsReader::over_for(table, chain, needs, dwell, columns)?,
    };
    let mut data = reader.read_all()?;
    let mut info = reader.info();
    let numbered = reader.rows.header.slots.visit.is_some();
    if numbered {
        if needs.joints {
            check_standstills((&data, &reader.still), &info.visit_labels, &reader.rows.header)?;
        }
    } else {
        data.visit = visits_from_rows(&data);
        info.visits = data.visit.last().map_or(0, |last| last + 1);
    }
    if info.sessions.len() < 2 {
        data.set_sessions(None);
    }
    if info.landmarks.is_empty() {
        data.set_landmarks(None);
    }
    if (0..data.len()).all(|row| data.point(row).is_none()) {
        data.set_points(None);
    }
    if (0..data.len()).all(|row| data.kind(row).is_none()) {
        data.set_kinds(None, [None, None, None]);
    }
    let configuration = configurations(&data);
    info.configurations = configuration.iter().max().map_or(0, |last| last + 1);
    info.grouping = Some(grouping(&data, chain, &configuration, dwell, numbered));
    let mut warnings = std::mem::take(&mut reader.warnings);
    let copied = suspicious::look(&reader.read_so_far(), chain, &data, (needs, &info), &mut warnings);
    if !copied.is_empty() {
        data = without(&data, &copied, &mut info);
        let configuration = configurations(&data);
        info.configurations = configuration.iter().max().map_or(0, |last| last + 1);
        info.grouping = Some(grouping(&data, chain, &configuration, dwell, numbered));
    }
    Ok(Table { data, header: reader.rows.header, info, warnings })
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is tested as such
mod tests {
    use super::*;
    use truepose_kinematics::{Load, TargetId, samples};

    type Read = Result<(Dataset, CsvInfo, Vec<String>), String>;

    fn read_for(chain: &Chain, bytes: &[u8], options: &MeasurementsOptions) -> Read {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        std::fs::write(&path, bytes).unwrap();
        let here = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
        read_measurements(&path, chain, options)
            .map(|(data, info, warnings)| {
                data.validate(chain).unwrap();
                (data, info, warnings.iter().map(|w| here(w.to_string())).collect())
            })
            .map_err(|error| here(error.to_string()))
    }

    fn read(text: &str) -> Read {
        read_for(&samples::pps(), text.as_bytes(), &MeasurementsOptions::default())
    }

    const HEAD: &str = "d1[mm],d2[mm],d3[mm],theta[deg],roll[deg],pitch[mrad],x[mm],y[mm],z[in]";

    #[test]
    fn every_column_and_unit() {
        let text = format!(
            "# a comment\n{HEAD},target,visit,payload[lb],cx[mm],cy[um],cz[m],time[min],approach_d1,sx[um],sy[um],sz[um],\
             srx[mrad],sry[mrad],srz[mrad],rx[deg],ry[deg],rz[deg],oil[K],humidity[%],count\n\
             10,20,30,90,1,2,1,2,3,P2,7,10,1,2,3,1.5,-1,10,20,30,1,2,3,90,0,0,300,55,4\n\
             \n10,20,30,90,1,2,,,3,,7,10,1,2,3,2,1,,,,,,,,,,301,56,4\n"
        );
        let (data, info, warnings) = read(&text).unwrap();
        assert_eq!(warnings, Vec::<String>::new());
        let column = |values: &Vec<f64>| values[0];
        assert_eq!(
            data.joints.iter().map(column).collect::<Vec<_>>(),
            [0.01, 0.02, 0.03, std::f64::consts::FRAC_PI_2, 1f64.to_radians(), 0.002]
        );
        assert_eq!(data.position[0], [0.001, 0.002, 3.0 * 0.0254]);
        assert!(data.position[1][0].is_nan() && data.position[1][1].is_nan());
        assert_eq!(data.position_sd[0], [1e-5, 2e-5, 3e-5]);
        assert_eq!(data.orientation_sd[0], [1e-3, 2e-3, 3e-3]);
        assert!(data.orientation_sd[1][0].is_nan());
        let q = data.orientation[0].unwrap();
        assert!((q[0] - 0.5f64.sqrt()).abs() < 1e-15 && (q[1] - 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(data.orientation[1], None);
        assert_eq!(data.target, [Some(TargetId(1)), None]);
        assert_eq!((data.visit.as_slice(), data.line.as_slice()), (&[0, 0][..], &[3, 5][..]));
        let Load::Payload(payload) = data.load[0] else { panic!("a payload") };
        assert_eq!((payload.mass, payload.com.as_slice()), (10.0 * 0.45359237, &[0.001, 2e-6, 3.0][..]));
        assert_eq!(data.time, [90.0, 120.0]);
        assert_eq!(data.approach[0], [-1.0, 1.0]);
        assert_eq!(data.approach[1], [0.0, 0.0]);
        let channels: Vec<_> =
            data.schema.channels.iter().map(|c| (c.name.as_str(), c.unit.as_str(), c.temperature)).collect();
        assert_eq!(channels, [("oil", "degC", true), ("humidity", "%", false), ("count", "1", false)]);
        assert_eq!(data.channels, [[300.0 - 273.15, 301.0 - 273.15], [55.0, 56.0], [4.0, 4.0]]);
        assert!(data.schema.time && data.schema.load && data.schema.approach);
        assert_eq!((info.rows, info.visits, info.configurations), (2, 1, 1));
        assert_eq!(info.visit_labels, [7]);
        let oil = info.columns.iter().find(|c| c.name == "oil").unwrap();
        assert_eq!((oil.unit.as_str(), oil.filled, oil.range), ("K", 2, Some((300.0, 301.0))));
        assert_eq!(info.columns[6].filled, 1);
        assert_eq!(info.columns[6].meaning, "measured position, x");
    }

    #[test]
    fn wrenches_win_over_payloads() {
        let text = format!(
            "{HEAD},payload[kg],cx[m],cy[m],cz[m],fx[kN],fy[N],fz[lbf],tx[N*m],ty[Nm],tz[N*m]\n\
             1,2,3,4,1,2,1,2,3,5,0,0,0,1,2,3,4,5,6\n1,2,3,4,1,2,1,2,3,5,0,0,0,,,,,,\n1,2,3,4,1,2,1,2,3,0,,,,,,,,,\n"
        );
        let (data, info, warnings) = read(&text).unwrap();
        let Load::Wrench(wrench) = data.load[0] else { panic!("a wrench") };
        assert_eq!(wrench.force.as_slice(), [1000.0, 2.0, 3.0 * 4.4482216152605]);
        assert_eq!(wrench.moment.as_slice(), [4.0, 5.0, 6.0]);
        assert!(matches!(data.load[1], Load::Payload(payload) if payload.mass > 4.9));
        assert_eq!(info.visits, 3);
        assert_eq!(
            warnings,
            ["d.csv:1: column `payload[kg]` (10): is not used where a wrench (fx … tz) was measured"]
        );
    }

    /// A good row, in which one cell is replaced.
    fn spoiled(column: usize, cell: &str) -> String {
        let mut cells =
            vec!["1", "2", "3", "4", "1", "2", "1", "2", "3", "P1", "1", "0", "5", "1", "0", "0", "0", "20"];
        cells[column] = cell;
        let good = "1,2,3,4,1,2,1,2,3,P1,0,0,5,1,0,0,0,20\n";
        format!("{HEAD},target,visit,time[s],payload[kg],qw,qx,qy,qz,oil[degC]\n{good}{}\n", cells.join(","))
    }

    #[test]
    fn every_bad_cell_is_reported() {
        let cases: [(usize, &str, &str); 20] = [
            (3, "abc", "column `theta[deg]` (4): `abc` is not a number"),
            (3, "", "column `theta[deg]` (4): is empty; every row needs all joint values"),
            (
                3,
                "NaN",
                "column `theta[deg]` (4): `NaN` is not a finite number; leave the cell empty if nothing was measured",
            ),
            (
                6,
                "inf",
                "column `x[mm]` (7): `inf` is not a finite number; leave the cell empty if nothing was measured",
            ),
            (6, "1e999", "column `x[mm]` (7): `1e999` is too large for a number"),
            (
                6,
                "1 2345.6",
                "column `x[mm]` (7): `1 2345.6` is not a number; write it without separators between thousands",
            ),
            (6, "\"1", "column `x[mm]` (7): a quote in the cell does not end; close it"),
            (
                9,
                "P9",
                "column `target` (10): the robot has no target `P9`; declare it in [[targets]] (its targets: P1, P2, P3)",
            ),
            (10, "1.5", "column `visit` (11): the number of a visit is an integer, not 1.5"),
            (10, "", "column `visit` (11): is empty; every row needs a value"),
            (
                10,
                "0",
                "column `time[s]` (12)", // no error: the same visit
            ),
            (11, "", "column `time[s]` (12): is empty; every row needs a value"),
            (12, "-1", "column `payload[kg]` (13): a mass cannot be negative"),
            (12, "", "column `payload[kg]` (13): is empty; write 0 where nothing is carried"),
            (
                13,
                "0.9",
                "column `qw` (14): the quaternion has length 0.9, not 1; check the order qw qx qy qz",
            ),
            (13, "1.0005", ""),
            (
                15,
                "",
                "column `qy` (16): is empty while other cells of the quaternion are filled; fill or empty all of them",
            ),
            (
                17,
                "",
                "column `oil[degC]` (18): is empty; a channel needs a value in every row: fill it or remove the column",
            ),
            (17, "warm", "column `oil[degC]` (18): `warm` is not a number"),
            (3, "1e300", "column `theta[deg]` (4): 1e300 cannot be meant; check the number"),
        ];
        for (column, cell, message) in cases {
            match read(&spoiled(column, cell)) {
                Ok(_) => assert!(cell == "1.0005" || cell == "0", "{cell} passed"),
                Err(error) => assert_eq!(error, format!("d.csv:3: {message}")),
            }
        }
    }

    #[test]
    fn rows_and_files_that_are_wrong() {
        let row = "1,2,3,4,1,2,1,2,3";
        let error = |text: String| read(&text).unwrap_err();
        assert_eq!(
            error(format!("{HEAD}\n{row}\n1,2,3,4,1,2,1,2\n")),
            "d.csv:3: column `z[in]` (9): is missing: the row has 8 cells, the header 9"
        );
        assert_eq!(error(format!("{HEAD}\n{row},4\n")), "d.csv:2: the row has 10 cells, the header 9");
        assert_eq!(
            error(format!("{HEAD}\n1,5,2,5,3,5,4,5,1,5,2,5,1,5,2,5,3,5\n")),
            "d.csv:2: the row has 18 cells, the header 9; write decimals with a point, not a comma"
        );
        assert_eq!(
            error(String::new()),
            "d.csv: is empty; the first line names the columns, such as `theta[deg],x[mm]`"
        );
        assert_eq!(
            error(format!("# only\n{HEAD}\n\n# this\n")),
            "d.csv: has a header but no rows; add at least one row below the header"
        );
        assert_eq!(
            error(format!("{}\n{row}\n", HEAD.replace("x[mm]", "x[furlong]"))),
            "d.csv:1: column `x[furlong]` (7): unknown unit [furlong] (`x` is a length; its unit can be: m, mm, um, in)"
        );
        assert_eq!(
            error(format!("{}\n45,2,3,45,1,2,1,2,3\n", HEAD.replace("theta[deg]", "theta[rad]"))),
            "d.csv:2: column `theta[rad]` (4): 45 rad is far beyond the joint's limits, -1.5708 … 1.5708 rad, and looks \
             like degrees; if so, call the column `theta[deg]`"
        );
        assert_eq!(
            error(format!("{HEAD},approach_knee\n{row},1\n")),
            "d.csv:1: column `approach_knee` (10): the robot has no moving joint `knee` (its joints: d1, d2, d3, theta, \
             roll, pitch)"
        );
        assert_eq!(
            error(format!("{HEAD},approach_d1\n{row},2\n")),
            "d.csv:2: column `approach_d1` (10): a direction of approach is -1, 0 or 1, not 2"
        );
        assert_eq!(
            error(format!("{HEAD},sx[mm],sy[mm],sz[mm]\n{row},1,0,1\n")),
            "d.csv:2: column `sy[mm]` (11): a standard deviation has to be above zero; leave the cell empty where none \
             is stated"
        );
        assert_eq!(
            error(format!("{HEAD},note\n{row},3\n{row},fine\n")),
            "d.csv:3: column `note` (10): `fine` is not a number; `--ignore \"note\"` leaves the column out"
        );
    }

    #[test]
    fn a_visit_is_one_standstill() {
        let text = |second: &str| {
            format!("{HEAD},visit,payload[kg],cx[m],cy[m],cz[m]\n1,2,3,4,1,2,1,2,3,8,5,0,0,0\n{second}\n")
        };
        assert!(read(&text("1,2,3,4.001,1,2,1,2,3,8,5,0,0,0")).is_ok());
        assert_eq!(
            read(&text("1,2,3,4.1,1,2,1,2,3,8,5,0,0,0")).unwrap_err(),
            "d.csv:3: column `theta[deg]` (4): visit 8 has another joint value than in line 2; rows of one visit are one pose measurement: give another visit number"
        );
        assert_eq!(
            read(&text("1,2,3,4,1,2,1,2,3,8,6,0,0,0")).unwrap_err(),
            "d.csv:3: column `payload[kg]` (11): visit 8 has another load than in line 2; rows of one visit are one pose measurement: give another visit number"
        );
        let (data, info, _) = read(&text("1,2,3,4.1,1,2,1,2,3,-3,5,0,0,0")).unwrap();
        assert_eq!((data.visit, info.visit_labels), (vec![0, 1], vec![8, -3]));
    }

    #[test]
    fn what_is_suspicious_is_told() {
        let rows: String = (0..6).map(|k| format!("{k},2,3,0.{k},0,0,1,2,{k}00000,{}\n", 10 - k)).collect();
        let (_, _, warnings) = read(&format!("{},time[s]\n{rows}", HEAD.replace("x[mm]", "x"))).unwrap();
        assert_eq!(
            warnings,
            [
                "d.csv:1: column `x` (7): has no unit and is taken as [m]; write `x[m]`",
                "d.csv:3: column `time[s]` (10): time goes backwards here and in 4 other rows; it counts as the order all \
                 the same",
                "d.csv:1: column `theta[deg]` (4): all joint values in [deg] are so small that they look like radians; if \
                 so, call the columns `name[rad]`",
                "d.csv:1: column `x` (7): positions spread over 12700 m, but the robot is about 9.5304 m long; check the unit",
                "d.csv:1: d2, d3, roll, pitch never change: the data contains no information about the motion of these joints",
            ]
        );
        let (_, _, warnings) = read(&format!("{HEAD}\n1,2,3,91,0,0,,,\n")).unwrap();
        assert_eq!(
            warnings,
            [
                "d.csv:2: column `theta[deg]` (4): is beyond the joint's limits",
                "d.csv:2: nothing was measured in this row; fits ignore it",
            ]
        );
        let (_, info, warnings) =
            read(&format!("{HEAD},yaw[deg],humidity[%]\n1,2,3,4,1,2,1,2,3,5,6\n")).unwrap();
        assert_eq!(info.columns.len(), 11);
        assert_eq!(
            warnings,
            [
                "d.csv:1: column `yaw[deg]` (10): is not a joint of the robot (its joints: d1, d2, d3, theta, roll, pitch) and \
              counts as a channel"
            ]
        );
    }

    #[test]
    fn a_prediction_needs_no_measured_columns() {
        let text = "d1[mm],d2[mm],d3[mm],theta[deg],roll[deg],pitch[deg]\r\n1,2,3,4,1,2\r\n";
        let options = MeasurementsOptions { measured_required: false, ..MeasurementsOptions::default() };
        let with_mark = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        let (data, _, warnings) = read_for(&samples::pps(), &with_mark, &options).unwrap();
        assert_eq!((data.len(), warnings.len()), (1, 0));
        assert!(read(text).unwrap_err().contains("no columns hold anything measured"));
    }
}
