//! A link as an elastic beam: bending in two planes, shear, twist and stretch under the wrench at its tip
//! and under its own distributed weight.
//!
//! ```text
//!   root ●━━━━━━━━━━━━━━━━━━━━━━● tip      ρ(s) g on the way, F and M at the tip
//!        0          s           L
//!
//! F(s) = F_L + m(s) g                                     m(s) = ∫_s^L ρ du
//! M(s) = M_L + (r_L − r_s) × F_L + (m₁(s) x̂ + m(s) e) × g   m₁(s) = ∫_s^L ρ (u − s) du
//! θ = ∫ C_M M ds          δ = ∫ (C_M M) × (r_L − r_s) + C_F F ds
//! C_M = diag(1/GJ, 1/EI_y, 1/EI_z)       C_F = diag(1/EA, 1/κGA, 1/κGA)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | L, x̂ | `tip − root` | m | of the joint's link |
//! | EI_y, EI_z | `bending` | N·m² | beam: about y, about z |
//! | GJ, EA, κGA | `torsion`, `axial`, `shear` | N·m², N, N | beam |
//! | ρ, e | `Spread` | kg/m, m | beam |
//! | δ, θ | the result | m, rad | of the joint's link |
//!
//! Each slice of the beam turns by C_M M ds, which carries the tip round the slice: the integrals above are
//! Euler–Bernoulli's beam, with Timoshenko's shear where κGA is finite. Integrands are polynomials of degree
//! five at most, so that Gauss' rule of four points on each piece is exact.
//! Source: Gere and Timoshenko, *Mechanics of Materials*, chapters 5 and 9.

use crate::SimulateError;
use nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Link, Wrench};

/// A straight elastic beam in the axes of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Where it is clamped, m.
    pub root: Vector3<f64>,
    /// Where the next joint sits, m.
    pub tip: Vector3<f64>,
    /// Bending stiffness about the section's y and z, N·m².
    pub bending: [f64; 2],
    /// Torsional stiffness, N·m².
    pub torsion: f64,
    /// Axial stiffness, N; infinite for a beam that does not stretch.
    pub axial: f64,
    /// Shear stiffness κGA, N; infinite for Euler–Bernoulli.
    pub shear: f64,
    /// A direction that the section's y leans towards (made square to the beam).
    pub section_y: Vector3<f64>,
}

/// How a link's own mass lies along its beam: a density that is linear in s between two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spread {
    from: f64,
    to: f64,
    /// kg/m at `from` and its slope, kg/m².
    density: f64,
    slope: f64,
    /// Offset of the centre of mass from the beam's line, m.
    offset: Vector3<f64>,
}

impl Beam {
    /// A slender beam of round section: equal bending, no stretch, no shear.
    ///
    /// # Errors
    /// When the beam has no length or a stiffness is not positive.
    pub fn slender(
        root: Vector3<f64>,
        tip: Vector3<f64>,
        bending: f64,
        torsion: f64,
    ) -> Result<Self, SimulateError> {
        let along = tip - root;
        // Any direction that is far from the beam's will do for a round section.
        let least = along.iamin();
        let mut section_y = Vector3::zeros();
        section_y[least] = 1.0;
        Beam {
            root,
            tip,
            bending: [bending; 2],
            torsion,
            axial: f64::INFINITY,
            shear: f64::INFINITY,
            section_y,
        }
        .checked()
    }

    /// The same beam, if its numbers make sense.
    ///
    /// # Errors
    /// When the beam has no length, a stiffness is not positive or `section_y` lies along the beam.
    pub fn checked(self) -> Result<Self, SimulateError> {
        let stiffnesses = [self.bending[0], self.bending[1], self.torsion, self.axial, self.shear];
        for value in stiffnesses {
            if value.is_nan() || value <= 0.0 {
                return Err(SimulateError::Size { what: "a beam's stiffness", value, need: "positive" });
            }
        }
        let length = (self.tip - self.root).norm();
        if !length.is_finite() || length < 1e-6 {
            return Err(SimulateError::Size { what: "a beam's length", value: length, need: "positive" });
        }
        let sine = (self.tip - self.root).cross(&self.section_y).norm() / length / self.section_y.norm();
        if sine.is_nan() || sine < 1e-3 {
            return Err(SimulateError::Size {
                what: "the sine between a beam and its section's y",
                value: sine,
                need: "well above zero",
            });
        }
        Ok(self)
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        (self.tip - self.root).norm()
    }

    /// Columns x, y, z of the beam in the link's axes.
    fn axes(&self) -> Matrix3<f64> {
        let x = (self.tip - self.root).normalize();
        let y = (self.section_y - x * x.dot(&self.section_y)).normalize();
        Matrix3::from_columns(&[x, y, x.cross(&y)])
    }

