//! Weights and loads of a block, from the tip to the base: the statics of [`truepose_kinematics::Posture`].

use super::store::Store;
use super::width::LANES;
use crate::Dataset;
use nalgebra::Vector3;
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{Chain, JointId, JointKind, Load, ToolId, Wrench, three, weigh};

/// What the tool carries, lane by lane.
#[derive(Debug, Clone)]
pub(crate) struct LaneLoad {
    /// Mass, centre of gravity (tool), force and moment of what is measured (tool).
    numbers: Vec<f64>,
    /// Whether each lane has a measured wrench or nothing: then it is known in the tool's axes without any posture.
    pub measured: bool,
    /// The same one by one, with the tool that carries it; where robots branch.
    each: Vec<(ToolId, Load)>,
}

impl Default for LaneLoad {
    fn default() -> Self {
        LaneLoad { numbers: vec![0.0; 10 * LANES], measured: true, each: Vec::new() }
    }
}

impl LaneLoad {
    pub fn gather(&mut self, data: &Dataset, rows: &[usize], branches: bool) {
        self.numbers.fill(0.0);
        self.measured = true;
        self.each.clear();
        if branches {
            self.each.extend(rows.iter().map(|&row| (data.tool(row), data.load[row])));
        }
        for (lane, &row) in rows.iter().enumerate() {
            let mut put = |k: usize, v: f64| self.numbers[k * LANES + lane] = v;
            match data.load[row] {
                Load::None => {}
                Load::Payload(payload) => {
                    put(0, payload.mass);
                    (0..3).for_each(|k| put(1 + k, payload.com[k]));
                    self.measured = false;
                }
                Load::Wrench(wrench) => (0..6).for_each(|k| put(4 + k, wrench.component(k))),
            }
        }
    }

    /// A component of the measured wrench at the tool, in its axes.
    pub fn component(&self, k: usize) -> &[f64] {
        &self.numbers[(4 + k) * LANES..][..LANES]
    }
}

impl Store {
    /// Wrenches of all frames and loads of all joints, of the first lanes.
    pub fn weigh(&mut self, chain: &Chain, load: &LaneLoad, gravity: &Vector3<f64>, lanes: usize) {
        if self.branches() {
            self.weigh_branches(chain, load, gravity, lanes);
        }
        self.arch.dispatch(Weigh { store: self, chain, load, gravity, lanes });
    }

    /// Wrenches of all frames of a robot that branches, lane by lane.
    fn weigh_branches(&mut self, chain: &Chain, load: &LaneLoad, gravity: &Vector3<f64>, lanes: usize) {
        let mut wrenches = vec![Wrench::default(); self.frames];
        let mut frames = Vec::with_capacity(self.frames);
        for lane in 0..lanes {
            frames.clear();
            frames.extend((0..self.frames).map(|frame| self.frame(frame, lane)));
            let (tool, load) =
                load.each.get(lane).map_or((ToolId::FIRST, &Load::None), |(t, load)| (*t, load));
            weigh(chain, &frames, (tool, load), gravity, &mut wrenches);
            for (frame, carried) in wrenches.iter().enumerate() {
                let first = self.wrench(frame);
                (0..6).for_each(|k| self.numbers[(first + k) * LANES + lane] = carried.component(k));
            }
        }
    }
}

struct Weigh<'a> {
    store: &'a mut Store,
    chain: &'a Chain,
    load: &'a LaneLoad,
    gravity: &'a Vector3<f64>,
    lanes: usize,
}

type Vector<S> = [Lane<S>; 3];

#[inline(always)]
fn cross<S: Simd>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn turned<S: Simd>(columns: [Vector<S>; 3], by: Vector<S>) -> Vector<S> {
    three!(i => columns[2][i].mul_add(by[2], columns[1][i].mul_add(by[1], columns[0][i] * by[0])))
}

