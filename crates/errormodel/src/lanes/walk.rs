//! Frame after frame from the base to the tool, as [`crate::RealPosture`] does it for one row.

use super::errors::{FrameErrors, LaneErrors};
use super::store::Store;
use super::width::LANES;
use crate::{error_matrix, rotation_axes};
use truepose_kinematics::lanes::{Lane, LanePose, sin_cos_of};
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, three};

impl Store {
    /// Sines and cosines of the joints (movable × `LANES`).
    pub fn turn(&mut self, chain: &Chain, joints: &[f64]) {
        self.arch.dispatch(Turn { store: self, chain, joints });
    }

    /// Frames with these errors, of the first lanes.
    pub fn walk(&mut self, chain: &Chain, joints: &[f64], errors: &LaneErrors, lanes: usize) {
        self.parted.clear();
        self.arch.dispatch(Walk { store: self, chain, joints, errors, lanes });
    }
}

struct Turn<'a> {
    store: &'a mut Store,
    chain: &'a Chain,
    joints: &'a [f64],
}

impl WithSimd for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Turn { store, chain, joints } = self;
        for joint in 0..chain.joints().len() {
            let at = store.turn_of(joint, 0) * LANES;
            let (sines, cosines) = store.numbers[at..at + 2 * LANES].split_at_mut(LANES);
            match chain.coordinate(JointId(joint + 1)) {
                Some(k) => sin_cos_of(&joints[k * LANES..][..LANES], sines, cosines),
                None => (sines.fill(0.0), cosines.fill(1.0)).1,
            }
        }
    }
}

struct Walk<'a> {
    store: &'a mut Store,
    chain: &'a Chain,
    joints: &'a [f64],
    errors: &'a LaneErrors,
    lanes: usize,
}

/// The rotation of lanes and the axes that turn it: [`error_matrix`] and [`rotation_axes`].
type Turned<S> = ([[Lane<S>; 3]; 3], [[Lane<S>; 3]; 3]);

#[inline(always)]
fn turned<S: Simd>(simd: S, [sx, cx, sy, cy, sz, cz]: [Lane<S>; 6]) -> Turned<S> {
    let (zero, one) = (Lane::splat(simd, 0.0), Lane::splat(simd, 1.0));
    let rotation = [
        [cy * cz, sz, -(sy * cz)],
        [sy * sx - cy * sz * cx, cz * cx, cy * sx + sy * sz * cx],
        [sy * cx + cy * sz * sx, -(cz * sx), cy * cx - sy * sz * sx],
    ];
    (rotation, [[cy * cz, sz, -(sy * cz)], [zero, one, zero], [sy, zero, cy]])
}

