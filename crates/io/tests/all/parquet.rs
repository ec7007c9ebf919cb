//! Parquet beside CSV: the same rows, the same rules, errors with file, column and row.

use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use truepose_errormodel::Dataset;
use truepose_io::{MeasurementsOptions, MeasurementsReader, read_measurements, sample_measurements};
use truepose_kinematics::{Chain, samples};

/// What a column of a test's file holds; nothing is a null.
enum Values {
    Doubles(Vec<Option<f64>>),
    Floats(Vec<f32>),
    Integers(Vec<i64>),
    Times(Vec<i64>),
    Texts(Vec<Option<&'static str>>),
}

/// Writes a file with row groups of so many rows.
fn write(path: &Path, columns: &[(&str, Values)], group: usize) {
    let described = columns.iter().map(|(name, values)| {
        let (physical, converted, repetition) = match values {
            Values::Doubles(_) => (Physical::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL),
            Values::Floats(_) => (Physical::FLOAT, ConvertedType::NONE, Repetition::REQUIRED),
            Values::Integers(_) => (Physical::INT64, ConvertedType::NONE, Repetition::REQUIRED),
            Values::Times(_) => (Physical::INT64, ConvertedType::TIMESTAMP_MICROS, Repetition::REQUIRED),
            Values::Texts(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8, Repetition::OPTIONAL),
        };
        let made = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        Arc::new(made.with_repetition(repetition).build().unwrap())
    });
    let schema = Type::group_type_builder("measurements").with_fields(described.collect()).build().unwrap();
    let file = std::fs::File::create(path).unwrap();
    let properties = WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).unwrap();
    let rows = match &columns[0].1 {
        Values::Doubles(v) => v.len(),
        Values::Floats(v) => v.len(),
        Values::Integers(v) | Values::Times(v) => v.len(),
        Values::Texts(v) => v.len(),
    };
    for from in (0..rows).step_by(group) {
        let range = from..(from + group).min(rows);
        let mut part = writer.next_row_group().unwrap();
        for (_, values) in columns {
            let mut column = part.next_column().unwrap().unwrap();
            match values {
                Values::Doubles(v) => {
                    let levels: Vec<i16> = v[range.clone()].iter().map(|v| i16::from(v.is_some())).collect();
                    let there: Vec<f64> = v[range.clone()].iter().flatten().copied().collect();
                    column.typed::<DoubleType>().write_batch(&there, Some(&levels), None).unwrap();
                }
                Values::Floats(v) => {
                    column.typed::<FloatType>().write_batch(&v[range.clone()], None, None).unwrap();
                }
                Values::Integers(v) | Values::Times(v) => {
                    column.typed::<Int64Type>().write_batch(&v[range.clone()], None, None).unwrap();
                }
                Values::Texts(v) => {
                    let levels: Vec<i16> = v[range.clone()].iter().map(|v| i16::from(v.is_some())).collect();
                    let there: Vec<ByteArray> =
                        v[range.clone()].iter().flatten().map(|v| ByteArray::from(*v)).collect();
                    column.typed::<ByteArrayType>().write_batch(&there, Some(&levels), None).unwrap();
                }
            }
            column.close().unwrap();
        }
        part.close().unwrap();
    }
    writer.close().unwrap();
}

/// Two rows a visit, targets in turn, every fifth position not measured.
fn both(folder: &Path, rows: usize, group: usize) -> [PathBuf; 2] {
    let q = |row: usize, k: usize| 1e-6 * (row / 2) as f64 + 1e-3 * k as f64;
    let names = ["d1[mm]", "d2[mm]", "d3[mm]", "theta[deg]", "roll[rad]", "pitch[rad]"];
    let target = |row: usize| if row.is_multiple_of(7) { None } else { Some(["P1", "P2", "P3"][row % 3]) };
    let place = |row: usize, k: usize| {
        (!row.is_multiple_of(5) || k == 2).then_some(100.0 + (row * 3 + k) as f64 / 7.0)
    };
    let mut columns: Vec<(&str, Values)> = names
        .iter()
        .enumerate()
        .map(|(k, name)| (*name, Values::Doubles((0..rows).map(|row| Some(q(row, k))).collect())))
        .collect();
    columns.push(("visit", Values::Integers((0..rows as i64).map(|row| 10 + row / 2).collect())));
    columns.push(("target", Values::Texts((0..rows).map(target).collect())));
    for (k, name) in ["x[mm]", "y[mm]", "z[mm]"].into_iter().enumerate() {
        columns.push((name, Values::Doubles((0..rows).map(|row| place(row, k)).collect())));
    }
    columns.push(("oil[degC]", Values::Floats((0..rows).map(|row| 20.0 + row as f32 / 8.0).collect())));
    let (parquet, csv) = (folder.join("d.parquet"), folder.join("d.csv"));
    write(&parquet, &columns, group);
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",") + "\n";
    for row in 0..rows {
        let cells = columns.iter().map(|(_, values)| match values {
            Values::Doubles(v) => v[row].map_or(String::new(), |v| format!("{v:?}")),
            Values::Floats(v) => format!("{:?}", f64::from(v[row])),
            Values::Integers(v) | Values::Times(v) => v[row].to_string(),
            Values::Texts(v) => v[row].unwrap_or_default().to_string(),
        });
        text += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    std::fs::write(&csv, text).unwrap();
    [parquet, csv]
}

