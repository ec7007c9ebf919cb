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

mod driver;
mod error_source;
mod load;
pub(crate) mod point;

use crate::conclude::trace::driver::{Abscissa, abscissa, strongest};
use crate::conclude::trace::error_source::error_source;
use crate::conclude::trace::load::load_trace;
use crate::conclude::trace::point::{Trace, TracePoint};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::driver::Driver;
use nalgebra::Vector3;
use truepose_errormodel::{Dataset, Equilibrium, ErrorJacobian};
use truepose_identify::Fit;

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
    let data = &*data.derived_for(model)?;
    let view = candidate.hypothesis().view(&candidate.place, candidate.effects());
    let own_motion = candidate.place.joint.as_deref().filter(|_| view.own_motion);
    let Some(own) = error_source(fit, data, own_motion, columns.clone())? else { return Ok(None) };
    let driver = abscissa(chain, data, &view.against, &own);
    let joint = candidate.place.joint.as_deref().and_then(|name| chain.joint_named(name));
    let approach =
        joint.filter(|_| view.by_approach && data.schema.approach).and_then(|joint| chain.coordinate(joint));
    let covariance =
        fit.fitted.covariance().view((columns.start, columns.start), (columns.len(), columns.len()));

    let bound = model.bind(&data.schema)?;
    let mut rest = Equilibrium::new(model);
    let mut points = Vec::new();
    let mut wrenches: Vec<[f64; 6]> = Vec::new();
    for row in 0..data.len() {
        let seen = data.seen(row).position;
        if seen == [false; 3] {
            continue;
        }
        let conditions = data.conditions(row);
        rest.settle(&bound, &conditions, fit.fitted.coefficients());
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), data.aim(row));
        let ray = data.ray(row);
        let mask = |v: Vector3<f64>| match ray {
            Some(w) => w * (w.dot(&v) / w.norm_squared()),
            None => Vector3::from_fn(|k, _| if seen[k] { v[k] } else { 0.0 }),
        };
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
            Abscissa::Joint(k) => data.joints[*k][row],
            Abscissa::JointLoad(joint) => posture.joint_load(*joint),
            Abscissa::Wrench(frame) => {
                let wrench = posture.wrench(*frame);
                let (f, m) = (wrench.force, wrench.moment);
                wrenches.push([f.x, f.y, f.z, m.x, m.y, m.z]);
                0.0
            }
            Abscissa::Channel(k) => data.channels[*k][row],
            Abscissa::Time => data.time[row],
            Abscissa::Pose => data.visit[row] as f64 + 1.0,
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
        Abscissa::Wrench(frame) => {
            let component = strongest(&points, &wrenches);
            points.iter_mut().zip(&wrenches).for_each(|(p, w)| p.driver = w[component]);
            let word = ["force x", "force y", "force z", "moment x", "moment y", "moment z"][component];
            (format!("{word} at {}", chain.frame_word(frame)), if component < 3 { "N" } else { "N*m" }.into())
        }
        Abscissa::Joint(k) => {
            let joint = chain.joint(chain.movable()[k]);
            (joint.name.clone(), joint.unit().into())
        }
        Abscissa::JointLoad(joint) => {
            let joint = chain.joint(joint);
            let unit = if joint.unit() == "m" { "N" } else { "N*m" };
            (Driver::JointLoad(joint.name.clone()).to_string(), unit.into())
        }
        Abscissa::Channel(k) => {
            let channel = &data.schema.channels[k];
            (channel.name.clone(), channel.unit.clone())
        }
        Abscissa::Time => (Driver::Time.to_string(), "s".into()),
        Abscissa::Pose => (Driver::Pose.to_string(), String::new()),
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
