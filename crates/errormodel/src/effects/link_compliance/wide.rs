//! Links of a block of rows, in the axes of their own frames, in which a link's ends stand still: [`super::beam`] number by number.
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | x̂, L, tip | of [`truepose_kinematics::Chain::link`] | 1, m, m | behind the joint |
//! | F, M | the wrench at the tip, about it | N, N·m | behind the joint |
//! | I_0, I_1 | `slope`, `sag` | N·m², N·m³ | behind the joint |
//!
//! A mass in front of the tip, on the beam or behind the root is one formula here: u, u² and u³ are means over the part of the beam that has it,
//! and what lies beyond the tip hangs on an arm of its own.

use super::section::{OwnWeight, Section, TUBE};
use crate::lanes::{LANES, LanePosture};
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{JointId, three};

type Vector<S> = [Lane<S>; 3];

/// What the link behind a joint says: for each of its columns six rows of `LANES` numbers, shift and turn of its frame.
pub(super) struct Bending<'a> {
    pub section: Section,
    pub own_weight: OwnWeight,
    pub at: &'a LanePosture<'a>,
    pub joint: JointId,
    pub out: &'a mut [f64],
}

/// The moments that bend and twist a beam, summed over its length.
#[derive(Clone, Copy)]
struct Sums<S: Simd> {
    slope: Vector<S>,
    sag: Vector<S>,
}

/// A beam in the axes of its frame.
struct Straight<S: Simd> {
    along: Vector<S>,
    length: f64,
}

#[inline(always)]
fn cross<S: Simd>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot<S: Simd>(a: Vector<S>, b: Vector<S>) -> Lane<S> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

#[inline(always)]
fn plus<S: Simd>(a: Vector<S>, by: Lane<S>, b: Vector<S>) -> Vector<S> {
    three!(k => b[k].mul_add(by, a[k]))
}

#[inline(always)]
fn minus<S: Simd>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    three!(k => a[k] - b[k])
}

/// Into the axes that these columns are.
#[inline(always)]
fn seen_from<S: Simd>(axes: [Vector<S>; 3], v: Vector<S>) -> Vector<S> {
    three!(k => dot(axes[k], v))
}

/// Out of them.
#[inline(always)]
fn turned<S: Simd>(axes: [Vector<S>; 3], v: Vector<S>) -> Vector<S> {
    three!(i => axes[2][i].mul_add(v[2], axes[1][i].mul_add(v[1], axes[0][i] * v[0])))
}

#[inline(always)]
fn same<S: Simd>(simd: S, v: &Vector3<f64>) -> Vector<S> {
    three!(k => Lane::splat(simd, v[k]))
}

impl<S: Simd> Straight<S> {
    /// Adds a wrench at the tip, about the tip.
    #[inline(always)]
    fn with_tip(&self, sums: Sums<S>, force: Vector<S>, moment: Vector<S>) -> Sums<S> {
        let (l, bent) = (self.length, cross(self.along, force));
        Sums {
            slope: three!(k => sums.slope[k] + moment[k].times(l) + bent[k].times(l * l / 2.0)),
            sag: three!(k => sums.sag[k] + moment[k].times(l * l / 2.0) + bent[k].times(l * l * l / 3.0)),
        }
    }

    /// Adds this weight, whose centre lies there from the root.
    #[inline(always)]
    fn with_mass(&self, simd: S, sums: Sums<S>, weight: Vector<S>, centre: Vector<S>) -> Sums<S> {
        let (zero, l) = (Lane::splat(simd, 0.0), Lane::splat(simd, self.length));
        let reach = dot(self.along, centre);
        let c = least(simd, most(simd, reach, zero), l);
        let over = most(simd, reach - l, zero);
        let h = least(simd, c, l - c);
        let h2 = h * h;
        let (u2, u3) = (c * c + h2.times(1.0 / 3.0), c * (c * c + h2));
        let ahead = cross(self.along, weight);
        let beside = cross(plus(centre, -reach, self.along), weight);
        let hung = over * l;
        let slope = plus(sums.slope, u2.times(0.5) + hung, ahead);
        let sag = plus(sums.sag, (l * u2).times(0.5) - u3.times(1.0 / 6.0) + (hung * l).times(0.5), ahead);
        Sums { slope: plus(slope, c, beside), sag: plus(sag, l * c - u2.times(0.5), beside) }
    }

    /// Displacement and rotation of the tip per 1/EI, bent about one axis across the beam only.
    #[inline(always)]
    fn bent_about(&self, sums: Sums<S>, axis: Vector<S>) -> (Vector<S>, Vector<S>) {
        let (sag, slope) = (dot(axis, sums.sag), dot(axis, sums.slope));
        (cross(three!(k => axis[k] * sag), self.along), three!(k => axis[k] * slope))
    }

    /// The same about every axis alike.
    #[inline(always)]
    fn bent(&self, sums: Sums<S>) -> (Vector<S>, Vector<S>) {
        let twist = dot(self.along, sums.slope);
        (cross(sums.sag, self.along), plus(sums.slope, -twist, self.along))
    }
}

#[inline(always)]
fn most<S: Simd>(simd: S, a: Lane<S>, b: Lane<S>) -> Lane<S> {
    Lane::of(simd, simd.max_f64s(a.value(), b.value()))
}

