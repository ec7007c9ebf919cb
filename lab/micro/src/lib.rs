#![doc = include_str!("../README.md")]

pub mod clock;
/// The fits of the tests of `truepose-compensate`.
#[path = "../../../crates/compensate/tests/all/fits/mod.rs"]
#[allow(missing_docs, clippy::should_implement_trait, reason = "made for tests")]
pub mod fits;

pub use fits::{Draw, elastic, load, target_at};

use truepose_errormodel::{Dataset, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Load, TargetId, Wrench};

/// Median, 99.9 % and largest of times, µs.
pub fn latencies(mut seconds: Vec<f64>) -> [f64; 3] {
    seconds.sort_by(f64::total_cmp);
    let n = seconds.len();
    [n / 2, n * 999 / 1000, n - 1].map(|k| 1e6 * seconds[k])
}

/// Points of a robot with limits, from number `first` on: spread over its travels, under a load that changes, off by a smooth error.
pub fn points(chain: &Chain, first: usize, count: usize) -> Dataset {
    let movable = chain.movable();
    // Multiples of square roots of primes, modulo one, fill a cube evenly (Weyl 1916).
    let roots: Vec<f64> = [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0].iter().map(|p| p.sqrt()).collect();
    let mut data = Dataset {
        schema: Schema { load: true, ..Schema::default() },
        joints: vec![Vec::with_capacity(count); movable.len()],
        approach: vec![vec![0.0; count]; movable.len()],
        position_sd: vec![[f64::NAN; 3]; count],
        orientation: vec![None; count],
        orientation_sd: vec![[f64::NAN; 3]; count],
        visit: (0..count).collect(),
        time: vec![0.0; count],
        ..Dataset::default()
    };
    let mut q = vec![0.0; movable.len()];
    for k in first..first + count {
        for (j, (value, &joint)) in q.iter_mut().zip(movable).enumerate() {
            let (lower, upper) = chain.joint(joint).limits.unwrap_or((-1.0, 1.0));
            *value = lower + (upper - lower) * ((k + 1) as f64 * roots[j]).fract();
        }
        data.joints.iter_mut().zip(&q).for_each(|(column, q)| column.push(*q));
        let target = k % chain.targets().len().max(1);
        let position = chain.targets().get(target).map_or_else(Vector3::zeros, |t| t.position);
        let nominal = chain.forward(&q).apply(&position);
        let off = |k: usize| 1e-3 * (3.0 * q[k] + q[(k + 2) % q.len()]).sin();
        data.position.push([nominal.x + off(0), nominal.y + off(1), nominal.z + off(2)]);
        data.target.push(chain.targets().get(target).map(|_| TargetId(target)));
        let part = |root: f64| ((k + 1) as f64 * root).fract() - 0.5;
        let force = Vector3::new(0.0, 600.0 * part(roots[6]), -500.0 * part(1.618_033_988_749_895));
        let moment = Vector3::new(300.0 * part(std::f64::consts::E), 0.0, 0.0);
        data.load.push(Load::Wrench(Wrench { force, moment }));
    }
    data
}