/// Everything of a data set but the numbers of lines; a NaN is equal to itself.
fn shown(data: &Dataset) -> String {
    format!("{:?}", Dataset { line: Vec::new(), ..data.clone() })
}

fn chain() -> Chain {
    samples::pps()
}

#[test]
fn the_same_rows_as_from_a_csv() {
    let folder = tempfile::tempdir().unwrap();
    for (rows, group) in [(1, 10), (50, 50), (10_001, 3000)] {
        let [parquet, csv] = both(folder.path(), rows, group);
        let read = |path: &Path| read_measurements(path, &chain(), &MeasurementsOptions::default()).unwrap();
        let ((a, of_a, _), (b, of_b, _)) = (read(&parquet), read(&csv));
        assert_eq!(shown(&a), shown(&b), "{rows}");
        assert_eq!((of_a.rows, of_a.visits, of_a.visit_labels), (of_b.rows, of_b.visits, of_b.visit_labels));
        assert_eq!(a.line.first(), Some(&1));
        assert_eq!(of_a.columns[9].range, of_b.columns[9].range);
    }
}

#[test]
fn blocks_and_samples_cut_no_visit() {
    let folder = tempfile::tempdir().unwrap();
    let [parquet, csv] = both(folder.path(), 20_000, 6001);
    let blocks = |path: &Path| -> Vec<String> {
        let mut reader = MeasurementsReader::open(path, &chain(), &MeasurementsOptions::default()).unwrap();
        let (mut block, mut all) = (Dataset::default(), Vec::new());
        while reader.read_block(777, &mut block).unwrap() > 0 {
            all.push(shown(&block));
        }
        let (read, size) = reader.progress();
        assert_eq!(read, size);
        all
    };
    assert_eq!(blocks(&parquet), blocks(&csv));
    let sample = sample_measurements(&parquet, &chain(), &MeasurementsOptions::default(), 640).unwrap();
    sample.validate(&chain()).unwrap();
    assert!((500..900).contains(&sample.len()), "{}", sample.len());
    let q = &sample.joints[0];
    assert!(q.windows(2).all(|pair| pair[0] <= pair[1]) && q[q.len() - 1] > 0.9e-5, "from all over");
}

#[test]
fn what_is_wrong_is_said_with_file_row_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.parquet");
    let good = || -> Vec<(&'static str, Values)> {
        let names = [
            "d1[mm]",
            "d2[mm]",
            "d3[mm]",
            "theta[deg]",
            "roll[rad]",
            "pitch[rad]",
            "x[mm]",
            "y[mm]",
            "z[mm]",
        ];
        names.into_iter().map(|name| (name, Values::Doubles(vec![Some(0.01); 5]))).collect()
    };
    let error = |columns: &[(&str, Values)]| {
        write(&path, columns, 2);
        let error = read_measurements(&path, &chain(), &MeasurementsOptions::default()).unwrap_err();
        error.to_string().replace(&format!("{}/", folder.path().display()), "")
    };
    let spoiled = |k: usize, values: Values| {
        let mut columns = good();
        columns[k].1 = values;
        error(&columns)
    };
    let mut holes = vec![Some(0.01); 5];
    holes[2] = None;
    assert_eq!(
        spoiled(3, Values::Doubles(holes.clone())),
        "d.parquet:3: column `theta[deg]` (4): is empty; every row needs all joint values"
    );
    holes[2] = Some(f64::INFINITY);
    assert_eq!(
        spoiled(6, Values::Doubles(holes)),
        "d.parquet:3: column `x[mm]` (7): is not a finite number; leave the cell empty if nothing was measured"
    );
    let texts = vec![Some("1.5"), None, Some("1,5"), None, None];
    assert_eq!(
        spoiled(7, Values::Texts(texts)),
        "d.parquet:3: column `y[mm]` (8): `1,5` is not a number; write decimals with a point"
    );
    assert_eq!(
        spoiled(7, Values::Times(vec![0; 5])),
        "d.parquet:0: column `y[mm]` (8): holds neither plain numbers nor texts; write times as seconds, and directions as -1, 0 or 1"
    );
    let mut more = good();
    more.push(("target", Values::Texts(vec![Some("P1"), Some("P2"), None, Some("P9"), None])));
    let message = error(&more);
    assert!(
        message.starts_with("d.parquet:4: column `target` (10): the robot has no target `P9`"),
        "{message}"
    );
    let mut named = good();
    named[6].0 = "x[furlong]";
    let message = error(&named);
    assert!(message.starts_with("d.parquet:0: column `x[furlong]` (7): unknown unit"), "{message}");

    write(&path, &good(), 2);
    let bytes = std::fs::read(&path).unwrap();
    for cut in [4, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        let error =
            read_measurements(&path, &chain(), &MeasurementsOptions::default()).unwrap_err().to_string();
        assert!(error.contains("d.parquet: cannot be read as Parquet"), "{error}");
    }
}
