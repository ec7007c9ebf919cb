//! Multi-directional pose accuracy variation vAP: how far the means of different directions of approach lie apart.
//!
//! ```text
//! vAP_p = max_{h,k} ‖x̄_h − x̄_k‖        vAP_a = max_{h,k} |ā_h − ā_k|, …
//! ```
//!
//! h and k are directions of approach. What all readings of a pose share (the instrument) cancels. Source: ISO 9283:1998, 7.2.3.

use crate::figure::{Figure, Method, welch_satterthwaite};
use crate::scatter::Scatter;
use nalgebra::Vector3;

/// vAP of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct MultiDirection {
    /// Number of directions.
    pub directions: usize,
    /// Fewest cycles of a direction.
    pub cycles: usize,
    /// vAP_p, m.
    pub vap: Figure,
    /// vAP_a, vAP_b, vAP_c, rad; none without orientations.
    pub vap_angles: Option<[Figure; 3]>,
}

/// Of the deviations of each direction, of which there are two at least with two cycles each. `rotations` is empty, or as long.
pub fn multi_direction(positions: &[Vec<Vector3<f64>>], rotations: &[Vec<Vector3<f64>>]) -> MultiDirection {
    let scatters: Vec<Scatter> = positions.iter().map(|one| Scatter::of(one)).collect();
    let complete = !rotations.is_empty()
        && rotations.iter().zip(positions).all(|(a, b)| a.len() == b.len())
        && rotations.len() == positions.len();
    let angles: Vec<Scatter> =
        if complete { rotations.iter().map(|one| Scatter::of(one)).collect() } else { Vec::new() };
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    MultiDirection {
        directions: positions.len(),
        cycles: positions.iter().map(Vec::len).min().unwrap_or(0),
        vap: farthest(&scatters, None),
        vap_angles: complete.then(|| axes.map(|axis| farthest(&angles, Some(axis)))),
    }
}

/// The largest difference of two means, or of their components along an axis.
fn farthest(scatters: &[Scatter], axis: Option<Vector3<f64>>) -> Figure {
    let mut most = Figure::with_u(0.0, 0.0, f64::INFINITY, Method::FirstOrder);
    for (h, a) in scatters.iter().enumerate() {
        for b in &scatters[..h] {
            let apart = a.mean - b.mean;
            let size = axis.map_or(apart.norm(), |axis| apart.dot(&axis).abs());
            let direction = axis.unwrap_or(if size > 0.0 { apart / size } else { Vector3::x() });
            let parts = [a, b].map(|s| (s.variance_of_mean(&direction), s.freedom()));
            if size > most.value || most.u <= 0.0 {
                let u = (parts[0].0 + parts[1].0).sqrt();
                most = Figure::with_u(size, u, welch_satterthwaite(&parts), Method::FirstOrder);
            }
        }
    }
    most
}
