//! A straight, slender cantilever under a wrench at its tip and under its own weight: the bending moment, summed up.
//!
//! ```text
//!   root ●━━━━━━━━━━━┳━━━━━━━━━● tip        F, M at the tip; m g spread evenly over c ± h
//!        0     c−h   c   c+h   L            e: how far its centre lies beside the beam
//!
//! M(s) = M + (L − s) x̂ × F + (m₁(s) x̂ + m(s) e) × g      m(s) mass beyond s, m₁(s) its first moment about s
//! I_0 = ∫ M(s) ds = M L + x̂ × F L²/2 + (μ₁ x̂ + μ₀ e) × g
//! I_1 = ∫ M(s) (L − s) ds = M L²/2 + x̂ × F L³/3 + (ν₁ x̂ + ν₀ e) × g
//! ```
//!
//! Each slice turns by M(s) ds / EI, which carries the tip round it: θ = I_0 / EI and δ = I_1 × x̂ / EI for bending, and
//! φ = x̂ · I_0 / GJ for twist. A force across gives F L³/3EI and F L²/2EI, a moment M L²/2EI and M L/EI, an even weight
//! w gives w L⁴/8EI and w L³/6EI. Source: Gere and Timoshenko, *Mechanics of Materials*, chapters 3 and 9.

use truepose_kinematics::Wrench;
use truepose_kinematics::nalgebra::Vector3;

/// What is no longer does not bend, m.
pub(super) const NO_LENGTH: f64 = 1e-6;

/// The moments that bend and twist a beam, summed over its length. All vectors are in the same axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Unit vector from root to tip.
    along: Vector3<f64>,
    /// L, m.
    length: f64,
    /// I_0, N·m².
    slope: Vector3<f64>,
    /// I_1, N·m³.
    sag: Vector3<f64>,
}

impl Beam {
    /// An unloaded beam with this vector from root to tip; none without a length.
    pub fn new(span: &Vector3<f64>) -> Option<Self> {
        let length = span.norm();
        (length > NO_LENGTH).then(|| Beam {
            along: span / length,
            length,
            slope: Vector3::zeros(),
            sag: Vector3::zeros(),
        })
    }

    /// With a wrench at the tip, about the tip.
    pub fn with_tip(mut self, tip: &Wrench) -> Self {
        let l = self.length;
        let turned = self.along.cross(&tip.force);
        self.slope += tip.moment * l + turned * (l * l / 2.0);
        self.sag += tip.moment * (l * l / 2.0) + turned * (l * l * l / 3.0);
        self
    }

    /// With its own mass (kg), whose centre lies at `centre` from the root: spread evenly to both sides of it, as far
    /// as the nearer end. A mass in front of the tip hangs on it; one behind the root bends nothing.
    pub fn with_mass(self, mass: f64, centre: &Vector3<f64>, gravity: &Vector3<f64>) -> Self {
        let (l, c) = (self.length, self.along.dot(centre));
        let weight = gravity * mass;
        if c >= l {
            let arm = centre - self.along * l;
            return self.with_tip(&Wrench { force: weight, moment: arm.cross(&weight) });
        }
        if c <= 0.0 {
            return self;
        }
        let h = c.min(l - c);
        // Means of u, u² and u³ over the part that has the mass.
        let (u1, u2, u3) = (c, c * c + h * h / 3.0, c * (c * c + h * h));
        let (ahead, beside) = (self.along.cross(&weight), (centre - self.along * c).cross(&weight));
        Beam {
            slope: self.slope + ahead * (u2 / 2.0) + beside * u1,
            sag: self.sag + ahead * (l * u2 / 2.0 - u3 / 6.0) + beside * (l * u1 - u2 / 2.0),
            ..self
        }
    }

    /// Unit vector from root to tip.
    pub fn along(&self) -> Vector3<f64> {
        self.along
    }

