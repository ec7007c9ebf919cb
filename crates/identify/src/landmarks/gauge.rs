//! What no row of a campaign can show, in words: the place of the base, the scale, and what one more row would fix.
//!
//! A robot that is measured against itself alone can be moved, turned and scaled as a whole, and every row is as it was. Which of that is left
//! depends on what is known outside: a known place fixes the base, a known length the scale.

use super::sensors::Sensors;
use nalgebra::{DMatrix, DVector};
use std::any::Any;
use truepose_errormodel::observation::Plane;
use truepose_errormodel::{KnownDistance, Surroundings};

/// Planes that miss a common point by less tell no length, m.
const APART: f64 = 1e-2;

/// What was measured, as far as it fixes a gauge.
#[derive(Clone)]
pub(super) struct Gauge<'a> {
    /// Whether a position, or a known landmark, was measured.
    pub outside: bool,
    /// Whether the fit keeps a known distance between landmarks.
    pub distances: bool,
    /// Those between landmarks that it keeps, where all distances are such.
    pub kept: Vec<&'a KnownDistance>,
    /// Whether points were touched again and again.
    pub touched: bool,
    /// Whether no effect changes the arm itself: its lengths are known then.
    pub frozen: bool,
    /// Whether cameras of known lens saw targets of known place on a tool: how long these are apart is known.
    pub sized: bool,
    /// What measured numbers.
    pub sensors: &'a Sensors,
}

impl Gauge<'_> {
    /// Whether some row says where the base is.
    pub fn has_base(&self) -> bool {
        self.outside || self.sensors.found.iter().any(|found| found.observation.outside())
    }

    /// Whether some row says how long anything is.
    pub fn has_scale(&self) -> bool {
        let metric = self.sensors.found.iter().any(|found| found.observation.metric());
        self.sized || self.frozen || self.outside || self.distances || metric || self.planes_apart()
    }

    /// Whether nothing but targets on a tool says how long anything is.
    pub fn by_targets(&self) -> bool {
        self.sized && !Gauge { sized: false, ..self.clone() }.has_scale()
    }

    /// Whether planes of known place do not all meet in one point: a robot that shrinks into such a point would stay on all of them.
    fn planes_apart(&self) -> bool {
        let planes = self.sensors.found.iter().filter_map(|found| {
            let plane = (&*found.observation as &dyn Any).downcast_ref::<Plane>().filter(|of| of.known)?;
            let normal = plane.normal?.normalize();
            Some((normal, normal.dot(&plane.point?)))
        });
        let (normals, offsets): (Vec<_>, Vec<f64>) = planes.unzip();
        if normals.is_empty() {
            return false;
        }
        let a = DMatrix::from_fn(normals.len(), 3, |row, axis| normals[row][axis]);
        let c = DVector::from_vec(offsets);
        let nearest = a.clone().svd(true, true).solve(&c, 1e-6);
        nearest.is_ok_and(|point| (a * point - c).amax() > APART)
    }

    /// Whether a robot that is as small as a point would agree with every row: with the planes, or the camera, as small as itself.
    fn may_shrink(&self) -> bool {
        !self.has_scale() && !self.has_base() && !self.touched && !self.sensors.is_empty()
    }

    /// The same where points were touched: then one distance between them can be held.
    pub fn lets_landmarks_shrink(&self) -> bool {
        self.touched && !self.has_scale() && !self.has_base()
    }

    /// How well known distances alone determine the scale, where nothing else does: the relative standard deviation of lengths where the errors of
    /// these distances are independent, and where all of them share one, as those of one part that was measured once.
    ///
    /// ```text
    /// s² = 1/Σ (L/σ)²,   s' = Σ w σ/L,   w = (L/σ)²/Σ (L/σ)²
    /// ```
    fn scale_by_distances(&self) -> Option<[f64; 2]> {
        let metric = self.sensors.found.iter().any(|found| found.observation.metric());
        let others = self.sized || self.frozen || self.outside || metric || self.planes_apart();
        let stated = &self.kept;
        let known = !others && stated.iter().all(|of| of.sd > 0.0 && of.value > 0.0);
        let sum: f64 = stated.iter().map(|of| (of.value / of.sd).powi(2)).sum();
        let shared: f64 = stated.iter().map(|of| of.value / of.sd).sum::<f64>() / sum;
        (known && sum > 0.0).then(|| [1.0 / sum.sqrt(), shared])
    }

    /// Why nothing can be fitted, where a robot as small as a point would agree with every row.
    pub fn refusal(&self) -> Option<String> {
        const MORE: &str = "add one known distance ([[distances]]), a `distance` of known gain, a sphere of known radius, known planes that do not all meet in one point, \
                            or for a camera of known lens two targets of known place on the tool";
        self.may_shrink().then(|| {
            format!(
                "the scale is not determined: a robot as small as a point would agree with every row; {MORE}"
            )
        })
    }

    /// Sentences.
    pub fn words(&self, surroundings: &Surroundings) -> Vec<String> {
        let mut words = Vec::new();
        if !self.has_base() {
            words.push(
                "the base is not determined: nothing outside of the robot was measured; positions are in the frame of its base".into(),
            );
        } else if !self.outside {
            words.push(
                "the base is determined by landmarks of known place alone, and only as far as these go: three of them that are not in line, or three measured positions, determine all of it".into(),
            );
        }
        if !self.has_scale() {
            let what = match (self.touched, self.sensors.is_empty()) {
                (true, _) => "the spread at the landmarks",
                (false, _) => "the residual",
            };
            words.push(format!(
                "the scale is not determined: add one known distance ([[distances]]), a `distance` of known gain, a sphere of known radius, or known planes that do not all meet in one point; without it {what} says nothing about lengths"
            ));
        }
        if self.by_targets() {
            words.push(
                "the targets on the tool alone determine the scale: their places are taken as exact, and lengths are as well known as the distances between them".into(),
            );
        }
        // A tenth of a millimetre over a metre.
        const WORTH_TELLING: f64 = 1e-4;
        if let Some([apart, shared]) =
            self.scale_by_distances().map(|of| of.map(|sd| 1.96 * sd)).filter(|of| of[1] > WORTH_TELLING)
        {
            let percent = |part: f64| format!("±{:.2} %", 100.0 * part);
            words.push(format!(
                "known distances alone determine the scale: lengths are known to {} if their errors are independent, to {} if all are of one part that was measured once (95 %); longer distances determine it better",
                percent(apart),
                percent(shared)
            ));
        }
        let planes = self.sensors.found.iter().filter(|found| found.observation.kind() == "plane").count();
        if planes > 0 && planes == self.sensors.found.len() && !self.touched && !self.outside {
            let more = if planes == 1 { "one plane" } else { "planes" };
            words.push(format!(
                "only {more} was probed: what moves the robot within a plane is seen through its joints alone; a known distance between two touched points, or a sphere of known radius, adds the most"
            ));
        }
        for landmark in &surroundings.landmarks {
            let used = self.sensors.found.iter().any(|found| found.name == landmark.name);
            if landmark.observed.is_some() && !used {
                words.push(format!("no row observed landmark {}", landmark.name));
            }
        }
        words
    }
}
