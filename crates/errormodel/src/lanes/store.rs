//! Where the numbers of a block stand: one array of rows, `LANES` numbers each.
//!
//! | row | what | frame |
//! | --- | --- | --- |
//! | `before(i, k, c)` | component c of column k of the rotation in front of `E_i` | measurement |
//! | `axes(i, k, c)` | of the axis about which rx, ry, rz of `E_i` turn | measurement |
//! | `behind(i, k, c)` | of column k of the rotation behind `E_i` | measurement |
//! | `place(i, c)` | of the origin behind `E_i`, m | measurement |
//! | `point(c)` | of the target, m | measurement |
//! | `lever(i, k, c)` | of ω_ik × (p − o_i), m per rad | measurement |
//! | `carried(t, k, c)` | of column k of the tool's rotation, where target t is measured; of what `contact` makes of it | measurement |
//! | `wrench(i, c)`, `load(j)` | what frame i carries, what joint j feels | measurement; the joint's axis |

use super::standing::Standing;
use super::width::LANES;
use crate::Dataset;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Axis, Chain, FrameId, Pose, Site, TargetId, ToolId, Wrench};

/// The rows, and which of them stand for others.
#[derive(Debug, Clone)]
pub(crate) struct Store {
    pub numbers: Vec<f64>,
    /// Whether the errors of a frame are none: then its axes and what is behind them are what is before them.
    pub plain: Vec<bool>,
    pub frames: usize,
    targets: usize,
    /// The target of each lane.
    pub target: Vec<Option<TargetId>>,
    /// Whether the robot branches, and the tool of each lane then.
    branches: bool,
    tool: Vec<ToolId>,
    /// Where some row of the block is of two points that met: of each lane the tool and the target of the other one.
    pub(super) met: Vec<Option<(FrameId, Option<TargetId>)>>,
    /// Of lanes in which points met, what stood in `before` of each frame, lane after lane; empty where it stands there.
    pub(super) parted: Vec<f64>,
    /// The processor's registers.
    pub arch: Arch,
}

impl Store {
    pub fn new(chain: &Chain) -> Self {
        let (frames, targets) = (chain.frames().len(), chain.targets().len());
        let mut store = Store {
            numbers: Vec::new(),
            plain: vec![true; frames],
            frames,
            targets,
            target: Vec::with_capacity(LANES),
            branches: !chain.is_serial(),
            tool: Vec::new(),
            met: Vec::new(),
            parted: Vec::new(),
            arch: Arch::new(),
        };
        store.numbers = vec![0.0; (store.hand() + 21) * LANES];
        store
    }

    #[inline(always)]
    pub fn before(&self, frame: usize) -> usize {
        9 * frame
    }

    #[inline(always)]
    pub fn axes(&self, frame: usize) -> usize {
        if self.plain[frame] { self.before(frame) } else { 9 * (self.frames + frame) }
    }

    #[inline(always)]
    pub fn behind(&self, frame: usize) -> usize {
        if self.plain[frame] { self.before(frame) } else { 9 * (2 * self.frames + frame) }
    }

    #[inline(always)]
    pub fn place(&self, frame: usize) -> usize {
        27 * self.frames + 3 * frame
    }

    #[inline(always)]
    pub fn lever(&self, frame: usize) -> usize {
        30 * self.frames + 9 * frame
    }

    #[inline(always)]
    pub fn point(&self) -> usize {
        39 * self.frames
    }

    /// The target in the tool's axes, m.
    #[inline(always)]
    pub fn aimed(&self) -> usize {
        39 * self.frames + 3
    }

    #[inline(always)]
    pub fn carried(&self, target: usize) -> usize {
        39 * self.frames + 6 + 9 * target
    }

    #[inline(always)]
    pub fn wrench(&self, frame: usize) -> usize {
        self.carried(self.targets) + 6 * frame
    }

    /// Of a joint, fixed ones included: 0….
    #[inline(always)]
    pub fn load(&self, joint: usize) -> usize {
        self.wrench(self.frames) + joint
    }

    /// Sine (0) and cosine (1) of a joint's value.
    #[inline(always)]
    pub fn turn_of(&self, joint: usize, which: usize) -> usize {
        self.load(self.frames) + 2 * joint + which
    }

    /// Errors (0…5) and sines and cosines (6…11) of a frame's angles.
    #[inline(always)]
    pub fn angle(&self, frame: usize, which: usize) -> usize {
        self.turn_of(self.frames, 0) + 12 * frame + which
    }

    /// Where robots branch: axes (nine) and origin (three) of each lane's own tool.
    #[inline(always)]
    fn hand(&self) -> usize {
        self.angle(self.frames, 0)
    }

    /// Axes (nine) of the tool that carries the point that was met.
    pub(super) fn met_axes(&self) -> usize {
        self.hand() + 12
    }

    /// The tool of a lane.
    pub(super) fn own_tool(&self, lane: usize) -> ToolId {
        self.tool.get(lane).copied().unwrap_or_default()
    }

    /// Rows of the axes of the tool that is looked at, and of its origin.
    #[inline(always)]
    pub fn tool(&self) -> (usize, usize) {
        match self.branches {
            true => (self.hand(), self.hand() + 9),
            false => (self.behind(self.frames - 1), self.place(self.frames - 1)),
        }
    }

