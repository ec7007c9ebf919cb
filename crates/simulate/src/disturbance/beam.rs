//! What bends or offsets the beam of an instrument: air in layers, and a prism behind which the target is.
//!
//! ```text
//! layers   δ = û ∫_0^R (R − s) κ(z(s)) ds,     κ(z) = κ_0 e^(−z/H)          z: height over the station along the beam
//! prism    δ = a e (n − cos i/√(1 − sin² i/n²))/(n − 1)                    e: unit vector from the station; i: incidence
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | κ_0, H | `curvature` of the beam at the station's height; height over which the gradient falls | 1/m, m |
//! | a, n | `offset` at normal incidence, index of the glass | m, 1 |
//! | i | between the beam and the tool's z axis | rad |
//!
//! The beam leaves towards the target; where it arrives is off by δ. Sources: Ciddor (1996); Rüeger, *Electronic Distance Measurement*, chapter 10
//! (reflector constants and incidence).

use nalgebra::Vector3;

/// Errors along and across the beam of an instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// 1/m at the height of the station; upwards.
    pub curvature: f64,
    /// m.
    pub fall: f64,
    /// m.
    pub offset: f64,
}

/// Of the glass of a prism.
const GLASS: f64 = 1.51;

impl Beam {
    /// Displacement of a point as it is seen from the station, m; `up` is the vertical, `facing` the tool's z axis.
    pub(crate) fn displacement(
        &self,
        station: &Vector3<f64>,
        point: &Vector3<f64>,
        up: &Vector3<f64>,
        facing: &Vector3<f64>,
    ) -> Vector3<f64> {
        let sight = point - station;
        let range = sight.norm();
        if range < 1e-9 {
            return Vector3::zeros();
        }
        let direction = sight / range;
        let rise = direction.dot(up);
        let level = (1.0 - rise * rise).max(0.0).sqrt();
        let pieces = 40;
        let h = range / f64::from(pieces);
        let bent: f64 = (0..pieces)
            .map(|k| {
                let s = h * (f64::from(k) + 0.5);
                (range - s) * self.curvature * (-(s * rise) / self.fall).exp() * h
            })
            .sum();
        let cosine = direction.dot(facing).abs().min(1.0);
        let sine_squared = 1.0 - cosine * cosine;
        let glass = (GLASS - cosine / (1.0 - sine_squared / (GLASS * GLASS)).sqrt()) / (GLASS - 1.0);
        // Across the beam only its level part bends.
        up * (bent * level) + direction * (self.offset * glass.clamp(0.5, 2.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_bends_with_the_square_of_the_range_and_is_offset_along_the_beam() {
        let (up, facing) = (Vector3::z(), Vector3::x());
        let bends = Beam { curvature: 2e-6, fall: 1.0, offset: 0.0 };
        let at = |x: f64| bends.displacement(&Vector3::zeros(), &Vector3::new(x, 0.0, 0.0), &up, &facing);
        assert!((at(3.0).z - 9e-6).abs() < 1e-8 && (at(6.0).z / at(3.0).z - 4.0).abs() < 1e-9);
        // Above the station there is less of it.
        let high = bends.displacement(&Vector3::zeros(), &Vector3::new(3.0, 0.0, 1.0), &up, &facing);
        assert!(high.z < at(3.0).z);
        let offset = Beam { curvature: 0.0, fall: 1.0, offset: 1e-4 };
        let seen = offset.displacement(&Vector3::zeros(), &Vector3::new(2.0, 0.0, 0.0), &up, &facing);
        assert!((seen - Vector3::new(1e-4, 0.0, 0.0)).norm() < 1e-12);
    }
}
