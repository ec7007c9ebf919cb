//! Rows that were copied: no instrument gives the same digits twice.

use super::mixed::{AlreadyMixed, Mixed};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;
use truepose_errormodel::Dataset;
use truepose_kinematics::Load;

/// Rows above which nobody copies by hand, and looking costs a good part of reading.
const MOST: usize = 200_000;

/// The first row that repeats an earlier one to the bit in joints, load, target and everything measured; that earlier one; how
/// many there are.
pub(super) fn copies(data: &Dataset) -> Option<(usize, usize, usize)> {
    if data.len() > MOST {
        return None;
    }
    let mut seen = HashMap::with_hasher(BuildHasherDefault::<AlreadyMixed>::default());
    let mut first = None;
    let mut count = 0;
    for row in (0..data.len()).filter(|&row| data.seen(row).count() >= 3) {
        let mut key = Mixed::default();
        data.joints.iter().for_each(|column| key.add(column[row]));
        data.position[row].iter().for_each(|&v| key.add(v));
        data.orientation[row].into_iter().flatten().for_each(|v| key.add(v));
        key.add(data.target[row].map_or(0.0, |t| t.0 as f64 + 1.0));
        match &data.load[row] {
            Load::None => (),
            Load::Payload(p) => [p.mass, p.com.x, p.com.y, p.com.z].into_iter().for_each(|v| key.add(v)),
            Load::Wrench(w) => w.force.iter().chain(w.moment.iter()).for_each(|&v| key.add(v)),
        }
        match seen.entry(key) {
            Entry::Vacant(entry) => {
                entry.insert(row);
            }
            Entry::Occupied(entry) => {
                count += 1;
                first.get_or_insert((row, *entry.get()));
            }
        }
    }
    first.map(|(row, of)| (row, of, count))
}
