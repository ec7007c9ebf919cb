//! What is read without being asked for, since it cannot be anything else.

use super::super::mapping::ColumnMap;
use super::super::names::Names;
use super::super::sampled::Sample;
use super::loads::carried;
use super::places::capitals;

/// The names of the user with those that are given unasked, and what there is to say about each: `X Y Z` with units of length, and the only column
/// with a unit of mass.
pub(in super::super) fn applied(
    headers: &[&str],
    sample: &Sample,
    names: &Names<'_>,
) -> (ColumnMap, Vec<String>) {
    let (mut own, mut said) = (names.map.clone(), Vec::new());
    if let Some(columns) = capitals(headers, sample, names) {
        let [x, y, z] = columns.map(|k| headers[k]);
        own.names.extend([("x", x), ("y", y), ("z", z)].map(|(name, header)| (name.into(), header.into())));
        said.push(format!("`{x}`, `{y}`, `{z}` are read as x, y, z: no other columns can be meant by these"));
    }
    if let Some(mass) = carried(headers, sample, &Names { chain: names.chain, map: &own }) {
        let mass = headers[mass];
        own.names.push(("payload".into(), mass.into()));
        said.push(format!(
            "`{mass}` is read as payload: it is the only mass (if it is none: `--ignore`, or `--map NAME=` another name)"
        ));
    }
    (own, said)
}
