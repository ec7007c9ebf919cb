//! `cargo xtask micro kinematics`: sines, a posture with its statics, a joint Jacobian.

use divan::{Bencher, black_box};
use truepose_kinematics::{Conditions, PostureBuffer, joint_jacobian, samples, sin_cos};

fn main() {
    divan::main();
}

#[divan::bench]
fn sine_and_cosine(bencher: Bencher<'_, '_>) {
    bencher.bench(|| sin_cos(black_box(0.7)));
}

#[divan::bench(args = ["ur10", "heavy", "pps"])]
fn posture(bencher: Bencher<'_, '_>, name: &str) {
    let chain = match name {
        "ur10" => samples::ur10(),
        "heavy" => samples::heavy(),
        _ => samples::pps(),
    };
    let conditions = Conditions::at(&chain, &vec![0.2; chain.movable().len()]);
    let mut buffer = PostureBuffer::new(&chain);
    bencher.bench_local(|| *buffer.update(&chain, black_box(&conditions)).tool());
}

#[divan::bench]
fn jacobian_of_the_joints(bencher: Bencher<'_, '_>) {
    let chain = samples::ur10();
    let conditions = Conditions::at(&chain, &[0.2; 6]);
    let mut buffer = PostureBuffer::new(&chain);
    let posture = buffer.update(&chain, &conditions);
    let point = posture.tool().translation;
    bencher.bench(|| joint_jacobian(black_box(&posture), &point));
}
