//! What is left, traced to one effect and set against what drives it: the picture that convinces, or does not.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | r | residual of a row's position under the final model | m |
//! | m | how the position moves with a unit of the effect's own error: of its joint about its axis, else of the site that moves most | m per rad, m or kg |
//! | f | the effect's own error in the final model | rad, m or kg |
//! | e = m·r / m·m | what is left, as an error of that kind: `after`; e + f is `before` | rad, m or kg |
//!
//! A partial residual: all other effects stay in the model. Rows whose position hardly depends on the error (small |m|)
//! scatter widely in e; `lever` is their weight.

use crate::candidate::{Candidate, Change};
use crate::library::load_word;
use crate::{DiscoverError, Family};
use nalgebra::{DVector, Vector3};
use truepose_errormodel::{Dataset, Emission, ErrorJacobian, ErrorModel, Rest};
use truepose_identify::Fit;
use truepose_kinematics::{Axis, Chain, JointId, JointKind, JointMotion, Load, Site};

/// One effect against its driver, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Which error: `a2 about its axis`.
    pub what: String,
    /// Its unit: rad, m or kg.
    pub unit: &'static str,
    /// What drives it: a joint, a load, a channel, the time.
    pub driver: String,
    /// The driver's unit, SI or as the channel has it.
    pub driver_unit: String,
    /// Names of the classes that points belong to (sides of approach); empty without classes.
    pub classes: Vec<String>,
    /// Rows whose position was measured and depends on the error.
    pub points: Vec<TracePoint>,
}

/// One row of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePoint {
    /// Row of the data (0-based).
    pub row: usize,
    /// The driver.
    pub driver: f64,
    /// What the effect is not asked to explain away: e + f.
    pub before: f64,
    /// What is left: e.
    pub after: f64,
    /// What the model says: f.
    pub fitted: f64,
    /// Standard deviation of f from its coefficients.
    pub sd: f64,
    /// |m|.
    pub lever: f64,
    /// Which class.
    pub class: usize,
}

/// What a finding is set against.
enum Driver {
    Joint(usize),
    JointLoad(JointId),
    /// The component of the wrench at a frame that goes with the effect.
    Wrench(truepose_kinematics::FrameId),
    Channel(usize),
    Time,
    Visit,
}

/// Whose error it is.
enum Own {
    Motion(JointMotion),
    Site(Site),
}