    /// Takes each lane's tool to where [`Store::tool`] says.
    pub fn take_tools(&mut self, chain: &Chain) {
        let hand = self.hand();
        for lane in 0..LANES {
            let frame = chain.frame_of_tool(self.own_tool(lane)).0;
            let (axes, place) = (self.behind(frame), self.place(frame));
            for k in 0..12 {
                let from = if k < 9 { axes + k } else { place + k - 9 };
                self.numbers[(hand + k) * LANES + lane] = self.numbers[from * LANES + lane];
            }
        }
    }

    /// Looks at the robot's first tool in all lanes, where it branches.
    pub fn take_first_tool(&mut self) {
        if self.branches {
            self.tool = vec![ToolId::FIRST; LANES];
        }
    }

    /// Axes and levers of the first frames behind the base are nothing in the lanes from this one on.
    pub fn forget(&mut self, frames: usize, lanes: usize) {
        for row in (9..9 * (frames + 1)).chain(self.lever(1)..self.lever(frames + 1)) {
            self.row_mut(row)[lanes..].fill(0.0);
        }
    }

    /// Takes from each lane the levers of frames that do not carry its tool. Nothing but levers may be asked for after that.
    pub fn part(&mut self, chain: &Chain) {
        let met = |lane: &usize| self.met.get(*lane).is_some_and(Option::is_some);
        for (lane, tool) in self.tool.iter().enumerate().filter(|(lane, _)| !met(lane)) {
            for frame in (0..self.frames).filter(|frame| !chain.carries(FrameId(*frame), *tool)) {
                for first in [self.before(frame), self.axes(frame), self.lever(frame)] {
                    (0..9).for_each(|k| self.numbers[(first + k) * LANES + lane] = 0.0);
                }
            }
        }
    }

    /// Whether the robot branches.
    pub fn branches(&self) -> bool {
        self.branches
    }

    /// As [`Chain::site_at`].
    #[inline(always)]
    pub fn site(&self, index: usize) -> Site {
        match index.checked_sub(6 * self.frames) {
            None => Site::Frame(FrameId(index / 6), Axis::ALL[index % 6]),
            Some(rest) => Site::Target(TargetId(rest / 3), Axis::ALL[rest % 3]),
        }
    }

    /// As [`Chain::site_index`].
    #[inline(always)]
    pub fn index(&self, site: Site) -> usize {
        match site {
            Site::Frame(frame, axis) => 6 * frame.0 + axis.index(),
            Site::Target(target, axis) => 6 * self.frames + 3 * target.0 + axis.direction(),
        }
    }

    /// A frame in a lane: where it is, and its axes.
    pub fn frame(&self, frame: usize, lane: usize) -> Pose {
        let (axes, place) = (self.behind(frame), self.place(frame));
        let at = |row: usize| self.numbers[row * LANES + lane];
        Pose::new(Matrix3::from_fn(|c, k| at(axes + 3 * k + c)), Vector3::from_fn(|c, _| at(place + c)))
    }

    /// What a frame carries in a lane, about its origin, in the measurement frame's axes.
    pub fn carries(&self, frame: usize, lane: usize) -> Wrench {
        let part = |first: usize| {
            Vector3::from_fn(|c, _| self.numbers[(self.wrench(frame) + first + c) * LANES + lane])
        };
        Wrench { force: part(0), moment: part(3) }
    }

    pub fn row(&self, row: usize) -> &[f64] {
        &self.numbers[row * LANES..][..LANES]
    }

    /// So many rows that follow each other.
    pub fn rows(&self, first: usize, count: usize) -> &[f64] {
        &self.numbers[first * LANES..][..count * LANES]
    }

    pub fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.numbers[row * LANES..][..LANES]
    }

    /// Gives every lane the frames of its standstill; what lies behind them is worked out lane by lane.
    pub fn spread(&mut self, standing: &Standing) {
        let (frames, place) = (self.frames, self.place(0));
        for frame in 0..frames {
            let mut spread = |first: usize| standing.spread(&mut self.numbers[first * LANES..][..9 * LANES]);
            spread(9 * frame);
            if !self.plain[frame] {
                spread(9 * (frames + frame));
                spread(9 * (2 * frames + frame));
            }
        }
        standing.spread(&mut self.numbers[place * LANES..(place + 3 * frames) * LANES]);
    }

    /// Where the targets of these rows nominally are.
    pub fn aim(&mut self, chain: &Chain, data: &Dataset, rows: &[usize]) {
        self.target.clear();
        self.target.extend(rows.iter().map(|&row| data.target[row]));
        if self.branches {
            self.tool.clear();
            self.tool.extend(rows.iter().map(|&row| data.tool(row)));
        }
        self.met.clear();
        if self.branches && data.any_met() {
            self.met.extend(rows.iter().map(|&row| Some(data.meets(row)?.on(chain))));
        }
        for direction in 0..3 {
            let at = (self.aimed() + direction) * LANES;
            for (lane, target) in self.target.iter().enumerate() {
                self.numbers[at + lane] = target.map_or(0.0, |t| chain.targets()[t.0].position[direction]);
            }
        }
    }
}
