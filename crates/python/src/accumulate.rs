//! Sums of blocks that merge: what one pass of a streamed identification comes to, wherever its blocks are.
//!
//! Sums of each block are kept apart until all are there and then added in the order of the blocks, so that the result does not depend, to the
//! last bit, on who has taken in which block, nor on the order.

use crate::data::Data;
use crate::error::{input, of_io};
use crate::model::registry;
use crate::packed::{Packer, Unpacker};
use crate::run::{Raised, on_threads};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use truepose_errormodel::{Domain, FittedModel};
use truepose_identify::{Equations, FitPass, JudgePass, Judged, NoiseModel, Pass, Sums, Tally};
use truepose_io::{fit_json, parse_fit, sha256};
use truepose_solvers::Gram;
use truepose_solvers::accumulator::Triangular;

/// A pass as bytes, for workers.
pub fn packed(pass: &Pass) -> PyResult<Vec<u8>> {
    let mut out = Packer::default();
    // The rows that a fit holds are of no use there.
    let model = |fitted: &FittedModel| {
        fit_json("pass", &fitted.clone().with_domain(Domain::default()).with_fallback(None)).map_err(of_io)
    };
    match pass {
        Pass::Fit(pass) => {
            out.whole(0);
            out.bytes(model(&pass.fitted)?.as_bytes());
            out.numbers(&pass.at);
            out.numbers(&[pass.noise.position_sd, pass.noise.orientation_sd, pass.noise.visit_sd]);
            out.whole(pass.kept.len() as u64);
            pass.kept.iter().for_each(|&column| out.whole(column as u64));
            out.whole(pass.folds as u64);
            out.whole(u64::from(pass.all_digits));
        }
        Pass::Judge(pass) => {
            out.whole(1);
            out.bytes(model(&pass.fitted)?.as_bytes());
            out.whole(pass.changes.len() as u64);
            pass.changes.iter().for_each(|change| out.numbers(change));
        }
    }
    Ok(out.finish())
}

fn unpacked(py: Python<'_>, bytes: &[u8], effects: Vec<Py<PyAny>>, raised: &Raised) -> PyResult<Pass> {
    let mut from = Unpacker::new(bytes)?;
    let kind = from.whole()?;
    let registry = registry(py, effects, raised)?;
    let read = parse_fit(from.text()?, &registry);
    let fitted = read.map_err(|error| raised.take().unwrap_or_else(|| of_io(error)))?;
    Ok(match kind {
        0 => {
            let at = from.numbers()?;
            let noise = from.numbers()?;
            let [position_sd, orientation_sd, visit_sd] =
                noise.try_into().map_err(|_| input("these bytes hold no pass"))?;
            let noise = NoiseModel { position_sd, orientation_sd, visit_sd };
            let count = from.count()?;
            let kept = (0..count).map(|_| from.count()).collect::<PyResult<Vec<_>>>()?;
            let (folds, all_digits) = (from.count()?, from.whole()? == 1);
            let columns = fitted.model().columns().len();
            if at.len() != columns || kept.iter().any(|&column| column >= columns) {
                return Err(input("these bytes hold no pass"));
            }
            Pass::Fit(Box::new(FitPass { fitted, at, kept, noise, folds, all_digits }))
        }
        _ => {
            let count = from.count()?;
            let changes = (0..count).map(|_| from.numbers()).collect::<PyResult<Vec<_>>>()?;
            Pass::Judge(Box::new(JudgePass { fitted, changes }))
        }
    })
}

/// What has been taken in so far.
#[derive(Default)]
struct Content {
    /// Of a pass for a fit: the sums of each block, without their domains.
    blocks: BTreeMap<u64, Sums>,
    domain: Domain,
    judged: Judged,
    /// Blocks of the last pass.
    seen: BTreeMap<u64, usize>,
}

/// Sums of some of the blocks of a pass.
#[pyclass(frozen, module = "truepose._core")]
pub struct Accumulator {
    pass: Arc<Pass>,
    bytes: Arc<Vec<u8>>,
    digest: String,
    content: Mutex<Content>,
    raised: Raised,
}

