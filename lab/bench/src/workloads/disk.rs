//! W3 from a table on disk to a fit on disk: what `truepose identify --stream --linear --folds 0 --prior none` does, and reading with pandas
//! before the peer's fit.
//!
//! Our table is the peers' with columns as our files name them: once made, it lies beside theirs. The peer reads its own.

use super::{answer_of_points, of_points, paper, shared_with};
use crate::prelude::*;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::PathBuf;
use truepose_identify::{
    FitOptions, IdentifyError, PriorStrength, Source, StreamedOptions, identify_streamed,
};
use truepose_io::{MeasurementsOptions, MeasurementsReader, sample_measurements, write_fit};

/// Rows of a block, as the program reads them.
const BLOCK: usize = 16384;

/// A file of measurements, read as often as it is asked for.
struct Rows<'a> {
    path: &'a Path,
    chain: &'a Chain,
}

impl Source for Rows<'_> {
    type Error = Failure;

    fn sample(&mut self, rows: usize) -> Outcome<Dataset> {
        Ok(sample_measurements(self.path, self.chain, &MeasurementsOptions::default(), rows)?)
    }

    fn each(&mut self, take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>) -> Outcome {
        let mut reader = MeasurementsReader::open(self.path, self.chain, &MeasurementsOptions::default())?;
        let mut block = Dataset::default();
        while reader.read_block(BLOCK, &mut block)? > 0 {
            take(&block)?;
        }
        Ok(())
    }
}

/// The peers' table as one of ours: `target,q1…q6,w,mx,my,mz` with the load as the y component of a measured force.
fn made(folder: &Path, from: &str) -> Outcome<PathBuf> {
    let path = folder.join(format!("truepose_{from}"));
    if path.exists() {
        return Ok(path);
    }
    let unfinished = path.with_extension("unfinished");
    let mut lines = BufReader::new(File::open(folder.join(from))?).lines();
    if lines.next().transpose()?.as_deref() != Some("target,q1,q2,q3,q4,q5,q6,w,mx,my,mz") {
        return Err(format!("{from}: not the columns that were expected").into());
    }
    let mut out = BufWriter::new(File::create(&unfinished)?);
    writeln!(
        out,
        "target,j1[m],j2[m],j3[m],j4[rad],j5[rad],j6[rad],fx[N],fy[N],fz[N],tx[N*m],ty[N*m],tz[N*m],x[m],y[m],z[m]"
    )?;
    for line in lines {
        let line = line?;
        let cells: Vec<&str> = line.split(',').collect();
        let [target, joints @ .., load, x, y, z] = cells.as_slice() else {
            return Err(format!("{from}: a row is too short").into());
        };
        let (target, joints) = (target.parse::<usize>()? + 1, joints.join(","));
        writeln!(out, "P{target},{joints},0,{load},0,0,0,0,{x},{y},{z}")?;
    }
    out.into_inner()?.sync_all()?;
    std::fs::rename(unfinished, &path)?;
    Ok(path)
}

fn way(folder: &Path, file: &'static str) -> Outcome<Way> {
    let (data, model) = (made(folder, file)?, paper::model(folder)?);
    let (fit, own) = (data.with_extension("fit.json"), folder.to_path_buf());
    let also = model.clone();
    let run = move || {
        let options = FitOptions { refine: false, prior: PriorStrength::None, ..FitOptions::default() };
        let mut source = Rows { path: &data, chain: model.chain() };
        let options = StreamedOptions { fit: options, folds: 0 };
        let found =
            identify_streamed(model.chain(), model.effects(), &mut source, &PivotedQr::default(), &options)?;
        write_fit(&fit, &found.fit.fitted)?;
        match found.gram {
            true => Ok((found.fit.reduction.rank(), found.fit.fitted.coefficients().to_vec())),
            false => Err("the guard refused".into()),
        }
    };
    shared_with(run, move |(rank, coefficients): &(usize, Vec<f64>)| {
        let data = rows_of(&own, file)?;
        answer_of_points(&also, &data, *rank, coefficients)
    })
}

const ASKED: &[(&str, f64)] = &[("pandas+numba-chunk", 0.75)];

/// Bytes of a row of the table, read twice.
const BYTES: f64 = 190.0;

/// 200 000 points.
pub const DISK_200K: Workload = of_points(
    ("W3-disk-200k", "200 000 points from a table on disk to a fit on disk"),
    (2e5, BYTES),
    &[Declared::of("streamed", ASKED, |folder| way(folder, "w3_200k.csv"))],
);

/// A million.
pub const DISK_1M: Workload = of_points(
    ("W3-disk-1m", "1 000 000 points from a table on disk to a fit on disk"),
    (1e6, BYTES),
    &[Declared::of("streamed", ASKED, |folder| way(folder, "w3_1m.csv"))],
);