#[inline(always)]
fn least<S: Simd>(simd: S, a: Lane<S>, b: Lane<S>) -> Lane<S> {
    Lane::of(simd, simd.min_f64s(a.value(), b.value()))
}

impl WithSimd for Bending<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Bending { section, own_weight, at, joint, out } = self;
        let chain = at.chain();
        let (root, tip) = chain.link(joint);
        let way = tip - root;
        let length = way.norm();
        let zero = [Lane::splat(simd, 0.0); 3];
        let beam = Straight { along: same(simd, &(way / length)), length };
        let gravity = same(simd, &chain.gravity_in_measurement_frame());
        let next = chain.next_movable(joint);
        let home = at.frame_rows(chain.frame_after(joint));
        let end_frame = next.map_or(chain.tool_frame(), |next| chain.frame_after(next));
        let (end, carried) = (at.frame_rows(end_frame), at.carried_row(end_frame));
        let last = next.map_or(chain.joints().len(), |next| next.0 - 1);
        let width = LANES / S::F64_LANES;
        let numbers = S::as_simd_f64s(at.numbers()).0;
        let out = S::as_mut_simd_f64s(out).0;
        let general = section == Section::General;
        for v in 0..at.rows().div_ceil(S::F64_LANES) {
            let vector = |row: usize| three!(k => Lane::read(simd, numbers, row + k, width, v));
            let axes = |row: usize| [vector(row), vector(row + 3), vector(row + 6)];
            let own = axes(home.0);
            let origin = vector(home.1);
            let here = |place: Vector<S>| seen_from(own, minus(place, origin));
            let g = seen_from(own, gravity);
            let (force, moment) = (seen_from(own, vector(carried)), seen_from(own, vector(carried + 3)));
            let arm = cross(minus(here(vector(end.1)), same(simd, &tip)), force);
            let bare = Sums { slope: zero, sag: zero };
            let mut loaded = beam.with_tip(bare, force, three!(k => moment[k] + arm[k]));
            if own_weight == OwnWeight::Declared {
                for part in (joint.0..=last).map(JointId) {
                    let Some(link) = &chain.joint(part).link else { continue };
                    let frame = at.frame_rows(chain.frame_after(part));
                    let com = turned(axes(frame.0), same(simd, &link.com));
                    let place = vector(frame.1);
                    let centre = minus(here(three!(k => com[k] + place[k])), same(simd, &root));
                    loaded = beam.with_mass(simd, loaded, three!(k => g[k].times(link.mass)), centre);
                }
            }
            // Across the link, as `super::across` chooses.
            let mut across = beam.along;
            let joints = [Some(joint), next].into_iter().flatten();
            let mut axis_at = [zero; 5];
            let mut count = 0;
            for motion in joints.filter_map(|joint| chain.joint_motion(joint)) {
                let frame = at.frame_rows(motion.frame);
                axis_at[count] = seen_from(own, turned(axes(frame.0), same(simd, &motion.axis)));
                count += 1;
            }
            for k in 0..3 {
                axis_at[count] = same(simd, &Vector3::ith(k, 1.0));
                count += 1;
            }
            for &axis in axis_at[..count].iter().rev() {
                let square = plus(axis, -dot(beam.along, axis), beam.along);
                let norm = Lane::of(simd, simd.sqrt_f64s(dot(square, square).value()));
                let far = simd.greater_than_f64s(norm.value(), simd.splat_f64s(0.3));
                let over = most(simd, norm, Lane::splat(simd, 0.3));
                across = three!(k => Lane::of(simd, simd.select_f64s(
                    far,
                    simd.div_f64s(square[k].value(), over.value()),
                    across[k].value(),
                )));
            }
            let sideways = cross(beam.along, across);
            let mut column = 0;
            let mut put = |sag: Vector<S>, turn: Vector<S>| {
                let lever = cross(turn, same(simd, &tip));
                for k in 0..3 {
                    out[(6 * column + k) * width + v] = (sag[k] - lever[k]).value();
                    out[(6 * column + 3 + k) * width + v] = turn[k].value();
                }
                column += 1;
            };
            let twist = dot(beam.along, loaded.slope);
            let twist = three!(k => beam.along[k] * twist);
            let tied = if section == Section::Tube { TUBE } else { 0.0 };
            let tied = three!(k => twist[k].times(tied));
            if general {
                for axis in [across, sideways] {
                    let (sag, turn) = beam.bent_about(loaded, axis);
                    put(sag, turn);
                }
            } else {
                let (sag, turn) = beam.bent(loaded);
                put(sag, three!(k => turn[k] + tied[k]));
            }
            if section != Section::Tube {
                put(zero, twist);
            }
            if own_weight == OwnWeight::Free {
                let own = beam.with_mass(simd, bare, g, same(simd, &(way / 2.0)));
                let beyond = beam.with_tip(bare, g, zero);
                for sums in [own, beyond] {
                    if general {
                        for axis in [across, sideways] {
                            let (sag, turn) = beam.bent_about(sums, axis);
                            put(sag, turn);
                        }
                    } else {
                        let (sag, turn) = beam.bent(sums);
                        put(sag, turn);
                    }
                }
            }
        }
    }
}
