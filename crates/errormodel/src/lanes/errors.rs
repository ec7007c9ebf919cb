//! ε = Φ c in a block of rows: what is the same in all lanes, and what is not.

use super::emission::LaneEmission;
use super::standing::Standing;
use super::width::LANES;
use crate::GeneralizedErrors;
use truepose_kinematics::pulp::{Arch, Simd, WithSimd};
use truepose_kinematics::{Axis, Chain, FrameId, Site, TargetId};

/// All generalized errors of a block.
#[derive(Debug, Clone)]
pub(crate) struct LaneErrors {
    /// For each site: what all lanes have.
    same: Vec<f64>,
    /// For each site: what comes on top in each lane.
    lanes: Vec<f64>,
    /// Whether anything does.
    varies: Vec<bool>,
    /// Sites of frames; those of targets follow.
    of_frames: usize,
    /// The processor's registers.
    pub arch: Arch,
}

/// The errors of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FrameErrors {
    /// None.
    Plain,
    /// The same in all lanes.
    Same([f64; 6]),
    /// Different.
    Varying,
}

impl LaneErrors {
    pub fn new(chain: &Chain) -> Self {
        let sites = chain.site_count();
        LaneErrors {
            same: vec![0.0; sites],
            lanes: vec![0.0; sites * LANES],
            varies: vec![false; sites],
            of_frames: 6 * chain.frames().len(),
            arch: Arch::new(),
        }
    }

    pub fn clear(&mut self) {
        self.same.fill(0.0);
        for (lanes, varies) in self.lanes.chunks_exact_mut(LANES).zip(&mut self.varies) {
            if std::mem::take(varies) {
                lanes.fill(0.0);
            }
        }
    }

    /// Adds those of an emission's entries, from one on, with these coefficients.
    pub fn add(&mut self, emission: &LaneEmission, from: usize, coefficients: &[f64]) {
        self.arch.dispatch(Add { errors: self, emission, from, coefficients });
    }

    /// Becomes what another one is, which has the same sites.
    pub fn become_as(&mut self, other: &Self) {
        self.same.copy_from_slice(&other.same);
        let theirs = other.lanes.chunks_exact(LANES).zip(&other.varies);
        let mine = self.lanes.chunks_exact_mut(LANES).zip(&mut self.varies);
        for ((mine, varies), (theirs, vary)) in mine.zip(theirs) {
            if *varies || *vary {
                mine.copy_from_slice(theirs);
            }
            *varies = *vary;
        }
    }

    /// The largest difference to another one with the same sites in so many lanes, m or rad.
    pub fn furthest(&self, other: &Self, rows: usize) -> f64 {
        let mut most = 0.0f64;
        for site in (0..self.varies.len()).filter(|&site| self.varies[site] || other.varies[site]) {
            let own = &self.lanes[site * LANES..][..rows];
            let before = &other.lanes[site * LANES..][..rows];
            let same = self.same[site] - other.same[site];
            most = own.iter().zip(before).fold(most, |most, (a, b)| most.max((a - b + same).abs()));
        }
        most
    }

    /// Gives every lane the errors of its standstill.
    pub fn spread(&mut self, standing: &Standing) {
        for (lanes, _) in self.lanes.chunks_exact_mut(LANES).zip(&self.varies).filter(|(_, varies)| **varies)
        {
            standing.spread(lanes);
        }
    }

    /// Takes those of one lane.
    pub fn take(&mut self, lane: usize, errors: &GeneralizedErrors, chain: &Chain) {
        for site in 0..self.same.len() {
            let value = errors.get(chain.site_at(site));
            if value != 0.0 {
                self.varies[site] = true;
                self.lanes[site * LANES + lane] = value;
            }
        }
    }

    pub fn of(&self, frame: FrameId) -> FrameErrors {
        let sites = 6 * frame.0..6 * frame.0 + 6;
        if self.varies[sites.clone()].contains(&true) {
            return FrameErrors::Varying;
        }
        let mut same = [0.0; 6];
        same.copy_from_slice(&self.same[sites]);
        if same.iter().all(|&e| e == 0.0) { FrameErrors::Plain } else { FrameErrors::Same(same) }
    }

    /// The errors of a frame's component, lane by lane.
    pub fn write(&self, frame: FrameId, axis: Axis, into: &mut [f64]) {
        let site = 6 * frame.0 + axis.index();
        for (into, lane) in into.iter_mut().zip(&self.lanes[site * LANES..]) {
            *into = self.same[site] + lane;
        }
    }

    /// The error of a target in a lane; zero of a target that a single row has of its own.
    pub fn target(&self, chain: &Chain, target: TargetId, direction: usize, lane: usize) -> f64 {
        let site = chain.site_index(Site::Target(target, Axis::ALL[direction]));
        self.same.get(site).map_or(0.0, |same| same + self.lanes[site * LANES + lane])
    }

    /// How many sites there are.
    #[inline(always)]
    pub fn sites(&self) -> usize {
        self.same.len()
    }

    /// What all lanes have at a site, and what comes on top.
    #[inline(always)]
    pub fn at(&self, site: usize) -> (f64, Option<&[f64]>) {
        (self.same[site], self.varies[site].then(|| &self.lanes[site * LANES..][..LANES]))
    }

    /// Whether any target has errors.
    pub fn of_targets(&self) -> bool {
        let first = self.of_frames;
        self.same[first..].iter().any(|&e| e != 0.0) || self.varies[first..].contains(&true)
    }
}

struct Add<'a> {
    errors: &'a mut LaneErrors,
    emission: &'a LaneEmission,
    from: usize,
    coefficients: &'a [f64],
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Add { errors, emission, from, coefficients } = self;
        for entry in &emission.entries[from..] {
            let by = entry.factor * coefficients[entry.column as usize];
            if by == 0.0 {
                continue;
            }
            let site = match entry.site {
                Site::Frame(frame, axis) => 6 * frame.0 + axis.index(),
                Site::Target(target, axis) => errors.of_frames + 3 * target.0 + axis.direction(),
            };
            if entry.value == LaneEmission::ONE {
                errors.same[site] += by;
                continue;
            }
            errors.varies[site] = true;
            let lanes = &mut errors.lanes[site * LANES..][..LANES];
            for (e, value) in lanes.iter_mut().zip(emission.numbers(entry.value)) {
                *e += by * value;
            }
        }
    }
}
