//! What speaks against a candidate, from its evidence alone.

use crate::accept::evidence::{Doubt, Evidence, Gain};
use crate::policy::Policy;

/// Evidence of an effect that passes every test: half of an error of 0.1 mm goes.
fn convincing() -> Evidence {
    let gain = Gain { before: 1e-4, after: 5e-5, t: 8.0, won: 0.5, middle: 0.5 };
    Evidence {
        p_sign_flips: 0.001,
        p_surrogates: None,
        effective_poses: 30.0,
        p_value: 0.001,
        p_parametric: 1e-9,
        unknowns: 2,
        gain: 300.0,
        random: gain,
        blocks: Some(gain),
        stability: 1.0,
        agreement: 1.0,
    }
}

fn doubt(change: impl FnOnce(&mut Evidence), policy: &Policy, of_time: bool) -> Option<Doubt> {
    let mut evidence = convincing();
    change(&mut evidence);
    evidence.doubt((policy, 0.002), 2e-5, of_time)
}

#[test]
fn each_test_refuses_by_itself() {
    let policy = Policy::default();
    let says = |change: fn(&mut Evidence)| doubt(change, &policy, false);
    assert_eq!(says(|_| ()), None);
    assert_eq!(says(|e| e.p_value = 0.003), Some(Doubt::Chance));
    assert_eq!(says(|e| e.random.t = 1.9), Some(Doubt::NotPredictive));
    assert_eq!(says(|e| e.stability = 0.75), Some(Doubt::Unstable));
    assert_eq!(says(|e| e.blocks = None), None);
    let small = |e: &mut Evidence| (e.random.won, e.random.after) = (0.01, 0.999e-4);
    assert_eq!(doubt(small, &policy, false), Some(Doubt::TooSmall));
    // A tenth of the noise is enough, however small a fraction it is.
    assert_eq!(says(|e| (e.random.won, e.random.after) = (0.01, 0.97e-4)), None);
}

#[test]
fn blocks_may_lose_little_but_what_follows_the_time_has_to_gain_in_them() {
    let policy = Policy::default();
    let blocks =
        |won: f64, t: f64| move |e: &mut Evidence| e.blocks = Some(Gain { won, middle: won, t, ..e.random });
    assert_eq!(doubt(blocks(-0.01, -1.0), &policy, false), None);
    assert_eq!(doubt(blocks(-0.03, -1.0), &policy, false), Some(Doubt::NotPredictive));
    assert_eq!(doubt(blocks(0.3, 1.5), &policy, true), None);
    assert_eq!(doubt(blocks(0.2, 1.5), &policy, true), Some(Doubt::NotPredictive));
    assert_eq!(doubt(blocks(0.3, 0.5), &policy, true), Some(Doubt::NotPredictive));
}

#[test]
fn the_policy_decides() {
    let strict = Policy::default().scaled("stability", 1.2).unwrap();
    assert_eq!(doubt(|e| e.stability = 0.9, &Policy::default(), false), None);
    assert_eq!(doubt(|e| e.stability = 0.9, &strict, false), Some(Doubt::Unstable));
}