    /// Displacement `[tx ty tz rx ry rz]` of the tip in the link's axes, under the wrench at the tip (about
    /// the tip) and the link's own weight; wrench and gravity (m/s²) in the link's axes.
    pub fn deflection(&self, tip: &Wrench, own: Option<&Link>, gravity: &Vector3<f64>) -> [f64; 6] {
        let (axes, length) = (self.axes(), self.length());
        let into = axes.transpose();
        let (mut force, mut moment, g) = (into * tip.force, into * tip.moment, into * gravity);
        let spread = own.and_then(|link| {
            let centre = into * (link.com - self.root);
            if centre.x >= length {
                // A mass in front of the tip hangs on it.
                let weight = g * link.mass;
                force += weight;
                moment += (centre - Vector3::x() * length).cross(&weight);
            }
            Spread::of(link.mass, &centre, length)
        });

        let turn = Vector3::new(1.0 / self.torsion, 1.0 / self.bending[0], 1.0 / self.bending[1]);
        let give = Vector3::new(1.0 / self.axial, 1.0 / self.shear, 1.0 / self.shear);
        let (mut delta, mut theta) = (Vector3::zeros(), Vector3::zeros());
        let (from, to) = spread.map_or((0.0, 0.0), |s| (s.from, s.to));
        for (a, b) in [(0.0, from), (from, to), (to, length)] {
            for (s, ds) in gauss(a, b) {
                let arm = Vector3::x() * (length - s);
                let (mut f, mut m) = (force, moment + arm.cross(&force));
                if let Some(spread) = &spread {
                    let (mass, first) = spread.beyond(s);
                    f += g * mass;
                    m += (Vector3::x() * first + spread.offset * mass).cross(&g);
                }
                let bent = turn.component_mul(&m) * ds;
                theta += bent;
                delta += bent.cross(&arm) + give.component_mul(&f) * ds;
            }
        }
        let (delta, theta) = (axes * delta, axes * theta);
        [delta.x, delta.y, delta.z, theta.x, theta.y, theta.z]
    }
}

impl Spread {
    /// The linear density with this mass and centre. A centre in the middle third spreads the mass over the
    /// whole beam; one nearer to an end, over the part next to that end; one behind the root does not bend it.
    fn of(mass: f64, centre: &Vector3<f64>, length: f64) -> Option<Spread> {
        let c = centre.x;
        if mass <= 0.0 || c <= 0.0 || c >= length {
            return None;
        }
        let (from, to) = if c < length / 3.0 {
            (0.0, 3.0 * c)
        } else if c > length * 2.0 / 3.0 {
            (length - 3.0 * (length - c), length)
        } else {
            (0.0, length)
        };
        let h = to - from;
        // ∫ρ = m and ∫ρ (u − from) = m (c − from), for ρ = density + slope (u − from).
        let slope = 12.0 * mass * ((c - from) / h - 0.5) / (h * h);
        let density = mass / h - slope * h / 2.0;
        Some(Spread { from, to, density, slope, offset: Vector3::new(0.0, centre.y, centre.z) })
    }

    /// Mass beyond s (kg) and its first moment about s (kg·m).
    fn beyond(&self, s: f64) -> (f64, f64) {
        if s >= self.to {
            return (0.0, 0.0);
        }
        let start = s.max(self.from);
        let (h, r) = (self.to - start, self.density + self.slope * (start - self.from));
        let mass = h * (r + self.slope * h / 2.0);
        let about_start = h * h * (r / 2.0 + self.slope * h / 3.0);
        (mass, about_start + mass * (start - s))
    }
}

/// Points and weights of Gauss' rule of four points on [a, b].
fn gauss(a: f64, b: f64) -> [(f64, f64); 4] {
    const INNER: (f64, f64) = (0.339_981_043_584_856_3, 0.652_145_154_862_546_1);
    const OUTER: (f64, f64) = (0.861_136_311_594_052_6, 0.347_854_845_137_453_9);
    let (middle, half) = ((a + b) / 2.0, (b - a) / 2.0);
    [(-OUTER.0, OUTER.1), (-INNER.0, INNER.1), INNER, OUTER].map(|(x, w)| (middle + half * x, half * w))
}

#[cfg(test)]
mod tests {
    use super::*;

    const L: f64 = 1.3;
    const EI: f64 = 2.1e4;
    const GJ: f64 = 1.4e4;

    fn beam() -> Beam {
        Beam::slender(Vector3::zeros(), Vector3::new(L, 0.0, 0.0), EI, GJ).expect("a beam")
    }

    fn push(force: [f64; 3], moment: [f64; 3]) -> Wrench {
        Wrench { force: force.into(), moment: moment.into() }
    }

    #[track_caller]
    fn check(got: f64, expected: f64) {
        assert!((got - expected).abs() < 1e-13 * expected.abs(), "{got} against {expected}");
    }

