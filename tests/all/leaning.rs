//! The stated error of points whose frame or tool the robot itself has placed: drawn robots, as likely as the covariance of the fit has them, miss the points by as
//! much as it states.

use crate::taught_frames::Fixture;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_controllers::{CorrectOptions, Dialect, Outcome, Program, correct};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::{Conditions, ToolId};

/// Larger than those of the fit, so that they count beside the digits of a program.
const SPREAD: f64 = 10.0;

const DRAWS: usize = 60;

/// A sum of uniform numbers is normal enough up to two and a half deviations.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
}

/// The share of points that drawn robots miss by at most what is stated for 95 %, with the coefficients alone.
pub fn share_within(program: &Program, fitted: &FittedModel, options: &CorrectOptions, hand: ToolId) -> f64 {
    let wide = fitted.covariance() * SPREAD.powi(2);
    let mut fitted = fitted.clone().with_covariance(wide).expect("a covariance");
    fitted.noise.position_sd = 0.0;
    let root = fitted.covariance().clone().symmetric_eigen();
    let corrections = correct(program, &fitted, options).expect("corrections");
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let (mut inside, mut all) = (0, 0);
    for _ in 0..DRAWS {
        let draw = DVector::from_iterator(
            root.eigenvalues.len(),
            root.eigenvalues.iter().map(|value| value.max(0.0).sqrt() * normal(&mut rng)),
        );
        let moved = &root.eigenvectors * draw;
        let coefficients = fitted.coefficients().iter().zip(moved.iter()).map(|(c, d)| c + d).collect();
        let other = FittedModel::new(fitted.model().clone(), coefficients, fitted.covariance().clone());
        let other = other.expect("a fit").with_domain(fitted.domain.clone());
        let schema = Schema { load: true, ..Schema::default() };
        let mut robot = other.bind(&schema).expect("a predictor");
        let meant = correct(program, &other, options).expect("corrections");
        for (one, meant) in corrections.iter().zip(&meant).skip(1) {
            if one.outcome != Outcome::Corrected {
                continue;
            }
            let joints = one.corrected.as_deref().expect("joints");
            let conditions = Conditions { tool: hand, ..Conditions::at(other.chain(), joints) };
            let there = robot.predict(&conditions, None).translation;
            let desired = meant.desired.expect("a desired position");
            inside += usize::from(
                (there - nalgebra::Vector3::from(desired)).norm() < one.within_95.expect("a bound"),
            );
            all += 1;
        }
    }
    assert!(all > 10 * DRAWS, "{all}");
    inside as f64 / all as f64
}

fn check(what: &str, share: f64) {
    println!("{what}: {:.1} % of drawn robots are within the stated 95 %", 100.0 * share);
    // Points of one draw are alike: 60 draws give the share within 4 % at best.
    assert!((0.90..0.99).contains(&share), "{what}: {share}");
}

#[test]
fn drawn_robots_are_within_the_stated_error_of_points_in_a_taught_frame() {
    let fixture = Fixture::new();
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let options = CorrectOptions { taught: vec![fixture.taught()], ..fixture.options() };
    check("taught frame", share_within(&program, &fixture.fitted, &options, ToolId::FIRST));
    let of = |options: &CorrectOptions| {
        let all = correct(&program, &fixture.fitted, options).expect("corrections");
        all[1].within_95.expect("a bound")
    };
    // The first point is where the frame was touched: robot and frame are wrong together.
    let (taught, measured) = (of(&options), of(&fixture.options()));
    println!("at the origin: taught {taught:e} m, measured {measured:e} m");
}

#[test]
fn drawn_robots_are_within_the_stated_error_of_points_of_a_taught_tool() {
    let (fixture, taught) = Fixture::with_a_taught_tool();
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let options = CorrectOptions { taught: vec![taught], ..fixture.options() };
    check("taught tool", share_within(&program, &fixture.fitted, &options, ToolId::FIRST));
}
