//! `cargo xtask micro compensate`: one command from the nominal joints. `cargo xtask micro commands` has distributions.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use truepose_compensate::{Compensator, CompensatorOptions};
use truepose_errormodel::Schema;
use truepose_kinematics::{Chain, Conditions, samples};
use truepose_micro::{Draw, elastic, load, target_at};

fn main() {
    divan::main();
}

fn arm(name: &str) -> Chain {
    match name {
        "heavy" => samples::heavy(),
        "seven" => samples::seven(),
        _ => samples::ur10(),
    }
}

#[divan::bench(args = ["ur10", "heavy", "seven"])]
fn command(bencher: Bencher<'_, '_>, name: &str) {
    let chain = arm(name);
    let fitted = elastic(&chain, 1);
    let options = CompensatorOptions::default();
    let mut compensator =
        Compensator::bind(&fitted, &Schema { load: true, ..Schema::default() }, options).expect("it binds");
    let joints = Draw(3).joints(&chain, 0.5);
    let conditions = Conditions::at(&chain, &joints).with_load(load(&chain));
    let target = target_at(&chain.forward(&joints));
    bencher
        .counter(ItemsCount::new(1_usize))
        .bench_local(|| compensator.command(black_box(&target), &conditions, Some(&joints)).status);
}
