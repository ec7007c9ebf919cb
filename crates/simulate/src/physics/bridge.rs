//! Slides that bend: a bridge between two posts, and a ram that comes out of its bushes.
//!
//! ```text
//! bridge   w = F a² b²/(3 E L) + F (b²/k_1 + a²/k_2)/L²      slope = F a b (b − a)/(3 E L) + F (a/k_2 − b/k_1)/L²
//! ram      w = ∫ (ℓ − s) M(s)/E(s) ds + ℓ M(0)/k_b             slope = ∫ M(s)/E(s) ds + M(0)/k_b,  E(s) = E (1 − t s/ℓ_m)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | a, b, L | distances of the carriage from the posts, and between them | m |
//! | E | `stiffness`: bending stiffness EI | N·m² |
//! | k_1, k_2 | `posts` | N/m |
//! | M(s) | moment in the ram at s from its bush: that at its end, and its force times the way to it | N·m |
//! | t, ℓ_m, k_b | `taper` over the length `full`; `bush` | 1, m, N·m/rad |
//!
//! Deflections are those under the force across the slide; a bridge carries no moment. The ram is integrated by Simpson's rule.
//! Source: Young and Budynas, *Roark's Formulas for Stress and Strain*, table 8.1 (simple beam, load at a; cantilever).

use nalgebra::{Unit, Vector3};
use truepose_kinematics::Wrench;

/// A bridge or rail between two posts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// Where the posts are, as values of the slide, m.
    pub ends: [f64; 2],
    /// N·m².
    pub stiffness: f64,
    /// N/m.
    pub posts: [f64; 2],
}

/// A ram that is longer the farther it is out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ram {
    /// Free length at the slide's zero, m.
    pub length: f64,
    /// N·m² at the bush.
    pub stiffness: f64,
    /// Loss of stiffness over the full length.
    pub taper: f64,
    /// m.
    pub full: f64,
    /// N·m/rad.
    pub bush: f64,
}

/// Part of a vector across an axis.
fn across(axis: &Unit<Vector3<f64>>, v: &Vector3<f64>) -> Vector3<f64> {
    v - axis.into_inner() * axis.dot(v)
}

impl Bridge {
    /// Displacement `[tx ty tz rx ry rz]` of the carriage at q under a wrench, in the axes of the slide.
    pub fn deflection(&self, q: f64, axis: &Unit<Vector3<f64>>, wrench: &Wrench) -> [f64; 6] {
        let [from, to] = self.ends;
        let (l, a, b) = (to - from, (q - from).clamp(0.0, to - from), (to - q).clamp(0.0, to - from));
        let [first, second] = self.posts;
        let force = across(axis, &wrench.force);
        let sag = a * a * b * b / (3.0 * self.stiffness * l) + (b * b / first + a * a / second) / (l * l);
        let slope = a * b * (b - a) / (3.0 * self.stiffness * l) + (a / second - b / first) / (l * l);
        six(force * sag, axis.cross(&force) * slope)
    }
}

impl Ram {
    /// Displacement of the ram's end at q under a wrench there, in the axes of the slide.
    pub fn deflection(&self, q: f64, axis: &Unit<Vector3<f64>>, wrench: &Wrench) -> [f64; 6] {
        let free = self.length + q;
        if free <= 0.0 {
            return [0.0; 6];
        }
        let (force, end) = (across(axis, &wrench.force), across(axis, &wrench.moment));
        let moment = |s: f64| end + axis.cross(&force) * (free - s);
        let pieces = 20;
        let h = free / f64::from(pieces);
        let mut slope = moment(0.0) / self.bush;
        let mut bent = slope * free;
        for k in 0..=pieces {
            let weight = if k == 0 || k == pieces { 1.0 } else { f64::from(2 + 2 * (k % 2)) } * h / 3.0;
            let s = h * f64::from(k);
            let curvature = moment(s) / (self.stiffness * (1.0 - self.taper * s / self.full));
            slope += curvature * weight;
            bent += curvature * ((free - s) * weight);
        }
        six(bent.cross(axis), slope)
    }
}

fn six(t: Vector3<f64>, r: Vector3<f64>) -> [f64; 6] {
    [t.x, t.y, t.z, r.x, r.y, r.z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bridge_is_softest_in_its_middle_and_rests_on_its_posts() {
        let bridge = Bridge { ends: [-1.0, 1.0], stiffness: 1e6, posts: [1e9, 1e9] };
        let wrench = Wrench { force: Vector3::new(50.0, 0.0, -1000.0), moment: Vector3::zeros() };
        let at = |q: f64| bridge.deflection(q, &Vector3::x_axis(), &wrench);
        // F L³/48 EI at the middle, and half of it on each post.
        assert!((at(0.0)[2] + 1000.0 * 8.0 / 48e6 + 1000.0 / 2e9).abs() < 1e-12);
        assert!((at(1.0)[2] + 1e-6).abs() < 1e-15 && at(0.3)[0] == 0.0);
        // The slope is that of the elastic line: it leans towards the middle.
        assert!(at(0.5)[4] * at(-0.5)[4] < 0.0);
    }

    #[test]
    fn a_ram_without_taper_and_bush_is_a_cantilever() {
        let ram = Ram { length: 0.2, stiffness: 1e5, taper: 0.0, full: 2.0, bush: f64::INFINITY };
        let force = Wrench { force: Vector3::new(0.0, 0.0, -100.0), moment: Vector3::zeros() };
        let at = |q: f64, w: &Wrench| ram.deflection(q, &Vector3::x_axis(), w);
        let six = at(0.8, &force);
        assert!((six[2] + 100.0 / 3e5).abs() < 1e-12 && (six[4] - 100.0 / 2e5).abs() < 1e-12, "{six:?}");
        let moment = Wrench { force: Vector3::zeros(), moment: Vector3::new(0.0, 30.0, 0.0) };
        let six = at(0.8, &moment);
        assert!((six[2] + 30.0 / 2e5).abs() < 1e-12 && (six[4] - 30.0 / 1e5).abs() < 1e-12, "{six:?}");
        let soft = Ram { taper: 0.5, bush: 1e4, ..ram };
        assert!(soft.deflection(0.8, &Vector3::x_axis(), &force)[2] < at(0.8, &force)[2]);
        assert!(at(-0.3, &force).iter().all(|part| part.abs() <= 0.0));
    }
}
