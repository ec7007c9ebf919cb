//! What is read without being asked for, since it cannot be anything else.

use super::super::mapping::ColumnMap;
use super::super::names::Names;
use super::super::sampled::Sample;
use super::loads::{carried, wrench};
use super::places::capitals;
use super::quoted;

/// The names of the user with those that are given unasked, and what there is to say about each: `X Y Z` with units of length, and the only column
/// with a unit of mass. The columns of a wrench are left out: they would be read as channels.
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
    let wrench = wrench(headers, sample, &Names { chain: names.chain, map: &own });
    if !wrench.is_empty() {
        let theirs: Vec<String> = wrench.iter().map(|(_, k)| format!("`{}`", headers[*k])).collect();
        let map: Vec<String> = wrench
            .iter()
            .map(|(ours, k)| format!("--map {}", quoted(&format!("{ours}={}", headers[*k]))))
            .collect();
        own.ignore.extend(wrench.iter().map(|(_, k)| headers[*k].to_owned()));
        said.push(format!(
            "{} are a wrench by their names and are not read: a load is no channel. If the load exerts it at the tool's origin, in the tool's \
             axes: {}",
            theirs.join(", "),
            map.join(" ")
        ));
    }
    (own, said)
}