impl WithSimd for Walk<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Walk { store, chain, joints, errors, lanes } = self;
        let frames = store.frames;
        let of_frames: Vec<FrameErrors> = (0..frames).map(|frame| errors.of(FrameId(frame))).collect();
        for (frame, of) in of_frames.iter().enumerate() {
            store.plain[frame] = *of == FrameErrors::Plain;
            if *of == FrameErrors::Varying {
                for (k, axis) in Axis::ALL.into_iter().enumerate() {
                    let row = store.angle(frame, k);
                    errors.write(FrameId(frame), axis, store.row_mut(row));
                }
                let from = store.angle(frame, 3) * LANES;
                let (angles, turns) = store.numbers[from..from + 9 * LANES].split_at_mut(3 * LANES);
                for (angle, turn) in angles.chunks_exact(LANES).zip(turns.chunks_exact_mut(2 * LANES)) {
                    let (sine, cosine) = turn.split_at_mut(LANES);
                    sin_cos_of(angle, sine, cosine);
                }
            }
        }
        let base = chain.base().pose;
        let jumps = Jumps::of(store, chain);
        let width = LANES / S::F64_LANES;
        let at = Rows::of(store);
        let joints = S::as_simd_f64s(joints).0;
        let numbers = S::as_mut_simd_f64s(&mut store.numbers).0;
        for v in 0..lanes.div_ceil(S::F64_LANES) {
            let mut pose = LanePose::splat(simd, &base);
            for frame in 0..frames {
                if let Some(step) = frame.checked_sub(1) {
                    if let Some((axes, place)) = jumps.of_frame(frame) {
                        pose = LanePose {
                            rotation: three!(k => three!(c => Lane::read(simd, numbers, axes + 3 * k + c, width, v))),
                            translation: three!(c => Lane::read(simd, numbers, place + c, width, v)),
                        };
                    }
                    if step < chain.joints().len() {
                        let q = match chain.coordinate(JointId(frame)) {
                            Some(k) => Lane::of(simd, joints[k * width + v]),
                            None => Lane::splat(simd, 0.0),
                        };
                        let s = Lane::read(simd, numbers, at.turn + 2 * step, width, v);
                        let c = Lane::read(simd, numbers, at.turn + 2 * step + 1, width, v);
                        pose = pose.past(simd, chain, step, q, s, c);
                    } else {
                        let tool = &chain.tools()[step - chain.joints().len()].placed.pose;
                        pose = pose.moved(&tool.translation).turned(&tool.rotation);
                    }
                }
                put(numbers, &pose.rotation, at.before + 9 * frame, width, v);
                match of_frames[frame] {
                    FrameErrors::Plain => {}
                    FrameErrors::Same(e) => {
                        let exact = error_matrix(&e);
                        let axes = pose.turned(&rotation_axes(&e)).rotation;
                        put(numbers, &axes, at.axes + 9 * frame, width, v);
                        pose = pose.moved(&exact.translation).turned(&exact.rotation);
                        put(numbers, &pose.rotation, at.behind + 9 * frame, width, v);
                    }
                    FrameErrors::Varying => {
                        let first = at.angle + 12 * frame;
                        let e = three!(k => Lane::read(simd, numbers, first + k, width, v));
                        let x = three!(k => Lane::read(simd, numbers, first + 6 + k, width, v));
                        let y = three!(k => Lane::read(simd, numbers, first + 9 + k, width, v));
                        let (rotation, axes) = turned(simd, [x[0], x[1], x[2], y[0], y[1], y[2]]);
                        put(numbers, &pose.turned_lanes(&axes).rotation, at.axes + 9 * frame, width, v);
                        pose = pose.moved_lanes([e[0], e[1], e[2]]).turned_lanes(&rotation);
                        put(numbers, &pose.rotation, at.behind + 9 * frame, width, v);
                    }
                }
                for (c, p) in pose.translation.iter().enumerate() {
                    numbers[(at.place + 3 * frame + c) * width + v] = p.value();
                }
            }
        }
    }
}

/// Where a frame does not stand on the one numbered before it: rows of the axes and the origin of the one on which it does.
struct Jumps(Vec<Option<(usize, usize)>>);

impl Jumps {
    fn of(store: &Store, chain: &Chain) -> Self {
        if !store.branches() {
            return Jumps(Vec::new());
        }
        let rows = |frame: usize| {
            let before = chain.parent(FrameId(frame))?.0;
            (before + 1 != frame).then(|| (store.behind(before), store.place(before)))
        };
        Jumps((0..store.frames).map(rows).collect())
    }

    #[inline(always)]
    fn of_frame(&self, frame: usize) -> Option<(usize, usize)> {
        self.0.get(frame).copied().flatten()
    }
}

/// First rows of what is written.
struct Rows {
    before: usize,
    axes: usize,
    behind: usize,
    place: usize,
    turn: usize,
    angle: usize,
}

impl Rows {
    fn of(store: &Store) -> Self {
        Rows {
            before: 0,
            axes: 9 * store.frames,
            behind: 18 * store.frames,
            place: store.place(0),
            turn: store.turn_of(0, 0),
            angle: store.angle(0, 0),
        }
    }
}

#[inline(always)]
fn put<S: Simd>(numbers: &mut [S::f64s], columns: &[[Lane<S>; 3]; 3], first: usize, width: usize, v: usize) {
    for (k, column) in columns.iter().enumerate() {
        for (c, r) in column.iter().enumerate() {
            numbers[(first + 3 * k + c) * width + v] = r.value();
        }
    }
}
