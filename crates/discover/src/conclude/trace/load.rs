//! A wrong payload, row by row.

use crate::conclude::trace::point::{Trace, TracePoint};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::driver::Driver;
use truepose_errormodel::Dataset;
use truepose_identify::Fit;
use truepose_kinematics::Load;

/// What the rows that declare a wrong payload say, in kg.
pub(super) fn load_trace(
    fit: &Fit,
    data: &Dataset,
    candidate: &Candidate,
) -> Result<Option<Trace>, DiscoverError> {
    const STEP: f64 = 1e-2;
    let Change::CorrectLoad { level, mass, .. } = candidate.change else { return Ok(None) };
    let data = &*data.derived_for(fit.fitted.model())?;
    let mut predictor = fit.fitted.bind(&data.schema)?;
    let mut points = Vec::new();
    for row in 0..data.len() {
        let conditions = data.conditions(row);
        let carried = matches!(conditions.load, Load::Payload(p) if (p.mass - mass).abs() < 1e-12);
        let Some(more) =
            crate::data::payload::changed(&conditions, (mass, None), mass + STEP).filter(|_| carried)
        else {
            continue;
        };
        let here = predictor.predict(&conditions, data.aim(row)).translation;
        let there = predictor.predict(&more, data.aim(row)).translation;
        let moved = (there - here) / STEP;
        let moved = data.ray(row).map_or(moved, |w| w * (w.dot(&moved) / w.norm_squared()));
        let difference = data.away(row, &here);
        let square = moved.norm_squared();
        if square.sqrt() < 1e-9 || !difference.norm().is_finite() {
            continue;
        }
        let (after, fitted) = (moved.dot(&difference) / square, mass - level);
        let driver = if data.has_clock() { data.time[row] } else { data.visit[row] as f64 + 1.0 };
        let lever = square.sqrt();
        points.push(TracePoint {
            row,
            driver,
            before: after + fitted,
            after,
            fitted,
            sd: 0.0,
            lever,
            class: 0,
        });
    }
    let (driver, unit) = if data.has_clock() { (Driver::Time, "s") } else { (Driver::Pose, "") };
    Ok((!points.is_empty()).then(|| Trace {
        what: format!("mass beyond the declared {level} kg"),
        unit: "kg",
        driver: driver.to_string(),
        driver_unit: unit.into(),
        classes: Vec::new(),
        points,
    }))
}
