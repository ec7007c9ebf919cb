//! Rows that could be measured, as a fit would have them: with the unknowns of everything that they touch, meet or observe.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | A | [`PlannedRows::visits`]: what the unknowns do to the numbers of a visit, over their standard deviation | numbers × (p + s) | 1 per unit |
//! | p, s | coefficients of the fit; unknowns of landmarks and sensors | | |
//!
//! Everything stands where it is described, the robot where the fit has it. What was measured does not count, but where a sensor whose place is
//! not described has to be found from it.

use super::contacts;
use super::prepared::Prepared;
use super::rounds::{put, with};
use super::sensors::poses;
use super::{all_known, alone, arm_is_frozen, start, without};
use crate::IdentifyError;
use crate::linearise::Lineariser;
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};
use truepose_errormodel::effects::Where;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, NoiseModel, Surroundings};
use truepose_kinematics::{Chain, FrameId};

/// The rows of each visit that could be made.
pub(crate) struct PlannedRows {
    /// By the number of the visit in the data.
    pub visits: Vec<DMatrix<f64>>,
    /// Expected sizes of the further unknowns, SI.
    pub sizes: Vec<f64>,
    /// Whether some row says where the base is.
    pub has_base: bool,
    /// Whether cameras on the robot are all there is: no row shows where the tool's point is.
    pub images_only: bool,
}

impl PlannedRows {
    /// Of these rows; their landmarks count in `surroundings`.
    pub fn of(
        fitted: &FittedModel,
        data: &Dataset,
        surroundings: &Surroundings,
    ) -> Result<Self, IdentifyError> {
        let chain = fitted.chain();
        data.validate(chain)?;
        // Rows are known again by their lines.
        let mut data = data.clone();
        let lines: BTreeSet<u64> = data.line.iter().copied().collect();
        if lines.len() < data.len() {
            data.line = (1..=data.len() as u64).collect();
        }
        let visit_of: BTreeMap<u64, usize> =
            data.line.iter().copied().zip(data.visit.iter().copied()).collect();
        let contacts = contacts::contacts(chain, &data)?;
        let frozen = arm_is_frozen(chain, fitted.model().effects());
        let prepared = Prepared::of((chain, &data, surroundings), &contacts, (&BTreeSet::new(), frozen))?;
        let Prepared {
            mut data,
            surroundings,
            contacts,
            mut sensors,
            carried,
            mut structure,
            scale_is_open,
            has_base,
            measured,
            remarks,
            ..
        } = prepared;
        let mut plain = data.clone();
        carried.set_targets(chain, &mut plain, false);
        carried.set_targets(chain, &mut data, true);
        let at_rest = poses(fitted, &plain)?;
        sensors.start_those(&at_rest, &carried, &|observation| !observation.placed())?;
        let reference = fitted.noise.position_sd.max(1e-9);
        sensors.found.iter_mut().for_each(|found| found.weight = reference / found.sd);
        let mut at = start(&at_rest, &data, structure.points.len(), &surroundings, &structure.declared);
        if scale_is_open && structure.hold_scale(&at).is_none() {
            return Err(alone(&structure, &remarks));
        }
        let points = structure.placed(&mut at);
        put(&mut data, &at);
        let own = sensors.effect(chain.characteristic_length());
        let mut rays = sensors.linearised(&at_rest, &data, &carried)?;
        contacts::measured(&contacts, &at_rest, &mut data, &mut rays);
        data.set_rays(rays.iter().any(Option::is_some).then_some(&rays));
        let seen = carried.with_targets(chain, &at_rest)?;
        let declared: Vec<Box<dyn AnyEffect>> = fitted.model().effects().to_vec();
        let model = ErrorModel::new(seen, with(&declared, points, own))?;
        let known = fitted.coefficients().len();
        let mut coefficients = fitted.coefficients().to_vec();
        coefficients.resize(model.columns().len(), 0.0);
        let derived = &*data.derived_for(&model)?;
        let mut lineariser = Lineariser::new(&model, derived, fitted.noise, &coefficients)?;
        let width = lineariser.width();
        let count = visit_of.values().max().map_or(0, |last| last + 1);
        let mut rows_of: Vec<Vec<usize>> = vec![Vec::new(); count];
        for row in 0..derived.len() {
            if let Some(&visit) = visit_of.get(&derived.line[row]) {
                rows_of[visit].push(row);
            }
        }
        let visits = rows_of.iter().map(|rows| {
            let block = lineariser.visit(rows);
            let whole = DMatrix::from_row_slice(block.source.len(), width, block.rows);
            whole.columns(0, width - 1).into_owned()
        });
        let visits = visits.collect();
        let images_only = !carried.is_empty() && !measured;
        Ok(PlannedRows {
            has_base,
            images_only,
            visits,
            sizes: model.columns()[known..].iter().map(|column| column.scale).collect(),
        })
    }
}

/// A robot of which nothing has been measured yet: its coefficients are zero, with the expected sizes of their columns as standard deviations, and
/// positions are measured to 0.1 mm. Its base has no errors where nothing in the surroundings says where it is.
///
/// # Errors
/// When an effect does not fit the robot.
pub fn unmeasured(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    surroundings: &Surroundings,
) -> Result<FittedModel, IdentifyError> {
    let outside = surroundings.landmarks.iter().any(|thing| match &thing.observed {
        Some(observed) => observed.outside(),
        None => thing.known,
    });
    let (chain, effects) = match outside {
        true => (chain.clone(), effects.to_vec()),
        false => {
            let chain = all_known(chain)?;
            let effects = without(effects.to_vec(), &chain, &|place| *place == Where::Frame(FrameId::BASE));
            (chain, effects)
        }
    };
    let model = ErrorModel::new(chain, effects)?;
    let sizes = model.columns().iter().map(|column| column.scale * column.scale);
    let sizes = DVector::from_iterator(model.columns().len(), sizes);
    let fitted = FittedModel::new(model, vec![0.0; sizes.len()], DMatrix::from_diagonal(&sizes))?;
    Ok(fitted.with_noise(NoiseModel::default()))
}
