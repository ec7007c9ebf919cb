//! The levers of all sites in a block: the error Jacobian, as [`crate::ErrorJacobian`] has it for one row.

use super::errors::LaneErrors;
use super::store::Store;
use super::width::LANES;
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{Chain, Site, three};

impl Store {
    /// The targets' real positions and the levers of the frames that are asked for.
    pub fn reach(&mut self, chain: &Chain, errors: &LaneErrors, frames: &[bool], lanes: usize) {
        self.rejoin();
        if errors.of_targets() {
            for direction in 0..3 {
                let row = self.aimed() + direction;
                for lane in 0..self.target.len() {
                    if let Some(target) = self.target[lane] {
                        let nominal = chain.targets()[target.0].position[direction];
                        self.numbers[row * LANES + lane] =
                            nominal + errors.target(chain, target, direction, lane);
                    }
                }
            }
        }
        if self.branches() {
            self.take_tools(chain);
        }
        self.arch.dispatch(Reach { store: self, frames, lanes });
        if self.branches() {
            self.part(chain);
            self.part_from_met(chain, errors, frames);
        }
    }

    /// The tool's axes where a target is measured, zero where it is not.
    pub fn carry(&mut self, target: usize) {
        let to = self.carried(target);
        for lane in 0..self.target.len() {
            let axes = self.carried_in(target, lane);
            for (k, value) in axes.iter().enumerate() {
                self.numbers[(to + k) * LANES + lane] = *value;
            }
        }
        let lanes = self.target.len();
        (0..9).for_each(|k| self.row_mut(to + k)[lanes..].fill(0.0));
    }

    /// The row of a site's component (0…2 position, 3…5 rotation); none where it is zero by its nature.
    #[inline]
    pub fn of_site(&self, site: Site, component: usize) -> Option<usize> {
        match site {
            Site::Frame(frame, axis) if axis.is_rotation() => Some(match component {
                0..3 => self.lever(frame.0) + 3 * axis.direction() + component,
                _ => self.axes(frame.0) + 3 * axis.direction() + component - 3,
            }),
            Site::Frame(frame, axis) if component < 3 => {
                Some(self.before(frame.0) + 3 * axis.direction() + component)
            }
            Site::Target(target, axis) if component < 3 => {
                Some(self.carried(target.0) + 3 * axis.direction() + component)
            }
            _ => None,
        }
    }
}

struct Reach<'a> {
    store: &'a mut Store,
    frames: &'a [bool],
    lanes: usize,
}

impl WithSimd for Reach<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Reach { store, frames, lanes } = self;
        let width = LANES / S::F64_LANES;
        let vectors = lanes.div_ceil(S::F64_LANES);
        let (count, (tool, origin)) = (store.frames, store.tool());
        let (aimed, point) = (store.aimed(), store.point());
        let (place, lever) = (store.place(0), store.lever(0));
        let axes: Vec<usize> = (0..count).map(|frame| store.axes(frame)).collect();
        let numbers = S::as_mut_simd_f64s(&mut store.numbers).0;
        for v in 0..vectors {
            let mut p = three!(c => Lane::read(simd, numbers, origin + c, width, v));
            for k in 0..3 {
                let by = Lane::read(simd, numbers, aimed + k, width, v);
                p = three!(c => Lane::read(simd, numbers, tool + 3 * k + c, width, v).mul_add(by, p[c]));
            }
            for (c, p) in p.iter().enumerate() {
                numbers[(point + c) * width + v] = p.value();
            }
        }
        for (frame, _) in frames.iter().enumerate().filter(|(_, wanted)| **wanted) {
            for v in 0..vectors {
                let d = three!(c => Lane::read(simd, numbers, point + c, width, v) - Lane::read(simd, numbers, place + 3 * frame + c, width, v));
                for k in 0..3 {
                    let a = three!(c => Lane::read(simd, numbers, axes[frame] + 3 * k + c, width, v));
                    let made =
                        [a[1] * d[2] - a[2] * d[1], a[2] * d[0] - a[0] * d[2], a[0] * d[1] - a[1] * d[0]];
                    for (c, made) in made.iter().enumerate() {
                        numbers[(lever + 9 * frame + 3 * k + c) * width + v] = made.value();
                    }
                }
            }
        }
    }
}