impl Accumulator {
    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The sums of all blocks, in their order; each has to be there once.
    pub fn sums(&self) -> PyResult<Sums> {
        let Pass::Fit(pass) = &*self.pass else { return Err(input("this accumulator is of the last pass")) };
        let content = self.content();
        let mut whole = pass.nothing();
        for (wanted, (&block, sums)) in content.blocks.iter().enumerate() {
            if block != wanted as u64 {
                return Err(input(format!("block {wanted} has not been taken in")));
            }
            whole.merge(sums).map_err(input)?;
        }
        whole.domain = content.domain.clone();
        Ok(whole)
    }

    /// The residuals of all blocks.
    pub fn judged(&self) -> PyResult<Judged> {
        let content = self.content();
        if let Some((wanted, _)) =
            content.seen.keys().enumerate().find(|&(wanted, &block)| block != wanted as u64)
        {
            return Err(input(format!("block {wanted} has not been taken in")));
        }
        Ok(content.judged.clone())
    }
}

#[pymethods]
impl Accumulator {
    /// Empty, of a pass; `effects` are classes of Python effects in the model.
    #[new]
    fn new(py: Python<'_>, pass: &[u8], effects: Vec<Py<PyAny>>) -> PyResult<Self> {
        let raised = Raised::default();
        let made = unpacked(py, pass, effects, &raised)?;
        let content = Mutex::default();
        Ok(Accumulator {
            pass: Arc::new(made),
            bytes: Arc::new(pass.to_vec()),
            digest: sha256(pass),
            content,
            raised,
        })
    }

    /// Takes in a block: its number, from 0, and its rows, whole visits; on so many threads, 0 for all.
    #[pyo3(signature = (block, data, threads=0))]
    fn update(&self, py: Python<'_>, block: u64, data: &Data, threads: usize) -> PyResult<()> {
        let (pass, rows) = (self.pass.clone(), data.data.clone());
        let work = move || {
            let taken = |count: bool| {
                if count { Err(input(format!("block {block} has been taken in already"))) } else { Ok(()) }
            };
            match &*pass {
                Pass::Fit(pass) => {
                    taken(self.content().blocks.contains_key(&block))?;
                    crate::model::prepare(pass.fitted.model().effects(), pass.fitted.chain(), &rows)?;
                    let mut sums = pass.sums(&rows).map_err(input)?;
                    let domain = std::mem::take(&mut sums.domain);
                    let mut content = self.content();
                    content.domain.widen(&domain);
                    content.blocks.insert(block, sums);
                }
                Pass::Judge(pass) => {
                    taken(self.content().seen.contains_key(&block))?;
                    crate::model::prepare(pass.fitted.model().effects(), pass.fitted.chain(), &rows)?;
                    let judged = pass.judged(&rows).map_err(input)?;
                    let mut content = self.content();
                    content.judged.merge(&judged);
                    content.seen.insert(block, rows.len());
                }
            }
            self.raised.take().map_or(Ok(()), Err)
        };
        // The calling thread, which may have to wait for the interpreter's lock, is none of them.
        py.detach(|| on_threads(threads, work))
    }

    /// Takes in what another accumulator of the same pass has taken in.
    fn merge(&self, other: &Accumulator) -> PyResult<()> {
        if self.digest != other.digest {
            return Err(input("the two accumulators are of different passes"));
        }
        if std::ptr::eq(self, other) {
            return Err(input("an accumulator cannot be merged with itself"));
        }
        let theirs = other.content();
        let mut content = self.content();
        let twice = theirs.blocks.keys().find(|block| content.blocks.contains_key(block));
        if let Some(block) =
            twice.or_else(|| theirs.seen.keys().find(|block| content.seen.contains_key(block)))
        {
            return Err(input(format!("block {block} has been taken in by both")));
        }
        content.domain.widen(&theirs.domain);
        content.judged.merge(&theirs.judged);
        content.blocks.extend(theirs.blocks.iter().map(|(&block, sums)| (block, sums.clone())));
        content.seen.extend(&theirs.seen);
        Ok(())
    }

    /// Rows that have been taken in.
    #[getter]
    fn rows(&self) -> usize {
        let content = self.content();
        content.blocks.values().map(|sums| sums.rows).sum::<usize>() + content.seen.values().sum::<usize>()
    }