/// Rows in the final model; `first` is the number of the finding's first effect. None when nothing can be shown.
pub(crate) fn trace(
    fit: &Fit,
    data: &Dataset,
    candidate: &Candidate,
    first: usize,
) -> Result<Option<Trace>, DiscoverError> {
    let count = candidate.effects().len();
    if count == 0 {
        return load_trace(fit, data, candidate);
    }
    let model = fit.fitted.model();
    let chain = model.chain();
    let columns = model.columns_of(first).start..model.columns_of(first + count - 1).end;
    let Some(own) = own(fit, data, candidate, columns.clone())? else { return Ok(None) };
    let driver = driver(chain, data, candidate, &own);
    let joint = candidate.place.joint.as_deref().and_then(|name| chain.joint_named(name));
    let approach = joint
        .filter(|_| candidate.family == Family::Backlash && data.schema.approach)
        .and_then(|joint| chain.coordinate(joint));
    let covariance =
        fit.fitted.covariance().view((columns.start, columns.start), (columns.len(), columns.len()));

    let bound = model.bind(&data.schema)?;
    let mut rest = Rest::new(model);
    let mut points = Vec::new();
    let mut wrenches: Vec<[f64; 6]> = Vec::new();
    for row in 0..data.len() {
        let seen = data.seen(row).position;
        if seen == [false; 3] {
            continue;
        }
        let conditions = data.conditions(row);
        rest.settle(&bound, &conditions, fit.fitted.coefficients());
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), data.target[row]);
        let mask = |v: Vector3<f64>| Vector3::from_fn(|k, _| if seen[k] { v[k] } else { 0.0 });
        let difference = mask(data.measured_position(row) - jacobian.point());
        let (moved, shape) = own.read(&jacobian, rest.emission(), &columns);
        let moved = mask(moved);
        let square = moved.norm_squared();
        if square.sqrt() < 1e-9 {
            continue;
        }
        let fitted =
            shape.iter().zip(columns.clone()).map(|(s, c)| s * fit.fitted.coefficients()[c]).sum::<f64>();
        let after = moved.dot(&difference) / square;
        let settled = rest.posture_at_rest(&bound, &conditions, fit.fitted.coefficients());
        let posture = settled.view(chain, &conditions);
        let value = match &driver {
            Driver::Joint(k) => data.joints[*k][row],
            Driver::JointLoad(joint) => posture.joint_load(*joint),
            Driver::Wrench(frame) => {
                let wrench = posture.wrench(*frame);
                let (f, m) = (wrench.force, wrench.moment);
                wrenches.push([f.x, f.y, f.z, m.x, m.y, m.z]);
                0.0
            }
            Driver::Channel(k) => data.channels[*k][row],
            Driver::Time => data.time[row],
            Driver::Visit => data.visit[row] as f64 + 1.0,
        };
        points.push(TracePoint {
            row,
            driver: value,
            before: after + fitted,
            after,
            fitted,
            sd: (shape.transpose() * covariance * &shape)[(0, 0)].max(0.0).sqrt(),
            lever: square.sqrt(),
            class: approach.map_or(0, |k| class_of(data.approach[k][row])),
        });
    }
    if points.is_empty() {
        return Ok(None);
    }
    let (driver, driver_unit) = match driver {
        Driver::Wrench(frame) => {
            let component = strongest(&points, &wrenches);
            points.iter_mut().zip(&wrenches).for_each(|(p, w)| p.driver = w[component]);
            let word = ["force x", "force y", "force z", "moment x", "moment y", "moment z"][component];
            (format!("{word} at {}", chain.frame_word(frame)), if component < 3 { "N" } else { "N*m" }.into())
        }
        Driver::Joint(k) => {
            let joint = chain.joint(chain.movable()[k]);
            (joint.name.clone(), joint.unit().into())
        }
        Driver::JointLoad(joint) => {
            let joint = chain.joint(joint);
            let unit = if joint.unit() == "m" { "N" } else { "N*m" };
            (format!("load on {}", joint.name), unit.into())
        }
        Driver::Channel(k) => {
            let channel = &data.schema.channels[k];
            (channel.name.clone(), channel.unit.clone())
        }
        Driver::Time => ("time".into(), "s".into()),
        Driver::Visit => ("visit".into(), String::new()),
    };
    let classes = match approach {
        Some(_) => ["last moved down", "did not move", "last moved up"].map(String::from).to_vec(),
        None => Vec::new(),
    };
    Ok(Some(Trace { what: own.words(chain), unit: own.unit(), driver, driver_unit, classes, points }))
}

fn class_of(approach: f64) -> usize {
    if approach < 0.0 {
        0
    } else if approach > 0.0 {
        2
    } else {
        1
    }
}

impl Own {
    /// How the position moves with a unit of the error, and the error per unit of each coefficient.
    fn read(
        &self,
        jacobian: &ErrorJacobian<'_>,
        emission: &Emission,
        columns: &std::ops::Range<usize>,
    ) -> (Vector3<f64>, DVector<f64>) {
        let mut shape = DVector::zeros(columns.len());
        let mut moved = Vector3::zeros();
        match self {
            Own::Site(site) => {
                moved = jacobian.position(*site);
                for entry in emission.entries() {
                    if columns.contains(&entry.column) && entry.site == *site {
                        shape[entry.column - columns.start] += entry.value;
                    }
                }
            }
            Own::Motion(motion) => {
                let first = first_axis(motion);
                for k in 0..3 {
                    moved +=
                        motion.axis[k] * jacobian.position(Site::Frame(motion.frame, Axis::ALL[first + k]));
                }
                for entry in emission.entries().iter().filter(|e| columns.contains(&e.column)) {
                    if let Site::Frame(frame, axis) = entry.site
                        && frame == motion.frame
                        && axis.index() >= first
                        && axis.index() < first + 3
                    {
                        shape[entry.column - columns.start] +=
                            entry.value * motion.axis[axis.index() - first];
                    }
                }
            }
        }
        (moved, shape)
    }