    #[test]
    fn a_cantilever_bends_as_in_the_textbook() {
        let none = Vector3::zeros();
        let by_force = beam().deflection(&push([0.0, 0.0, -700.0], [0.0; 3]), None, &none);
        check(by_force[2], -700.0 * L.powi(3) / (3.0 * EI));
        check(by_force[4], 700.0 * L * L / (2.0 * EI));
        let by_moment = beam().deflection(&push([0.0; 3], [0.0, 0.0, 90.0]), None, &none);
        check(by_moment[1], 90.0 * L * L / (2.0 * EI));
        check(by_moment[5], 90.0 * L / EI);
        let by_torque = beam().deflection(&push([0.0; 3], [90.0, 0.0, 0.0]), None, &none);
        check(by_torque[3], 90.0 * L / GJ);
    }

    #[test]
    fn its_own_weight_bends_it_as_in_the_textbook() {
        let g = Vector3::new(0.0, 0.0, -9.81);
        let even = Link { mass: 60.0, com: Vector3::new(L / 2.0, 0.0, 0.0) };
        let w = 60.0 * 9.81 / L;
        let sag = beam().deflection(&Wrench::default(), Some(&even), &g);
        check(sag[2], -w * L.powi(4) / (8.0 * EI));
        check(sag[4], w * L.powi(3) / (6.0 * EI));
        // A density that falls from w₀ to nothing: w₀ L⁴ / 30 EI.
        let falling = Link { mass: 60.0, com: Vector3::new(L / 3.0, 0.0, 0.0) };
        let sag = beam().deflection(&Wrench::default(), Some(&falling), &g);
        check(sag[2], -2.0 * w * L.powi(4) / (30.0 * EI));
    }

    #[test]
    fn an_offset_centre_twists_and_a_mass_in_front_hangs_on_the_tip() {
        let g = Vector3::new(0.0, 0.0, -9.81);
        let aside = Link { mass: 60.0, com: Vector3::new(L / 2.0, 0.1, 0.0) };
        let sag = beam().deflection(&Wrench::default(), Some(&aside), &g);
        check(sag[3], -60.0 * 9.81 * 0.1 * L / (2.0 * GJ));
        let ahead = Link { mass: 60.0, com: Vector3::new(L + 0.2, 0.0, 0.0) };
        let hung = beam().deflection(&Wrench::default(), Some(&ahead), &g);
        let (f, m) = (60.0 * 9.81, 60.0 * 9.81 * 0.2);
        check(hung[2], -f * L.powi(3) / (3.0 * EI) - m * L * L / (2.0 * EI));
    }

    #[test]
    fn shear_and_stretch_agree_with_timoshenko() {
        let beam = Beam { axial: 3e6, shear: 8e5, ..beam() };
        let pulled = beam.deflection(&push([500.0, 0.0, -700.0], [0.0; 3]), None, &Vector3::zeros());
        check(pulled[0], 500.0 * L / 3e6);
        check(pulled[2], -700.0 * (L.powi(3) / (3.0 * EI) + L / 8e5));
    }

    #[test]
    fn two_planes_and_any_direction() {
        // A flat board that lies along −z of its link, soft when pressed along y.
        let beam = Beam {
            root: Vector3::new(0.0, 0.1, 0.0),
            tip: Vector3::new(0.0, 0.1, -L),
            bending: [9.0 * EI, EI],
            section_y: Vector3::y(),
            ..beam()
        };
        let sag = beam.deflection(&push([300.0, -700.0, 0.0], [0.0; 3]), None, &Vector3::zeros());
        check(sag[1], -700.0 * L.powi(3) / (3.0 * EI));
        check(sag[0], 300.0 * L.powi(3) / (27.0 * EI));
    }

    #[test]
    fn deflections_are_reciprocal() {
        // Maxwell and Betti: the work of load A on the way of B is that of B on the way of A.
        let beam = Beam { axial: 3e6, shear: 8e5, bending: [EI, 2.0 * EI], ..beam() };
        let (a, b) = (push([1.0, 2.0, 3.0], [4.0, -5.0, 6.0]), push([-3.0, 1.0, 2.0], [0.5, 6.0, 1.0]));
        let work = |load: &Wrench, way: [f64; 6]| (0..6).map(|k| load.component(k) * way[k]).sum::<f64>();
        let none = Vector3::zeros();
        check(work(&a, beam.deflection(&b, None, &none)), work(&b, beam.deflection(&a, None, &none)));
    }

    #[test]
    fn invalid_values_are_rejected() {
        assert!(Beam::slender(Vector3::zeros(), Vector3::zeros(), EI, GJ).is_err());
        assert!(Beam::slender(Vector3::zeros(), Vector3::x(), 0.0, GJ).is_err());
        assert!(Beam { section_y: Vector3::x(), ..beam() }.checked().is_err());
    }
}
