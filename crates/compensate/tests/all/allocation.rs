//! No command allocates: counted by an allocator that counts.

use crate::fits::{Draw, elastic, fitted, load, target_at};
use std::sync::Arc;
use truepose_compensate::{Approach, Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::{Fallback, FittedModel, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, samples};

/// A fit with findings, which commands and predictions blend with the declared model.
fn with_findings(chain: &Chain) -> FittedModel {
    let fallback = Fallback { declared: Arc::new(elastic(chain, 5)), usual: 1e-12, scale: 1e-8, size: 1e-8 };
    fitted(chain, 5).with_fallback(Some(fallback))
}

#[test]
fn no_command_allocates() {
    let schema = Schema { load: true, approach: true, ..Schema::default() };
    for chain in samples::all() {
        for approach in [Approach::Stated, Approach::FromSeed] {
            for fit in [fitted(&chain, 5), with_findings(&chain)] {
                let options = CompensatorOptions { approach, ..CompensatorOptions::default() };
                let mut compensator = Compensator::bind(&fit, &schema, options).expect("bound");
                let mut draw = Draw(2);
                let mut jobs = Vec::new();
                for k in 0..40 {
                    let conditions =
                        Conditions::at(&chain, &draw.joints(&chain, 0.9)).with_load(load(&chain));
                    let pose = chain.forward(&conditions.joints);
                    let target = match k % 4 {
                        0 => Target::at(pose.translation),
                        1 => Target::at(Vector3::new(30.0, 0.0, 0.0)).turned(pose.rotation),
                        2 => Target::at(Vector3::new(f64::NAN, 0.0, 0.0)),
                        _ => target_at(&pose),
                    };
                    jobs.push((target, conditions));
                }
                let mut ok = 0;
                let counted = allocation_counter::measure(|| {
                    for (target, conditions) in &jobs {
                        for seed in [None, Some(&conditions.joints[..])] {
                            ok += usize::from(
                                compensator.command(target, conditions, seed).status == Status::Ok,
                            );
                        }
                        compensator.predict(conditions, None);
                    }
                });
                assert_eq!(counted.count_total, 0, "{}", chain.name());
                assert!(ok >= 20, "{}: {ok}", chain.name());
            }
        }
    }
}