    /// Displacement and rotation of the tip per 1/EI, bent about every axis across the beam alike.
    pub fn bent(&self) -> (Vector3<f64>, Vector3<f64>) {
        let across = |v: Vector3<f64>| v - self.along * self.along.dot(&v);
        (self.sag.cross(&self.along), across(self.slope))
    }

    /// Displacement and rotation of the tip per 1/EI, bent about one axis across the beam only.
    pub fn bent_about(&self, axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let part = |v: Vector3<f64>| axis * axis.dot(&v);
        (part(self.sag).cross(&self.along), part(self.slope))
    }

    /// Rotation of the tip per 1/GJ.
    pub fn twisted(&self) -> Vector3<f64> {
        self.along * self.along.dot(&self.slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::nalgebra::vector;

    const L: f64 = 1.3;

    /// Sums slice after slice, as the first line of the derivation says.
    fn by_slices(tip: &Wrench, mass: f64, centre: Vector3<f64>, g: Vector3<f64>) -> [Vector3<f64>; 2] {
        let slices = 4000;
        let (x, ds) = (Vector3::x(), L / f64::from(slices));
        let h = centre.x.min(L - centre.x);
        let (mut delta, mut theta) = (Vector3::zeros(), Vector3::zeros());
        for k in 0..slices {
            let s = (f64::from(k) + 0.5) * ds;
            let mut moment = tip.moment + (x * (L - s)).cross(&tip.force);
            let from = s.clamp(centre.x - h, centre.x + h);
            let beyond = mass * (centre.x + h - from) / (2.0 * h);
            let arm = vector![(from + centre.x + h) / 2.0 - s, centre.y, centre.z];
            moment += arm.cross(&(g * beyond));
            moment.x = 0.0;
            theta += moment * ds;
            delta += (moment * ds).cross(&(x * (L - s)));
        }
        [delta, theta]
    }

    #[test]
    fn textbook_formulas() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs().max(1e-3), "{a} against {b}");
        let beam = Beam::new(&vector![L, 0.0, 0.0]).unwrap();
        let pushed = beam.with_tip(&Wrench { force: vector![0.0, 0.0, -700.0], ..Wrench::default() });
        close(pushed.bent().0.z, -700.0 * L.powi(3) / 3.0);
        close(pushed.bent().1.y, 700.0 * L.powi(2) / 2.0);
        let turned = beam.with_tip(&Wrench { moment: vector![50.0, 0.0, 90.0], ..Wrench::default() });
        close(turned.bent().0.y, 90.0 * L.powi(2) / 2.0);
        close(turned.bent().1.z, 90.0 * L);
        close(turned.twisted().x, 50.0 * L);
        let even = beam.with_mass(60.0, &vector![L / 2.0, 0.0, 0.0], &vector![0.0, 0.0, -9.81]);
        let w = 60.0 * 9.81 / L;
        close(even.bent().0.z, -w * L.powi(4) / 8.0);
        close(even.bent().1.y, w * L.powi(3) / 6.0);
        let aside = beam.with_mass(60.0, &vector![L / 2.0, 0.1, 0.0], &vector![0.0, 0.0, -9.81]);
        close(aside.twisted().x, -60.0 * 9.81 * 0.1 * L / 2.0);
    }

    #[test]
    fn any_load_is_the_sum_of_its_slices() {
        let tip = Wrench { force: vector![30.0, 200.0, -700.0], moment: vector![9.0, -80.0, 40.0] };
        let g = vector![2.0, -3.0, -9.0];
        for c in [0.2, 0.65, 1.1] {
            let centre = vector![c, 0.07, -0.04];
            let [delta, theta] = by_slices(&tip, 60.0, centre, g);
            let beam = Beam::new(&vector![L, 0.0, 0.0]).unwrap().with_tip(&tip).with_mass(60.0, &centre, &g);
            let (sag, slope) = beam.bent();
            assert!((sag - delta).norm() < 1e-6 * delta.norm(), "{sag} against {delta}");
            assert!((slope - theta).norm() < 1e-6 * theta.norm(), "{slope} against {theta}");
        }
    }
}