    fn words(&self, chain: &Chain) -> String {
        match self {
            Own::Site(site) => chain.site_word(*site),
            Own::Motion(motion) => {
                let how = if motion.kind == JointKind::Prismatic { "along" } else { "about" };
                format!("{} {how} its axis", chain.joint(motion.joint).name)
            }
        }
    }

    fn unit(&self) -> &'static str {
        let turning = match self {
            Own::Motion(motion) => motion.kind != JointKind::Prismatic,
            Own::Site(Site::Frame(_, axis)) => axis.index() >= 3,
            Own::Site(Site::Target(..)) => false,
        };
        if turning { "rad" } else { "m" }
    }
}

fn first_axis(motion: &JointMotion) -> usize {
    if motion.kind == JointKind::Prismatic { 0 } else { 3 }
}

/// The joint's own motion where the cause is one of a joint, else the site whose error moves the target most.
fn own(
    fit: &Fit,
    data: &Dataset,
    candidate: &Candidate,
    columns: std::ops::Range<usize>,
) -> Result<Option<Own>, DiscoverError> {
    /// Rows that are asked.
    const ASKED: usize = 300;
    let model: &ErrorModel = fit.fitted.model();
    let chain = model.chain();
    let of_a_joint = matches!(
        candidate.family,
        Family::Backlash
            | Family::Transmission
            | Family::Coupling
            | Family::JointCompliance
            | Family::LoadNonlinearity
    );
    let motion = candidate
        .place
        .joint
        .as_deref()
        .filter(|_| of_a_joint)
        .and_then(|name| chain.joint_named(name))
        .and_then(|joint| chain.joint_motion(joint));
    if let Some(motion) = motion {
        return Ok(Some(Own::Motion(motion)));
    }
    let bound = model.bind(&data.schema)?;
    let mut rest = Rest::new(model);
    let mut energy = vec![0.0; chain.site_count()];
    for row in (0..data.len()).step_by(data.len().div_ceil(ASKED).max(1)) {
        rest.settle(&bound, &data.conditions(row), fit.fitted.coefficients());
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), data.target[row]);
        let mut sites = vec![0.0; chain.site_count()];
        for entry in rest.emission().entries().iter().filter(|e| columns.contains(&e.column)) {
            sites[chain.site_index(entry.site)] += entry.value * fit.fitted.coefficients()[entry.column];
        }
        for (k, error) in sites.iter().enumerate().filter(|(_, e)| e.abs() > 0.0) {
            energy[k] += error * error * jacobian.position(chain.site_at(k)).norm_squared();
        }
    }
    let best = (0..energy.len()).max_by(|&a, &b| energy[a].total_cmp(&energy[b]));
    Ok(best.filter(|&k| energy[k] > 0.0).map(|k| Own::Site(chain.site_at(k))))
}

fn driver(chain: &Chain, data: &Dataset, candidate: &Candidate, own: &Own) -> Driver {
    let place = &candidate.place;
    let joint = |name: &Option<String>| name.as_deref().and_then(|name| chain.joint_named(name));
    let coordinate = |name: &Option<String>| joint(name).and_then(|joint| chain.coordinate(joint));
    let channel = |name: &Option<String>| name.as_deref().and_then(|name| data.schema.channel(name));
    let when = if data.schema.time { Driver::Time } else { Driver::Visit };
    match candidate.family {
        Family::Backlash => {
            let side = candidate.effects().first().and_then(|e| e.parameters().get("side").cloned());
            let by_load = side.is_some_and(|side| side != "approach");
            match joint(&place.joint) {
                Some(joint) if by_load => Driver::JointLoad(joint),
                Some(joint) => chain.coordinate(joint).map_or(when, Driver::Joint),
                None => when,
            }
        }
        Family::JointCompliance | Family::LoadNonlinearity => {
            joint(&place.joint).map_or(when, Driver::JointLoad)
        }
        Family::LinkCompliance | Family::BaseCompliance => match own {
            Own::Site(Site::Frame(frame, _)) => Driver::Wrench(*frame),
            _ => when,
        },
        Family::Coupling => coordinate(&place.driver).map_or(when, Driver::Joint),
        Family::Thermal => {
            let late = candidate.effects().iter().flat_map(|e| e.needs()).find_map(|need| match need {
                truepose_errormodel::Signal::Channel(name) => data.schema.channel(&name),
                _ => None,
            });
            late.or_else(|| channel(&place.channel)).map_or(when, Driver::Channel)
        }
        Family::Shift | Family::Drift | Family::Payload | Family::Outlier => when,
        Family::Target => Driver::Visit,
        Family::Unmodelled => coordinate(&place.covariate)
            .map(Driver::Joint)
            .or_else(|| channel(&place.covariate).map(Driver::Channel))
            .or_else(|| loaded(chain, &place.covariate).map(Driver::JointLoad))
            .unwrap_or(when),
        Family::Transmission | Family::Guideway | Family::Geometric => {
            coordinate(&place.joint).map_or(when, Driver::Joint)
        }
    }
}

