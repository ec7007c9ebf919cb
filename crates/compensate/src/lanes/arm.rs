//! The arm's factors multiplied out for several commands at once, and what depends on them.
//!
//! ```text
//! S_j = Σ_{k ≥ j} m_k c_k,   m_j = Σ_{k ≥ j} m_k            links and payload beyond joint j
//! τ_j = z_j · ((S_j − m_j o_j) × g)   for a turn,   z_j · m_j g   for a slide
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | c_k | [`Place::points`] of masses | m | measurement: centre of link k |
//! | z_j, o_j | `directions`, `points` of compliances | 1, m | measurement: where `Posture::joint_load` takes the load |

use super::vector::{Space, Wide};
use super::{Hung, Kernel, LINKS};
use crate::arm::{Arm, Factor};
use pulp::Simd;

/// The joints of an arm whose commands are computed side by side.
pub(super) const JOINTS: usize = 6;

/// Where the arms are.
pub(super) struct Place<S: Simd> {
    /// Columns of the tool's rotation.
    pub turned: [Space<S>; 3],
    /// The tool's origin.
    pub at: Space<S>,
    /// The joints' real axes, and points on them.
    pub axes: [Space<S>; JOINTS],
    pub origins: [Space<S>; JOINTS],
    /// Of the marks.
    pub points: [Space<S>; 2 * LINKS],
    pub directions: [Space<S>; 2 * LINKS],
}

impl<S: Simd> Place<S> {
    #[inline(always)]
    pub fn nowhere(simd: S) -> Self {
        let zero = Space::all(simd, [0.0; 3]);
        Place {
            turned: [zero; 3],
            at: zero,
            axes: [zero; JOINTS],
            origins: [zero; JOINTS],
            points: [zero; 2 * LINKS],
            directions: [zero; 2 * LINKS],
        }
    }

    /// Moves there, as [`Arm::reach`]; marks are not computed where they are not needed.
    #[inline(always)]
    pub fn reach(
        &mut self,
        simd: S,
        arm: &Arm,
        q: &[Wide<S>; JOINTS],
        turns: &[(Wide<S>, Wide<S>); JOINTS],
        errors: &[Wide<S>],
        marked: bool,
    ) {
        let mut x = Space::all(simd, [1.0, 0.0, 0.0]);
        let mut y = Space::all(simd, [0.0, 1.0, 0.0]);
        let mut z = Space::all(simd, [0.0, 0.0, 1.0]);
        let mut at = Space::all(simd, [0.0; 3]);
        let mut k = 0;
        for factor in arm.factors() {
            let all = |value| Wide::all(simd, value);
            // A vector in these axes, and what is added to it; components that are zero cost nothing.
            macro_rules! through {
                ($v:expr, $plus:expr) => {{
                    let mut sum = $plus;
                    for (axis, component) in [(&x, $v[0]), (&y, $v[1]), (&z, $v[2])] {
                        if component != 0.0 {
                            sum = axis.times_plus(all(component), sum);
                        }
                    }
                    sum
                }};
            }
            macro_rules! turned {
                ($v:expr) => {
                    x.times_plus(all($v[0]), y.times_plus(all($v[1]), z.times(all($v[2]))))
                };
            }
            match factor {
                Factor::Constant(pose) => {
                    let [a, b, c]: [[f64; 3]; 3] = pose.rotation.data.0;
                    at = through!(pose.translation, at);
                    (x, y, z) = (turned!(a), turned!(b), turned!(c));
                }
                Factor::Shift(by) => at = through!(by, at),
                Factor::Spin(direction, s, c) => {
                    spin(*direction, all(*s), all(*c), &mut x, &mut y, &mut z);
                }
                Factor::Shifted(from) => {
                    let e = [errors[*from], errors[*from + 1], errors[*from + 2]];
                    at = x.times_plus(e[0], y.times_plus(e[1], z.times_plus(e[2], at)));
                }
                Factor::Turned(site, direction) => {
                    let (s, c) = errors[*site].sin_cos_small();
                    spin(*direction, s, c, &mut x, &mut y, &mut z);
                }
                Factor::Turn => {
                    let (s, c) = turns[k];
                    self.axes[k] = z;
                    self.origins[k] = at;
                    spin(2, s, c, &mut x, &mut y, &mut z);
                    k += 1;
                }
                Factor::Slide => {
                    self.axes[k] = z;
                    self.origins[k] = at;
                    at = z.times_plus(q[k], at);
                    k += 1;
                }
                Factor::Mark(mark) if marked => {
                    self.points[mark.what] = through!(mark.point, at);
                    self.directions[mark.what] = through!(mark.direction, Space::all(simd, [0.0; 3]));
                }
                Factor::Skip => {
                    self.axes[k] = Space::all(simd, [0.0; 3]);
                    k += 1;
                }
                Factor::Mark(_) => {}
            }
        }
        self.turned = [x, y, z];
        self.at = at;
    }

    /// A point of the tool.
    #[inline(always)]
    pub fn point(&self, of: Space<S>) -> Space<S> {
        let [x, y, z] = self.turned;
        x.times_plus(of.x, y.times_plus(of.y, z.times_plus(of.z, self.at)))
    }

    /// Deflection of every compliance under its load, added to the errors, which are the constant ones before, and to how far its
    /// joint has moved by that (rad or m, each joint that moves).
    #[inline(always)]
    pub fn yields(
        &self,
        simd: S,
        kernel: &Kernel,
        gravity: [f64; 3],
        payload: (Wide<S>, Space<S>),
        errors: &mut [Wide<S>],
        moved: &mut [Wide<S>; JOINTS],
    ) {
        let (mass, first) = payload;
        // First moment and mass of all that hangs beyond.
        let mut beyond = mass;
        let [x, y, z] = self.turned;
        let mut moment =
            x.times_plus(first.x, y.times_plus(first.y, z.times_plus(first.z, self.at.times(mass))));
        let g = Space::all(simd, gravity);
        for one in &kernel.hung {
            match *one {
                Hung::Link { mark, mass } => {
                    let mass = Wide::all(simd, mass);
                    moment = self.points[mark].times_plus(mass, moment);
                    beyond = beyond + mass;
                }
                Hung::Spring { mark, spring } => {
                    let (o, axis) = (self.points[mark], self.directions[mark]);
                    let spring = &kernel.springs[spring];
                    let load = if spring.slides {
                        axis.dot(g) * beyond
                    } else {
                        axis.dot(o.times_from(beyond, moment).cross(g))
                    };
                    let yields = load.scaled(spring.compliance);
                    moved[spring.coordinate] = moved[spring.coordinate] + yields;
                    for &(site, share) in spring.sites() {
                        errors[site] = yields.times_plus(Wide::all(simd, share), errors[site]);
                    }
                }
            }
        }
    }
}

/// Turns the columns of a rotation about one of them.
#[inline(always)]
fn spin<S: Simd>(
    direction: usize,
    s: Wide<S>,
    c: Wide<S>,
    x: &mut Space<S>,
    y: &mut Space<S>,
    z: &mut Space<S>,
) {
    let (a, b) = match direction {
        0 => (y, z),
        1 => (z, x),
        _ => (x, y),
    };
    (*a, *b) = (b.times_plus(s, a.times(c)), a.times_from(s, b.times(c)));
}
