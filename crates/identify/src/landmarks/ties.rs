//! Which landmarks are unknown, and which of them known distances tie to which.

use crate::IdentifyError;
use nalgebra::Vector3;
use truepose_errormodel::effects::{Landmarks, Point, Tied};
use truepose_errormodel::{KnownDistance, Surroundings};

/// Landmarks of unknown place that were touched, each behind the one that it is tied to.
#[derive(Clone)]
pub(super) struct Structure {
    pub points: Vec<Point>,
    /// Of each point, its number among the declared landmarks.
    pub declared: Vec<usize>,
    /// Of each declared landmark, its number among the points; none of those that are known or were not touched.
    pub number: Vec<Option<usize>>,
    /// Distances that are kept: points, m.
    pub distances: Vec<([usize; 2], f64)>,
}

impl Structure {
    /// Whether the fit keeps a stated distance.
    pub fn keeps(&self, stated: &KnownDistance) -> bool {
        let [a, b] = stated.between;
        self.distances.iter().any(|([i, j], _)| {
            let pair = [self.declared[*i], self.declared[*j]];
            pair == [a, b] || pair == [b, a]
        })
    }

    /// Holds the scale by the distance between the two landmarks that are farthest apart; a sentence. None of fewer than two.
    pub fn hold_scale(&mut self, at: &[Vector3<f64>]) -> Option<String> {
        let mut landmarks = Landmarks { points: std::mem::take(&mut self.points) };
        let all: Vec<usize> = (0..landmarks.points.len()).collect();
        let pair = landmarks.held_between(&all, at);
        self.points = landmarks.points;
        let [a, b] = pair?;
        Some(format!(
            "the fit keeps the scale of the robot as described: {} and {} stay {:.1} mm apart, as it has them",
            self.points[a].name,
            self.points[b].name,
            (at[b] - at[a]).norm() * 1e3
        ))
    }

    /// The landmarks with directions as they are now; those at known distances are brought there.
    pub fn placed(&self, at: &mut [Vector3<f64>]) -> Landmarks {
        let mut points = self.points.clone();
        for (k, point) in points.iter_mut().enumerate() {
            if let Some(tied) = &mut point.tied {
                let way = at[k] - at[tied.to];
                let along = way.try_normalize(1e-9).unwrap_or_else(Vector3::x);
                tied.direction = along.into();
                at[k] = at[tied.to] + along * tied.distance;
            }
        }
        Landmarks { points }
    }
}

/// Of the landmark of each row, as declared.
pub(super) fn tied(
    of_row: &[Option<usize>],
    surroundings: &Surroundings,
    remarks: &mut Vec<String>,
) -> Result<Structure, IdentifyError> {
    let landmarks = &surroundings.landmarks;
    let mut rows = vec![0usize; landmarks.len()];
    of_row.iter().flatten().for_each(|&k| rows[k] += 1);
    for (landmark, &rows) in landmarks.iter().zip(&rows) {
        if rows == 1 {
            return Err(IdentifyError::Landmark {
                name: landmark.name.clone(),
                why: "one row touched it, which says nothing where its place is unknown: touch it from other postures as well, or leave the row out".into(),
            });
        }
        if rows == 0 && !landmark.known && landmark.observed.is_none() {
            remarks.push(format!("no row touched landmark {}", landmark.name));
        }
    }
    let name = |k: usize| landmarks[k].name.as_str();
    let mut of = Structure {
        points: Vec::new(),
        declared: Vec::new(),
        number: vec![None; landmarks.len()],
        distances: Vec::new(),
    };
    for root in (0..landmarks.len()).filter(|&k| rows[k] > 0) {
        if of.number[root].is_some() {
            continue;
        }
        // Breadth first: what is tied stands behind what it is tied to.
        let mut next = std::collections::VecDeque::from([(root, None)]);
        while let Some((k, tie)) = next.pop_front() {
            if of.number[k].is_some() {
                continue;
            }
            let here = of.points.len();
            of.number[k] = Some(here);
            of.declared.push(k);
            let tied = tie.map(|(to, distance): (usize, f64)| {
                of.distances.push(([to, here], distance));
                Tied { to, direction: [1.0, 0.0, 0.0], distance, held: false }
            });
            of.points.push(Point { name: name(k).into(), tied });
            for distance in &surroundings.distances {
                let other = match distance.between {
                    [a, b] if a == k => b,
                    [a, b] if b == k => a,
                    _ => continue,
                };
                if rows[other] > 0 && !landmarks[other].known && of.number[other].is_none() {
                    next.push_back((other, Some((here, distance.value))));
                }
            }
        }
    }
    for distance in &surroundings.distances {
        let [a, b] = distance.between;
        if !of.keeps(distance) {
            remarks.push(format!(
                "the distance from {} to {} is not used: both have to be touched and of unknown place, and distances must not close a ring",
                name(a),
                name(b)
            ));
        }
    }
    Ok(of)
}
