//! Rows that were copied: no instrument gives the same digits twice.

use super::info::CsvInfo;
use super::mixed::{AlreadyMixed, Mixed};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;
use truepose_errormodel::Dataset;
use truepose_kinematics::Load;

/// Rows above which nobody copies by hand, and looking costs a good part of reading.
const MOST: usize = 200_000;

/// Part of the components of repeated measurements that agree to the last digit, above which all three may agree by chance once in a
/// thousand times: the digits of such a file are coarser than its noise, and equal rows are measurements.
const COARSE: f64 = 0.1;

/// Rows that repeat an earlier one to the bit in joints, load, target and everything measured, each with that row; none where the digits
/// of the file are too few to tell a copy from a repeat.
pub(super) fn copies(data: &Dataset) -> Vec<(usize, usize)> {
    if data.len() > MOST {
        return Vec::new();
    }
    let mut measured = HashMap::with_hasher(BuildHasherDefault::<AlreadyMixed>::default());
    let mut conditions = HashMap::with_hasher(BuildHasherDefault::<AlreadyMixed>::default());
    let mut copies = Vec::new();
    // Components of repeats that are no copies, and how many of them agree all the same.
    let (mut compared, mut agree) = (0usize, 0usize);
    for row in (0..data.len()).filter(|&row| data.seen(row).count() >= 3) {
        let mut key = Mixed::default();
        data.joints.iter().for_each(|column| key.add(column[row]));
        key.add(data.target[row].map_or(0.0, |t| t.0 as f64 + 1.0));
        match &data.load[row] {
            Load::None => (),
            Load::Payload(p) => [p.mass, p.com.x, p.com.y, p.com.z].into_iter().for_each(|v| key.add(v)),
            Load::Wrench(w) => w.force.iter().chain(w.moment.iter()).for_each(|&v| key.add(v)),
        }
        let before = *conditions.entry(key.clone()).or_insert(row);
        data.position[row].iter().for_each(|&v| key.add(v));
        data.orientation[row].into_iter().flatten().for_each(|v| key.add(v));
        match measured.entry(key) {
            Entry::Vacant(entry) => {
                entry.insert(row);
                if before != row {
                    let both = data.position[row].iter().zip(&data.position[before]);
                    let both = both.filter(|(a, b)| !a.is_nan() && !b.is_nan());
                    both.for_each(|(a, b)| {
                        compared += 1;
                        agree += usize::from(a.to_bits() == b.to_bits());
                    });
                }
            }
            Entry::Occupied(entry) => copies.push((row, *entry.get())),
        }
    }
    if agree as f64 > COARSE * compared as f64 { Vec::new() } else { copies }
}

/// The data without these rows, as if they did not stand in the file.
pub(super) fn without(data: &Dataset, rows: &[usize], info: &mut CsvInfo) -> Dataset {
    let kept: Vec<usize> = (0..data.len()).filter(|row| rows.binary_search(row).is_err()).collect();
    let part = Dataset { record: None, ..data.select(&kept) };
    if info.ids.len() == data.len() {
        info.ids = kept.iter().map(|&row| info.ids[row].clone()).collect();
    }
    if !info.visit_labels.is_empty() {
        // Visits are numbered in the order of their first rows, before and after.
        let mut left: Vec<usize> = kept.iter().map(|&row| data.visit[row]).collect();
        left.sort_unstable();
        left.dedup();
        info.visit_labels = left.iter().map(|&visit| info.visit_labels[visit]).collect();
    }
    (info.rows, info.visits) = (part.len(), part.visit.iter().max().map_or(0, |last| last + 1));
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeasurementsOptions, read_measurements};
    use truepose_kinematics::samples;

    fn read(text: &str) -> (Dataset, crate::CsvInfo, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        std::fs::write(&path, text).unwrap();
        let (data, info, warnings) =
            read_measurements(&path, &samples::scara(), &MeasurementsOptions::default()).unwrap();
        (data, info, warnings.into_iter().map(|w| w.message).filter(|words| words.contains("copy")).collect())
    }

    /// Six poses, three of them measured again after the others, with digits after the point so many.
    fn table(digits: usize, copied: bool) -> String {
        let mut text = String::from("r1[rad],r2[rad],slide[m],r4[rad],x[mm],y[mm],z[mm],visit,id\n");
        let noise = |k: usize| 0.06 * (2.7 * k as f64).sin();
        let mut row = |pose: usize, k: usize, visit: usize| {
            let p = pose as f64;
            let place: Vec<String> = (0..3)
                .map(|axis| format!("{:.digits$}", 400.0 + 31.7 * p + axis as f64 + noise(3 * k + axis)))
                .collect();
            text += &format!("{},{},0.05,0.2,{},{visit},m{k}\n", 0.1 * p, 0.3 - 0.05 * p, place.join(","));
        };
        (0..6).for_each(|pose| row(pose, pose, 10 + pose));
        (0..3).for_each(|pose| row(pose, 6 + pose, 20 + pose));
        if copied {
            (0..6).for_each(|pose| row(pose, pose, 30 + pose));
        }
        text
    }

    #[test]
    fn a_pose_measurement_that_was_copied_as_a_new_one_is_not_used() {
        let (once, info, warnings) = read(&table(5, false));
        assert!(warnings.is_empty(), "{warnings:?}");
        let (twice, told, warnings) = read(&table(5, true));
        assert_eq!((twice.position, twice.visit), (once.position, once.visit));
        assert_eq!((&told.visit_labels, &told.ids), (&info.visit_labels, &info.ids));
        assert_eq!((told.rows, told.visits, told.configurations), (9, 9, 6));
        assert!(
            warnings[0].starts_with(
                "is an exact copy of line 2, and 5 other rows are copies too: they are not used; a copied row"
            ),
            "{warnings:?}"
        );
    }

    #[test]
    fn equal_rows_of_a_coarse_instrument_are_repeats() {
        // Of digits as coarse as the noise every second component of a repeat agrees.
        let (data, _, warnings) = read(&table(1, true));
        assert_eq!((data.len(), warnings.len()), (15, 0), "{warnings:?}");
    }
}
