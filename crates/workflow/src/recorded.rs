//! What a fit has recorded of how its data was read.

use serde_json::{Map, Value};
use truepose_errormodel::FittedModel;
use truepose_io::{ColumnMap, OrientationConvention};

/// Where a fit has the columns of its data.
const COLUMNS: &str = "columns";

/// Records in a fit which column of its data was which, as `[columns]` and `--map` said; nothing where they said nothing.
pub fn record_columns(fitted: &mut FittedModel, map: &ColumnMap) {
    let map = map.clone().usual();
    if map.is_empty() {
        return;
    }
    let names = map.usual_names.into_iter().map(|(ours, theirs)| (ours, theirs.into()));
    let mut columns = Map::new();
    columns.insert("names".into(), Value::Object(names.collect()));
    columns.insert("ignore".into(), map.usual_ignore.into());
    if let Some((word, _)) =
        OrientationConvention::WORDS.iter().find(|(_, known)| Some(*known) == map.orientation)
    {
        columns.insert("orientation".into(), (*word).into());
    }
    fitted.provenance.insert(COLUMNS.into(), columns.into());
}

/// The columns of the data of a fit, for other files of the same robot.
pub fn recorded_columns(fitted: &FittedModel) -> ColumnMap {
    let Some(columns) = fitted.provenance.get(COLUMNS).and_then(Value::as_object) else {
        return ColumnMap::default();
    };
    let word = |value: &Value| value.as_str().map(str::to_owned);
    let names = columns.get("names").and_then(Value::as_object);
    let names = names.into_iter().flatten().filter_map(|(ours, theirs)| Some((ours.clone(), word(theirs)?)));
    let ignore = columns.get("ignore").and_then(Value::as_array);
    ColumnMap {
        usual_names: names.collect(),
        usual_ignore: ignore.into_iter().flatten().filter_map(word).collect(),
        orientation: columns
            .get("orientation")
            .and_then(Value::as_str)
            .and_then(OrientationConvention::named),
        ..ColumnMap::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::ErrorModel;
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::samples;

    #[test]
    fn what_is_recorded_serves_for_other_files_and_lines_do_not() {
        let model = ErrorModel::new(samples::ur10(), Vec::new()).unwrap();
        let mut fitted = FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0)).unwrap();
        record_columns(&mut fitted, &ColumnMap::default());
        assert!(fitted.provenance.is_empty() && recorded_columns(&fitted).is_empty());
        let map = ColumnMap {
            names: vec![("shoulder_pan".into(), "A1 [deg]".into())],
            ignore: vec!["Remark".into()],
            exclude: vec![7],
            orientation: OrientationConvention::named("abc"),
            ..ColumnMap::default()
        };
        record_columns(&mut fitted, &map);
        assert_eq!(recorded_columns(&fitted), map.usual());
    }
}
