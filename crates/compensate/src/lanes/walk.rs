//! Newton's walk of several commands at once: the straight way, which nearly all of them take.
//!
//! ```text
//! rounds 1, 2   the robot as deflected in the iteration before (1: not at all), its deflections δ       x ← x + J⁻¹ e − (δ − δ_before)
//! from 3        the exact model: weights follow deflections as often as specified               there? x ← x + J⁻¹ e, J of round 2
//! ```
//!
//! A deflection δ equals a command that is larger by δ, up to second order. The first iterations only have to come near; accuracy requires
//! that the last one is verified with the exact model. Without compliance every iteration is exact. A lane leaves when it began too far away,
//! a step is long or would leave the limits, or an iteration does not reduce the error by a factor of four: its command is then solved singly.
//!
//! Loops are written out: what a closure or an adapter of the standard library calls is not compiled for the processor's vectors.

// Indices name joints.
#![allow(clippy::needless_range_loop)]

use super::arm::{JOINTS, Place};
use super::newton::Factors;
use super::sines::SMALL;
use super::vector::{Lanes, Space, Wide};
use super::{Block, Kernel, SITES, WIDTH};
use crate::search::NEAR;
use crate::step::LARGEST;
use pulp::{Simd, WithSimd};

/// Iterations after which a lane leaves.
const ROUNDS: usize = 8;
/// Iterations on an approximate model, where there is compliance.
const ROUGH: usize = 2;
/// How often the exact model weighs: the nominal posture, and where that leads, as often as `Rest` does.
const EXACT: usize = 3;

/// All commands of a block.
pub(super) struct Walks<'a> {
    pub kernel: &'a Kernel,
    pub block: &'a mut Block,
}

impl WithSimd for Walks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lanes = S::F64_LANES;
        if lanes > WIDTH {
            return;
        }
        let mut from = 0;
        while from < self.block.count {
            simd.vectorize(Group { kernel: self.kernel, block: self.block, from });
            from += lanes;
        }
    }
}

/// As many of them as there are lanes.
struct Group<'a> {
    kernel: &'a Kernel,
    block: &'a mut Block,
    from: usize,
}

