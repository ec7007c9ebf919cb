//! The workloads, one file each.

use crate::prelude::*;
mod arm;
mod commands;
mod disk;
mod folds;
mod paper;
mod points;
mod postures;

use truepose_identify::Residuals;
use truepose_identify::engine::left_over;

/// In the order in which they run.
pub const ALL: &[Workload] = &[
    paper::W1,
    arm::W2,
    points::W3_200K,
    points::W3_1M,
    disk::DISK_200K,
    disk::DISK_1M,
    folds::W4,
    postures::W5,
    commands::W6,
    arm::W7,
    postures::GRAM,
    postures::VARIANCES,
    postures::PACKED_JACOBIANS,
];

/// A way whose runs leave their answer behind.
fn shared(run: impl FnMut() -> Outcome<Answer> + 'static) -> Outcome<Way> {
    shared_with(run, |answer: &Answer| Ok(answer.clone()))
}

/// A way whose runs leave behind what the answer is then made of.
fn shared_with<T: 'static>(
    mut run: impl FnMut() -> Outcome<T> + 'static,
    mut answer: impl FnMut(&T) -> Outcome<Answer> + 'static,
) -> Outcome<Way> {
    let last = Rc::new(RefCell::new(None));
    let kept = last.clone();
    Ok(Way {
        run: Box::new(move || {
            kept.replace(Some(run()?));
            Ok(())
        }),
        check: Box::new(move || answer(last.borrow().as_ref().ok_or("nothing was run")?)),
    })
}

/// A workload over so many points of the paper's model with 224 columns, each of which makes any way move so many bytes.
const fn of_points(
    (name, about): (&'static str, &'static str),
    (points, bytes): (f64, f64),
    ways: &'static [Declared],
) -> Workload {
    let r = 224.0;
    let flops = points * (3.0 * r * (r + 1.0) + 9.0 * r + 900.0) + r * r * r / 3.0;
    Workload::of(name, about, [flops, points * bytes], &[("rank", 9), ("rms_fit_um", 9)], ways)
}

/// The answer over points: the rank, and what these coefficients leave.
fn answer_of_points(
    model: &ErrorModel,
    data: &Dataset,
    rank: usize,
    coefficients: &[f64],
) -> Outcome<Answer> {
    let zero = vec![0.0; coefficients.len()];
    let residual = Residual::of(&left_over(model, data, &zero, coefficients)?);
    Ok(Answer::from([("rank".into(), rank as f64), ("rms_fit_um".into(), residual.position_um)]))
}

/// Sizes of residuals under the peers' names.
struct Residual {
    /// 3-D RMS of the position, µm.
    position_um: f64,
    /// 3-D RMS of the orientation, µrad.
    orientation_urad: f64,
}

impl Residual {
    fn of(residuals: &Residuals) -> Self {
        let rms = |squares: f64, count: usize| 1e6 * (squares / count.max(1) as f64).sqrt();
        let position: f64 = residuals.position.iter().map(|v| v.norm_squared()).sum();
        let turned: f64 = residuals.orientation.iter().flatten().map(|v| v.norm_squared()).sum();
        let turns = residuals.orientation.iter().flatten().count();
        Residual {
            position_um: rms(position, residuals.position.len()),
            orientation_urad: rms(turned, turns),
        }
    }

    fn answer(self, rank: usize) -> Answer {
        [
            ("rank".into(), rank as f64),
            ("rms_pos_um".into(), self.position_um),
            ("rms_rot_urad".into(), self.orientation_urad),
        ]
        .into()
    }
}