    /// Numbers of the blocks that have been taken in.
    #[getter]
    fn blocks(&self) -> Vec<u64> {
        let content = self.content();
        content.blocks.keys().chain(content.seen.keys()).copied().collect()
    }

    /// The stored form, with the pass.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let content = self.content();
        let mut out = Packer::default();
        out.bytes(&self.bytes);
        if let Pass::Fit(pass) = &*self.pass {
            let domain = pass.fitted.clone().with_domain(content.domain.clone());
            out.bytes(fit_json("sums", &domain).map_err(of_io)?.as_bytes());
            out.whole(content.blocks.len() as u64);
            for (&block, sums) in &content.blocks {
                for number in [block, sums.rows as u64, sums.visits as u64, sums.observations as u64] {
                    out.whole(number);
                }
                let folds: Vec<Vec<u8>> = match &sums.equations {
                    Equations::Gram(folds) => folds.iter().map(Gram::to_bytes).collect(),
                    Equations::Triangle(folds) => folds.iter().map(Triangular::to_bytes).collect(),
                };
                out.whole(folds.len() as u64);
                folds.iter().for_each(|fold| out.bytes(fold));
            }
        } else {
            out.whole(content.seen.len() as u64);
            content.seen.iter().for_each(|(&block, &rows)| {
                out.whole(block);
                out.whole(rows as u64);
            });
            let Judged { position, orientation, held_position, held_orientation, folds } = &content.judged;
            out.whole(folds.len() as u64);
            for tally in [position, orientation, held_position, held_orientation].into_iter().chain(folds) {
                let (sum, squares, max, kept, bins) = tally.stored();
                out.wide(sum);
                out.wide(squares);
                out.number(max);
                out.numbers(&kept);
                out.whole(bins.len() as u64);
                bins.iter().for_each(|&(bin, count)| {
                    out.whole(u64::from(bin));
                    out.whole(count);
                });
            }
        }
        Ok(PyBytes::new(py, &out.finish()))
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8], effects: Vec<Py<PyAny>>) -> PyResult<Self> {
        let mut from = Unpacker::new(bytes)?;
        let pass = from.bytes()?;
        let known = effects.iter().map(|class| class.clone_ref(py)).collect();
        let made = Accumulator::new(py, pass, effects)?;
        let mut content = made.content();
        if let Pass::Fit(pass) = &*made.pass {
            let registry = registry(py, known, &made.raised)?;
            content.domain = parse_fit(from.text()?, &registry).map_err(of_io)?.domain;
            for _ in 0..from.count()? {
                let (block, mut sums) = (from.whole()?, pass.nothing());
                (sums.rows, sums.visits, sums.observations) = (from.count()?, from.count()?, from.count()?);
                let folds = (0..from.count()?).map(|_| from.bytes()).collect::<PyResult<Vec<_>>>()?;
                sums.equations = match pass.all_digits {
                    false => Equations::Gram(
                        folds.iter().map(|b| Gram::from_bytes(b).map_err(input)).collect::<PyResult<_>>()?,
                    ),
                    true => Equations::Triangle(
                        folds
                            .iter()
                            .map(|b| Triangular::from_bytes(b).map_err(input))
                            .collect::<PyResult<_>>()?,
                    ),
                };
                content.blocks.insert(block, sums);
            }
        } else {
            for _ in 0..from.count()? {
                let block = from.whole()?;
                content.seen.insert(block, from.count()?);
            }
            let count = from.count()?;
            let mut tally = || -> PyResult<Tally> {
                let (sum, squares, max, kept) = (from.wide()?, from.wide()?, from.number()?, from.numbers()?);
                let bins = (0..from.count()?)
                    .map(|_| Ok((u32::try_from(from.whole()?).map_err(input)?, from.whole()?)));
                Ok(Tally::restored((sum, squares, max, kept, bins.collect::<PyResult<_>>()?)))
            };
            let (position, orientation, held_position, held_orientation) =
                (tally()?, tally()?, tally()?, tally()?);
            let folds = (0..count).map(|_| tally()).collect::<PyResult<_>>()?;
            content.judged = Judged { position, orientation, held_position, held_orientation, folds };
        }
        drop(content);
        Ok(made)
    }
}