impl WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Group { kernel, block, from } = self;
        let range = from..from + S::F64_LANES;
        let all = |value: f64| Wide::all(simd, value);
        macro_rules! load {
            ($values:expr) => {
                Wide::of(simd, &$values[range.clone()])
            };
        }
        macro_rules! space {
            ($v:expr) => {
                Space { x: load!($v[0]), y: load!($v[1]), z: load!($v[2]) }
            };
        }
        let wanted = space!(block.position);
        let turned = [space!(block.rotation[0]), space!(block.rotation[1]), space!(block.rotation[2])];
        let (point, payload) = (space!(block.point), (load!(block.mass), space!(block.first)));
        let per_length = all(1.0 / kernel.length);
        let tolerance = kernel.position_tolerance / kernel.length;
        let (near, turn_near) =
            (all(tolerance * tolerance), all(kernel.orientation_tolerance * kernel.orientation_tolerance));

        let mut x = [all(0.0); JOINTS];
        for k in 0..JOINTS {
            x[k] = load!(block.x[k]);
        }
        let mut place = Place::nowhere(simd);
        let mut errors = [all(0.0); SITES];
        let errors = &mut errors[..kernel.constant.len()];
        for (error, &constant) in errors.iter_mut().zip(&kernel.constant) {
            *error = all(constant);
        }
        let mut factors: Option<Factors<S>> = None;
        let (mut last, mut before) = (all(0.0), [all(0.0); JOINTS]);
        let (mut there, mut left) = (Lanes::none(simd), Lanes::none(simd));
        let (mut error, mut rounds) = ([all(0.0); 6], all(0.0));

        for round in 1..=ROUNDS {
            let rough = round <= ROUGH && !kernel.springs.is_empty();
            let mut q = x;
            let mut turns = [(all(0.0), all(0.0)); JOINTS];
            let mut sound = Lanes::all(simd);
            for k in 0..JOINTS {
                q[k] = x[k].scaled(kernel.scale[k]);
                let (s, c, within) = q[k].sin_cos();
                turns[k] = (s, c);
                sound = sound.and(within);
            }
            let passes = if rough || kernel.springs.is_empty() { 0 } else { EXACT };
            let mut moved = [all(0.0); JOINTS];
            for pass in 0..=passes {
                let begins = pass == 0 && passes > 0;
                let arm = if begins { &kernel.nominal } else { &kernel.bent };
                let weighs = rough || pass < passes;
                place.reach(simd, arm, &q, &turns, errors, weighs);
                if weighs {
                    let gravity = if begins { kernel.gravity[0] } else { kernel.gravity[1] };
                    for &site in &kernel.moving {
                        errors[site] = all(kernel.constant[site]);
                    }
                    moved = [all(0.0); JOINTS];
                    place.yields(simd, kernel, gravity, payload, errors, &mut moved);
                    for &site in &kernel.moving {
                        let small = errors[site].abs().below(all(SMALL));
                        sound = if site % 6 >= 3 { sound.and(small) } else { sound };
                    }
                }
            }

            // The gap, as `task` has it.
            let at = place.point(point);
            let away = wanted.minus(at).times(per_length);
            let mut turn = place.turned[0].cross(turned[0]);
            turn = turn.plus(place.turned[1].cross(turned[1]));
            turn = turn.plus(place.turned[2].cross(turned[2])).times(all(0.5));
            let trace = place.turned[0].dot(turned[0])
                + place.turned[1].dot(turned[1])
                + place.turned[2].dot(turned[2]);
            let sine = turn.dot(turn);
            let turn = turn.times(sine.times_plus(sine.times_plus(all(0.075), all(1.0 / 6.0)), all(1.0)));
            sound = sound.and(all(1.0).below(trace));
            let (far, tilt) = (away.dot(away), turn.dot(turn));
            let cost = far + tilt;
            let now = [away.x, away.y, away.z, turn.x, turn.y, turn.z];

            let walks = there.or(left).not();
            if !rough {
                let arrived = walks.and(sound).and(far.at_most(near)).and(tilt.at_most(turn_near));
                there = there.or(arrived);
                for k in 0..6 {
                    error[k] = arrived.pick(now[k], error[k]);
                }
                rounds = arrived.pick(all(round as f64), rounds);
            }

            let bound = if round == 1 { all(NEAR) } else { last.scaled(0.25) };
            let goes_on = sound.and(cost.below(bound));
            left = left.or(goes_on.or(there).not());
            if there.or(left).everywhere() || round == ROUNDS {
                break;
            }
            last = cost;

            if round <= 2 {
                let mut columns = [[all(0.0); 6]; JOINTS];
                for (k, column) in columns.iter_mut().enumerate() {
                    let z = place.axes[k];
                    *column = if kernel.nominal.slides(k) {
                        [z.x, z.y, z.z, all(0.0), all(0.0), all(0.0)]
                    } else {
                        let lever = z.cross(at.minus(place.origins[k])).times(per_length);
                        [lever.x, lever.y, lever.z, z.x, z.y, z.z]
                    };
                }
                factors = Some(Factors::of(simd, columns));
            }
            let Some(factors) = &factors else { break };
            let step = factors.solve(now);
            let walks = there.or(left).not();
            let mut within = Lanes::all(simd);
            for k in 0..JOINTS {
                // What it yields more than before is not to be sent.
                let step = if rough {
                    let more = (moved[k] - before[k]).scaled(1.0 / kernel.scale[k]);
                    step[k] - more
                } else {
                    step[k]
                };
                let next = x[k] + step;
                within = within.and(step.abs().at_most(all(LARGEST)));
                within = within.and(all(kernel.limits.lower[k]).at_most(next));
                within = within.and(next.at_most(all(kernel.limits.upper[k])));
                x[k] = walks.pick(next, x[k]);
            }
            left = left.or(walks.and(within.not()));
            before = moved;
        }

        for k in 0..JOINTS {
            x[k].store(&mut block.x[k][range.clone()]);
        }
        for k in 0..6 {
            error[k].store(&mut block.error[k][range.clone()]);
        }
        // Zero where the lane left.
        rounds.store(&mut block.rounds[range.clone()]);
    }
}
