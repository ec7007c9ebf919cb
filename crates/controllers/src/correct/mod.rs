//! What becomes of each point.
//!
//! ```text
//! pose P in frame F of tool X      nominal flange  K · F · P · X⁻¹ · G⁻¹
//! joints q                         nominal flange  A(q)
//! desired tool of the measurements B E_0 · flange · tool E_tool                command q' of the real robot
//! replaced by                      F⁻¹ · K⁻¹ · A(q') · G · X,  or  q'
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | K, G | `controller_base`, `controller_flange` | m | description's base; last joint |
//! | B E_0, tool E_tool | [`Installation`] | m | measurement; last joint |
//! | A | the nominal joints alone | m | description's base |
//!
//! A frame on a positioner is in the axes of another tool: `before` is then its nominal place, and the desired tool that of its real one, see `work`.
//! A taught frame or tool has the robot's errors in it: the desired tool is then that of the real F and X, see `taught`.
//! A point near a singularity of the wrist stays as it is, one near another singularity is refused, see `singular`.

mod before;
mod configuration;
mod correction;
mod corrector;
mod external;
mod frames;
mod inverse;
mod judged;
mod lean;
mod near;
mod offsets;
mod options;
mod outside;
mod placed;
mod signals;
mod singular;
mod solutions;
mod taught;
mod three_points;
mod work;

pub use correction::{Correction, Outcome};
pub use frames::{is_stated, unused};
pub use offsets::{Gathered, Offset, Remaining, gathered, offsets};
pub use options::{CorrectOptions, Taught, Touched};

use crate::ControllerError;
use crate::program::{Branch, Point, Program, Value};
use crate::route::route;
use before::{Before, Travel};
use corrector::{Corrector, Placing};
use external::{Arms, External};
use taught::{Learned, Toucher};
use truepose_errormodel::{ErrorModel, FittedModel};
use truepose_kinematics::Chain;
use truepose_kinematics::nalgebra::DMatrix;
use work::Work;

/// Corrects all points of a program; one correction for each, in their order.
///
/// # Errors
/// When the fit or the options do not fit the program; a point that cannot be corrected is no error but refused.
pub fn correct(
    program: &Program,
    fitted: &FittedModel,
    options: &CorrectOptions,
) -> Result<Vec<Correction>, ControllerError> {
    let all = correct_all(std::slice::from_ref(program), fitted, options)?;
    Ok(all.into_iter().flatten().collect())
}

/// Corrects all points of the files of a program ([`Program::read_all`]); a list for each file.
///
/// # Errors
/// As [`correct`].
pub fn correct_all(
    programs: &[Program],
    fitted: &FittedModel,
    options: &CorrectOptions,
) -> Result<Vec<Vec<Correction>>, ControllerError> {
    let chain = fitted.chain();
    if let Some(mimic) = chain.mimics().first() {
        let (joint, driver) = (&chain.joint(mimic.joint).name, &chain.joint(mimic.driver).name);
        let words = format!(
            "joint {joint} follows {driver}, which no program of a controller can say; use `compensate --poses`"
        );
        return Err(ControllerError::Fit(words));
    }
    let external = External::new(chain, options)?;
    let arms = Arms::of(chain, &external, programs, options)?;
    let learned = Learned::new(programs, &Toucher { fitted, options, hand: external.hand })?;
    let work = Work::new(chain, &external, options)?;
    let placing = Placing { external, arms, learned, work };
    let new = |program| Corrector::new(program, fitted, &placing, options);
    let mut correctors = programs.iter().map(new).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = correctors.first() else { return Ok(Vec::new()) };
    let start = first.start()?.map(Before::at).unwrap_or_default();
    let mut before = start.clone();
    let mut done: Vec<Vec<Option<Done>>> =
        programs.iter().map(|program| vec![None; program.points().len()]).collect();
    for stop in route(programs) {
        if stop.first {
            before = start.clone();
        }
        if stop.points.is_empty() {
            before.elsewhere(stop.linear);
        }
        let travel = Travel { linear: stop.linear, followed: stop.followed };
        let from = before.clone();
        for (file, k) in stop.points {
            let point = &programs[file].points()[k];
            let (_, at) = done[file][k].get_or_insert_with(|| correctors[file].point(point, travel, &from));
            let named = || match point.name.contains(" in line ") {
                true => point.name.clone(),
                false => format!("{} in line {}", point.name, point.line),
            };
            before.reach(at, named, stop.linear);
            before.opaque = opaque(point);
        }
    }
    let mut all = Vec::with_capacity(programs.len());
    let unreached = Travel { linear: false, followed: true };
    for ((program, corrector), done) in programs.iter().zip(&mut correctors).zip(done) {
        let points = program.points().iter().zip(done);
        let one = |(point, done): (&Point, Option<Done>)| {
            done.unwrap_or_else(|| corrector.point(point, unreached, &start)).0
        };
        all.push(points.map(one).collect());
    }
    Ok(all)
}

/// A correction, and the joints of its point (variables).
type Done = (Correction, Result<Vec<f64>, before::Open>);

fn without_errors(chain: Chain) -> Result<FittedModel, ControllerError> {
    Ok(FittedModel::new(ErrorModel::new(chain, Vec::new())?, Vec::new(), DMatrix::zeros(0, 0))?)
}

/// Configuration data that is not interpreted.
fn opaque(point: &Point) -> Option<String> {
    match &point.value {
        Value::Pose { branch: Branch::Opaque(words), .. } => Some(words.clone()),
        _ => None,
    }
}
