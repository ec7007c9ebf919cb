//! How large a model may be: worked out from the parameters of its effects, before anything is allocated for them.

/// Largest number of unknowns of a model.
///
/// A fit holds about nine matrices of n × n numbers at once (measured: 267 MB at n = 2003), and takes a time that grows with n³ (15 s
/// there, on one thread): a gigabyte and minutes at this bound. The paper's model has 318 unknowns.
pub const MOST_UNKNOWNS: usize = 4096;

/// n × n matrices of a fit.
const MATRICES: f64 = 9.0;

/// Memory that a fit of so many unknowns takes.
pub(crate) fn memory(unknowns: usize) -> String {
    let gigabytes = MATRICES * 8.0 * (unknowns as f64).powi(2) * 1e-9;
    if gigabytes < 1e6 { format!("{gigabytes:.1} GB") } else { format!("{gigabytes:.1e} GB") }
}

#[cfg(test)]
mod tests {
    use crate::effects::{Basis, Expansion, Factor, Geometric, Input, Place, Polynomial, Transmission};
    use crate::{AnyEffect, ErrorModel};
    use truepose_kinematics::{Axis, FrameId, JointId, samples};

    fn refused(effect: impl AnyEffect + 'static) -> String {
        effect.validate(&samples::ur10()).unwrap_err().to_string()
    }

    fn product(basis: &Basis, times: usize) -> Expansion {
        let factor = Factor { of: Input::Joint(JointId(1)), basis: basis.clone() };
        let components = vec![Axis::Tx, Axis::Rz];
        Expansion { at: Place::Frame { frame: FrameId(0), components }, factors: vec![factor; times] }
    }

    #[test]
    fn what_is_too_large_is_refused_with_its_count_and_its_memory() {
        let waves = Transmission { harmonics: (1..=10_000).collect(), ..Transmission::of(JointId(1), 1.0) };
        assert_eq!(
            refused(waves),
            "effect `transmission` has 20000 unknowns, whose fit would take 28.8 GB; at most 4096 are supported (1.2 GB)"
        );
        let pieces = Basis::Spline { lower: -1.0, upper: 1.0, pieces: 317, degree: 3 };
        assert!(refused(product(&pieces, 2)).starts_with("effect `expansion` has 204800 unknowns, "));
        // A product that no integer holds.
        let many = refused(product(&pieces, 30));
        assert!(many.contains(" GB; at most 4096"), "{many}");
        let repeated = Basis::Powers(vec![1; 5000]);
        assert!(refused(product(&repeated, 1)).starts_with("effect `expansion` has 10000 unknowns, "));
        let polynomial: Polynomial = serde_json::from_str(
            r#"{"degree": 12, "wrench": ["fx", "fy", "fz", "mx", "my", "mz"], "wrench_degree": 12}"#,
        )
        .unwrap();
        assert!(refused(polynomial).starts_with("effect `polynomial` has "));
    }

    #[test]
    fn a_model_of_many_effects_is_refused_with_its_count() {
        let chain = samples::ur10();
        let one = product(&Basis::Spline { lower: -1.0, upper: 1.0, pieces: 997, degree: 3 }, 1);
        let effects: Vec<Box<dyn AnyEffect>> =
            (0..3).map(|_| -> Box<dyn AnyEffect> { Box::new(one.clone()) }).collect();
        assert_eq!(
            ErrorModel::new(chain.clone(), effects).unwrap_err().to_string(),
            "the model has 6000 unknowns, whose fit would take 2.6 GB; at most 4096 are supported (1.2 GB)"
        );
        assert!(
            ErrorModel::new(
                chain,
                vec![Box::new(one.clone()), Box::new(one), Box::new(Geometric::default())]
            )
            .is_ok()
        );
    }
}
