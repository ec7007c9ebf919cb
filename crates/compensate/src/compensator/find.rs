//! Where a search begins, and where it goes on when that leads nowhere.

use super::Compensator;
use crate::command::{MOST, Status, Values};
use crate::lanes::Block;
use crate::position_first::walk_position_first;
use crate::search::{Ending, Walk, walk};
use crate::starts::Nearest;
use crate::step::Limits;
use crate::task::Task;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::TargetId;

/// Iterations on the nominal robot from one start, and the error below which the exact model takes over.
const NOMINAL_ROUNDS: usize = 60;
const NOMINAL_TOLERANCE: f64 = 1e-5;
const WORTH_A_TRY: f64 = 1e-3;
const NUDGE: f64 = 0.15;

impl Compensator<'_> {
    /// The joints for this task; `kept` is the orientation to keep where none is requested.
    pub(super) fn find(
        &mut self,
        task: &Task,
        seed: Option<&[f64; MOST]>,
        kept: Option<&Matrix3<f64>>,
    ) -> Found {
        let most = self.options.rounds;
        let limits = self.limits;
        let mut rounds = 0;
        let mut best: Option<Walk> = None;
        if let (Some(x), Some(rotation)) = (seed, kept) {
            // Position only: with the seed's orientation if that can be, else as near to it as it goes.
            let whole = Task { rotation: Some(*rotation), ..*task };
            let found = walk(&mut self.exact(), &whole, x, &limits, most);
            if self.there(&found) {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            let ended = walk_position_first(&mut self.exact(), &whole, x, &limits, most);
            if self.there(&ended) {
                return Found::ok(ended, rounds);
            }
            rounds += ended.rounds;
        }
        let straight = seed.and_then(|x| self.straight(task, x));
        if let Some(found) = straight.filter(|found| self.fits(&found.x)) {
            return Found::ok(found, rounds);
        }
        if let Some(x) = seed {
            let found = walk(&mut self.exact(), task, x, &limits, most);
            if self.there(&found) {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            best = Some(found);
        }
        let point = self.nominal_point(task.target);
        let nearest = self.starts.nearest(task, &point, self.options.starts.max(1));
        let rough = Task {
            position_tolerance: NOMINAL_TOLERANCE * self.length,
            orientation_tolerance: NOMINAL_TOLERANCE,
            ..*task
        };
        let mut nearest_nominal: Option<Walk> = None;
        let mut stuck = 0;
        for k in 0..self.options.starts {
            let Some(start) = self.start(&nearest, k, seed).filter(|_| stuck < self.enough()) else {
                break;
            };
            let nominal = walk(&mut self.ideal(&point), &rough, &start, &limits, NOMINAL_ROUNDS);
            if nominal.gap.cost < WORTH_A_TRY {
                let found = walk(&mut self.exact(), task, &nominal.x, &limits, most);
                if self.there(&found) {
                    return Found::ok(found, rounds);
                }
                rounds += found.rounds;
                stuck += usize::from(!self.at_a_limit(&found.x));
                best = nearer(best, found);
            } else {
                nearest_nominal = nearer(nearest_nominal, nominal);
            }
        }
        if best.is_none_or(|walk| walk.gap.cost.is_nan() || walk.gap.cost >= WORTH_A_TRY)
            && let Some(nominal) = nearest_nominal
        {
            let found = walk(&mut self.exact(), task, &nominal.x, &limits, most);
            if self.there(&found) {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            best = nearer(best, found);
        }
        let Some(mut best) = best.or_else(|| {
            let start = self.start(&nearest, 0, seed)?;
            Some(walk(&mut self.exact(), task, &start, &limits, most))
        }) else {
            return Found { walk: Walk::nowhere(), status: Status::NotConverged };
        };
        if task.rotation.is_some() && self.commanded() < 6 {
            // Such a robot cannot have every orientation: the position comes first.
            let found = walk_position_first(&mut self.exact(), task, &best.x, &limits, most);
            rounds += found.rounds;
            if self.there(&found) {
                best = found;
                if task.reached(&best.gap) {
                    return Found::ok(best, rounds);
                }
            }
        }
        // Near, but bent the wrong way: the same posture with one joint nudged.
        if best.gap.cost < WORTH_A_TRY {
            let stays = self.stays;
            for k in (0..2 * self.nominal.joints()).filter(|k| !stays[k / 2]) {
                let mut x = best.x;
                x[k / 2] += if k.is_multiple_of(2) { NUDGE } else { -NUDGE };
                let x = self.within(&x);
                let found = walk(&mut self.exact(), task, &x, &limits, most);
                if self.there(&found) {
                    return Found::ok(found, rounds);
                }
                rounds += found.rounds;
            }
        }
        best.rounds = rounds;
        self.without_limits((task, &rough), &nearest, best, seed)
    }

    /// Whether joint values beyond their limits would do, where nothing within them did; `best` is the nearest that does not.
    fn without_limits(
        &mut self,
        (task, rough): (&Task, &Task),
        nearest: &Nearest,
        mut best: Walk,
        seed: Option<&[f64; MOST]>,
    ) -> Found {
        let point = self.nominal_point(task.target);
        let (limits, most) = (self.limits, self.options.rounds);
        let mut rounds = best.rounds;
        let mut stuck = 0;
        for k in 0..=self.options.starts {
            let start = if k == 0 { Some(best.x) } else { self.start(nearest, k - 1, seed) };
            let Some(start) = start.filter(|_| stuck < self.enough()) else { break };
            let nominal = walk(&mut self.ideal(&point), rough, &start, &Limits::NONE, NOMINAL_ROUNDS);
            if nominal.gap.cost.is_nan() || nominal.gap.cost > WORTH_A_TRY {
                continue;
            }
            let free = walk(&mut self.exact(), task, &nominal.x, &Limits::NONE, most);
            rounds += free.rounds;
            if free.ending != Ending::There {
                stuck += 1;
                continue;
            }
            // The same posture a turn further may lie within the limits.
            let turned = self.kept(self.within(&self.wrapped(&free.x)), seed);
            let inside = walk(&mut self.exact(), task, &turned, &limits, most);
            if self.there(&inside) {
                return Found::ok(inside, rounds);
            }
            rounds += inside.rounds;
            best.rounds = rounds;
            return Found { walk: best, status: Status::Limit };
        }
        let status = if best.ending == Ending::GaveUp { Status::NotConverged } else { Status::Unreachable };
        best.rounds = rounds;
        Found { walk: best, status }
    }

    /// The k-th start, in which joints that stay are where the seed has them.
    fn start(&self, nearest: &Nearest, k: usize, seed: Option<&[f64; MOST]>) -> Option<[f64; MOST]> {
        self.starts.start(nearest, k).map(|x| self.kept(*x, seed))
    }

    fn kept(&self, mut x: [f64; MOST], seed: Option<&[f64; MOST]>) -> [f64; MOST] {
        for (k, seed) in seed.into_iter().flatten().enumerate().filter(|(k, _)| self.stays[*k]) {
            x[k] = *seed;
        }
        x
    }

    /// The straight way from a seed, as [`Compensator::commands`] takes it for several at once.
    fn straight(&mut self, task: &Task, seed: &[f64; MOST]) -> Option<Walk> {
        let kernel = self.kernel.as_ref()?;
        let mut block = Block::empty();
        let lane = block.push(task, &self.real.still_point(task.target), &self.conditions.load, seed)?;
        kernel.walk(&mut block);
        block.found(lane)
    }

    /// After so many exact walks that began where the nominal robot is there and got stuck, the pose is at the edge of
    /// what can be reached. A robot of fewer joints than six may have to try all its postures: each tilts otherwise.
    fn enough(&self) -> usize {
        if self.commanded() < 6 { usize::MAX } else { 6 }
    }

    /// Whether a search ended at the pose, with values that the controller takes.
    fn there(&self, found: &Walk) -> bool {
        found.ending == Ending::There && self.fits(&found.x)
    }

    /// Whether the controller's values are within their limits; without couplings those of the search are all there is.
    pub(super) fn fits(&self, x: &[f64; MOST]) -> bool {
        let chain = self.fitted.chain();
        if chain.couplings().is_empty() {
            return true;
        }
        let mut joints = Values::zeros(self.nominal.joints());
        joints.iter_mut().enumerate().for_each(|(k, joint)| *joint = self.joint(k, x[k]));
        chain.within_controller_limits(&joints)
    }

    fn at_a_limit(&self, x: &[f64; MOST]) -> bool {
        (0..self.nominal.joints()).any(|k| x[k] <= self.limits.lower[k] || x[k] >= self.limits.upper[k])
    }

    fn nominal_point(&self, target: Option<TargetId>) -> Vector3<f64> {
        target.map_or(Vector3::zeros(), |t| self.fitted.chain().targets()[t.0].position)
    }
}

/// The end of a search.
pub(super) struct Found {
    pub walk: Walk,
    pub status: Status,
}

impl Found {
    fn ok(mut walk: Walk, rounds: usize) -> Self {
        walk.rounds += rounds;
        Found { walk, status: Status::Ok }
    }
}

fn nearer(best: Option<Walk>, other: Walk) -> Option<Walk> {
    Some(match best {
        Some(walk) if walk.gap.cost <= other.gap.cost => walk,
        _ => other,
    })
}