#[inline(always)]
fn vector<S: Simd>(simd: S, numbers: &[S::f64s], width: usize, v: usize, row: usize) -> Vector<S> {
    three!(k => Lane::read(simd, numbers, row + k, width, v))
}

#[inline(always)]
fn columns<S: Simd>(simd: S, numbers: &[S::f64s], width: usize, v: usize, row: usize) -> [Vector<S>; 3] {
    three!(k => vector(simd, numbers, width, v, row + 3 * k))
}

impl WithSimd for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Weigh { store, chain, load, gravity, lanes } = self;
        let (frames, width) = (store.frames, LANES / S::F64_LANES);
        let branches = store.branches();
        let rotation: Vec<usize> = (0..frames).map(|frame| store.behind(frame)).collect();
        let (place, wrench, felt) = (store.place(0), store.wrench(0), store.load(0));
        let numbers = S::as_mut_simd_f64s(&mut store.numbers).0;
        let carried = S::as_simd_f64s(&load.numbers).0;
        let g = three!(k => Lane::splat(simd, gravity[k]));
        for v in 0..lanes.div_ceil(S::F64_LANES) {
            let tool = columns(simd, numbers, width, v, rotation[frames - 1]);
            let mass = Lane::read(simd, carried, 0, width, v);
            let weight = three!(k => g[k] * mass);
            let at_centre = cross(turned(tool, vector(simd, carried, width, v, 1)), weight);
            let (measured, moment) = (
                turned(tool, vector(simd, carried, width, v, 4)),
                turned(tool, vector(simd, carried, width, v, 7)),
            );
            let mut force = three!(k => weight[k] + measured[k]);
            let mut moment = three!(k => at_centre[k] + moment[k]);
            let wide = if branches { 0 } else { frames };
            for frame in (0..wide).rev() {
                if frame + 1 < frames {
                    let (here, next) = (
                        vector(simd, numbers, width, v, place + 3 * frame),
                        vector(simd, numbers, width, v, place + 3 * frame + 3),
                    );
                    let lever = cross(three!(k => next[k] - here[k]), force);
                    moment = three!(k => moment[k] + lever[k]);
                    if frame > 0
                        && let Some(link) = &chain.joints()[frame - 1].link
                    {
                        let arms = columns(simd, numbers, width, v, rotation[frame]);
                        let arm = turned(arms, three!(k => Lane::splat(simd, link.com[k])));
                        let own = three!(k => g[k].times(link.mass));
                        let lever = cross(arm, own);
                        force = three!(k => force[k] + own[k]);
                        moment = three!(k => moment[k] + lever[k]);
                    }
                }
                for k in 0..3 {
                    numbers[(wrench + 6 * frame + k) * width + v] = force[k].value();
                    numbers[(wrench + 6 * frame + 3 + k) * width + v] = moment[k].value();
                }
            }
            for joint in 0..chain.joints().len() {
                let Some(motion) = chain.joint_motion(JointId(joint + 1)) else { continue };
                let at = columns(simd, numbers, width, v, rotation[motion.frame.0]);
                let axis = turned(at, three!(k => Lane::splat(simd, motion.axis[k])));
                let carried = wrench + 6 * (joint + 1);
                let force = vector(simd, numbers, width, v, carried);
                let along = match motion.kind {
                    JointKind::Prismatic => force,
                    _ => {
                        let here = vector(simd, numbers, width, v, place + 3 * motion.frame.0);
                        let there = vector(simd, numbers, width, v, place + 3 * (joint + 1));
                        let lever = cross(three!(k => there[k] - here[k]), force);
                        let moment = vector(simd, numbers, width, v, carried + 3);
                        three!(k => moment[k] + lever[k])
                    }
                };
                let felt_here = axis[2].mul_add(along[2], axis[1].mul_add(along[1], axis[0] * along[0]));
                numbers[(felt + joint) * width + v] = felt_here.value();
            }
        }
    }
}