/// The joint on whose load something depends.
fn loaded(chain: &Chain, covariate: &Option<String>) -> Option<JointId> {
    let word = covariate.as_deref()?;
    chain.movable().iter().copied().find(|&joint| load_word(chain, joint) == word)
}

/// The component of the wrench that goes most with what the model says.
fn strongest(points: &[TracePoint], wrenches: &[[f64; 6]]) -> usize {
    let n = points.len().max(1) as f64;
    let mean = points.iter().map(|p| p.fitted).sum::<f64>() / n;
    let together = |k: usize| -> f64 {
        let middle = wrenches.iter().map(|w| w[k]).sum::<f64>() / n;
        let (mut both, mut square) = (0.0, 0.0);
        for (point, wrench) in points.iter().zip(wrenches) {
            both += (point.fitted - mean) * (wrench[k] - middle);
            square += (wrench[k] - middle).powi(2);
        }
        if square > 0.0 { both * both / square } else { 0.0 }
    };
    (0..6).max_by(|&a, &b| together(a).total_cmp(&together(b))).unwrap_or(0)
}

/// A wrong payload: what the rows that declare it say, in kg.
fn load_trace(fit: &Fit, data: &Dataset, candidate: &Candidate) -> Result<Option<Trace>, DiscoverError> {
    const STEP: f64 = 1e-2;
    let Change::CorrectLoad { level, mass, .. } = candidate.change else { return Ok(None) };
    let mut predictor = fit.fitted.bind(&data.schema)?;
    let mut points = Vec::new();
    for row in 0..data.len() {
        let conditions = data.conditions(row);
        let carried = matches!(conditions.load, Load::Payload(p) if (p.mass - mass).abs() < 1e-12);
        let Some(more) = crate::payload::changed(&conditions, mass, mass + STEP).filter(|_| carried) else {
            continue;
        };
        let here = predictor.predict(&conditions, data.target[row]).translation;
        let there = predictor.predict(&more, data.target[row]).translation;
        let (moved, difference) = ((there - here) / STEP, data.measured_position(row) - here);
        let square = moved.norm_squared();
        if square.sqrt() < 1e-9 || !difference.norm().is_finite() {
            continue;
        }
        let (after, fitted) = (moved.dot(&difference) / square, mass - level);
        let driver = if data.schema.time { data.time[row] } else { data.visit[row] as f64 + 1.0 };
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
    let (driver, unit) = if data.schema.time { ("time", "s") } else { ("visit", "") };
    Ok((!points.is_empty()).then(|| Trace {
        what: format!("mass beyond the declared {level} kg"),
        unit: "kg",
        driver: driver.into(),
        driver_unit: unit.into(),
        classes: Vec::new(),
        points,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_component_that_goes_with_the_effect_is_chosen() {
        let wave = |k: usize| (0.7 * k as f64).sin();
        let points: Vec<TracePoint> = (0..40)
            .map(|row| TracePoint {
                row,
                driver: 0.0,
                before: 0.0,
                after: 0.0,
                fitted: 3.0 + wave(row),
                sd: 0.0,
                lever: 1.0,
                class: 0,
            })
            .collect();
        let wrenches: Vec<[f64; 6]> =
            (0..40).map(|k| [9.0, (1.9 * k as f64).cos(), k as f64, 0.0, -50.0 * wave(k), 2.0]).collect();
        assert_eq!(strongest(&points, &wrenches), 4);
    }
}
