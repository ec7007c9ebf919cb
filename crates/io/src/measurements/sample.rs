//! A few visits from all over a file, without reading the rest.

use super::excluded::Excluded;
use super::reader::{MeasurementsOptions, MeasurementsReader};
use super::visits::VisitNumbers;
use crate::IoError;
use std::path::Path;
use truepose_errormodel::Dataset;
use truepose_kinematics::Chain;

/// Places of a file that are sampled.
const PLACES: u64 = 32;

/// About `rows` rows from places all over a file, in whole visits; the whole file where it is not much longer than that.
///
/// What is wrong at the places behind the first one is left to who reads the whole file and can say where. Directions of approach are
/// those that the file states; visits count from zero.
///
/// # Errors
/// When the file cannot be read, its header does not make sense, or a row at its beginning is wrong.
pub fn sample_measurements(
    path: impl AsRef<Path>,
    chain: &Chain,
    options: &MeasurementsOptions,
    rows: usize,
) -> Result<Dataset, IoError> {
    let mut reader = MeasurementsReader::open(path, chain, options)?;
    let each = rows.div_ceil(PLACES as usize).max(2);
    let mut sample = Dataset::default();
    reader.read_block(each, &mut sample)?;
    let (read, size) = reader.progress();
    // Where places would meet, the whole file is as little.
    let places = if read.saturating_mul(3 * PLACES) < size { PLACES } else { 0 };
    if places == 0 {
        let mut more = Dataset::default();
        while reader.read_block(each, &mut more)? > 0 {
            append(&mut sample, &more, 0);
        }
        return Ok(sample);
    }
    let mut block = Dataset::default();
    // Behind a jump lines have no numbers: nothing is left out there.
    reader.rows.exclude = Excluded::new(Vec::new());
    for place in 1..places {
        reader.pending = false;
        reader.visits = VisitNumbers::default();
        let there = reader.source.jump(place * (size / places));
        if there.is_ok() && reader.read_block(each, &mut block).is_ok() {
            // Its first visit may have begun in front of the place.
            let first = block.visit.partition_point(|&visit| visit == 0);
            append(&mut sample, &block, first);
        }
    }
    Ok(sample)
}

/// Adds the rows from this one on; their visits are new ones.
fn append(to: &mut Dataset, more: &Dataset, from: usize) {
    let next = to.visit.last().map_or(0, |last| last + 1);
    let begun = more.visit.get(from).copied().unwrap_or(0);
    let table = |to: &mut Vec<Vec<f64>>, more: &[Vec<f64>]| {
        to.iter_mut().zip(more).for_each(|(to, more)| to.extend_from_slice(&more[from..]));
    };
    table(&mut to.joints, &more.joints);
    table(&mut to.approach, &more.approach);
    table(&mut to.channels, &more.channels);
    to.position.extend_from_slice(&more.position[from..]);
    to.orientation.extend_from_slice(&more.orientation[from..]);
    to.position_sd.extend_from_slice(&more.position_sd[from..]);
    to.orientation_sd.extend_from_slice(&more.orientation_sd[from..]);
    to.target.extend_from_slice(&more.target[from..]);
    to.load.extend_from_slice(&more.load[from..]);
    to.time.extend_from_slice(&more.time[from..]);
    to.line.extend_from_slice(&more.line[from..]);
    to.visit.extend(more.visit[from..].iter().map(|visit| next + visit - begun));
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    /// Two rows a visit; the joint says which visit it is.
    fn file(visits: usize) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        let mut text = String::from("visit,r1[rad],r2[rad],slide[m],r4[rad],x[m],y[m],z[m]\n");
        for visit in 0..visits {
            for row in 0..2 {
                text += &format!("{visit},{},0.2,0.1,0.4,1,2,{row}\n", 1e-6 * visit as f64);
            }
        }
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn whole_visits_from_all_over() {
        let chain = samples::scara();
        let (_folder, path) = file(20_000);
        let sample = sample_measurements(&path, &chain, &MeasurementsOptions::default(), 640).unwrap();
        sample.validate(&chain).unwrap();
        assert!((500..900).contains(&sample.len()), "{}", sample.len());
        let visits = truepose_errormodel::Visits::of(&sample);
        assert!(visits.rows.iter().all(|rows| rows.len() == 2), "no visit is cut");
        for rows in &visits.rows {
            assert_eq!(sample.joints[0][rows[0]].to_bits(), sample.joints[0][rows[1]].to_bits());
        }
        let q = &sample.joints[0];
        assert!(q.windows(2).all(|pair| pair[0] <= pair[1]) && q[q.len() - 1] > 0.018, "{}", q[q.len() - 1]);
    }

    #[test]
    fn a_short_file_is_taken_whole() {
        let chain = samples::scara();
        let (_folder, path) = file(70);
        let options = MeasurementsOptions::default();
        let sample = sample_measurements(&path, &chain, &options, 640).unwrap();
        let (whole, ..) = crate::read_measurements(&path, &chain, &options).unwrap();
        assert_eq!(sample.joints, whole.joints);
        assert_eq!(sample.visit, whole.visit);
        std::fs::write(&path, "r1[rad],r2[rad],slide[m],r4[rad],x[m],y[m],z[m]\n0,0,0,zero,1,2,3\n").unwrap();
        let error = sample_measurements(&path, &chain, &options, 640).unwrap_err();
        assert!(error.to_string().contains(":2: column `r4[rad]` (4): `zero` is not a number"), "{error}");
    }

    #[test]
    fn lines_that_are_left_out_are_met_by_the_end_of_the_file() {
        let chain = samples::scara();
        let (_folder, path) = file(20_000);
        let left_out = |lines: &[u64]| {
            let columns = crate::ColumnMap { exclude: lines.to_vec(), ..crate::ColumnMap::default() };
            MeasurementsOptions { columns, ..MeasurementsOptions::default() }
        };
        let blocks = |lines: &[u64]| {
            let mut reader = MeasurementsReader::open(&path, &chain, &left_out(lines))?;
            let (mut block, mut rows) = (Dataset::default(), 0);
            loop {
                match reader.read_block(500, &mut block)? {
                    0 => return Ok::<usize, IoError>(rows),
                    more => rows += more,
                }
            }
        };
        let whole = |lines: &[u64]| {
            crate::read_measurements(&path, &chain, &left_out(lines)).map(|read| read.0.len())
        };
        assert_eq!((blocks(&[3, 39_000]).unwrap(), whole(&[3, 39_000]).unwrap()), (39_998, 39_998));
        for error in [blocks(&[3, 40_002]).unwrap_err(), whole(&[3, 40_002]).unwrap_err()] {
            assert!(error.to_string().contains("d.csv:40002: is to be left out"), "{error}");
        }
        assert!(sample_measurements(&path, &chain, &left_out(&[3, 39_000]), 640).is_ok());
    }
}
