//! How commands are sought.

use crate::CompensateError;
use truepose_kinematics::ToolId;

/// Where the directions of approach come from, on which backlash and its kind depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Approach {
    /// The caller states the approach of the coming move in the conditions.
    #[default]
    Stated,
    /// Every joint moves straight from the seed to the command: its side is the sign of (command − seed).
    /// Without a seed, and for a joint that stays where it is, the conditions' direction holds.
    FromSeed,
}

/// Tolerances and limits of the search for a command.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensatorOptions {
    /// Distance from the desired position at which a command is good, m.
    pub position_tolerance: f64,
    /// Angle from the desired orientation at which a command is good, rad.
    pub orientation_tolerance: f64,
    /// Most evaluations of the exact model from one start.
    pub rounds: usize,
    /// How many starts are tried when the seed leads nowhere, or there is none.
    pub starts: usize,
    /// Where the directions of approach come from.
    pub approach: Approach,
    /// The tool that is brought to its target; joints that do not carry it stay where the seed has them.
    pub tool: ToolId,
    /// Poses are those in the axes of this tool, where it really is, and not in the measurement frame: one hand is brought to the other. Joints that carry it stay
    /// where the seed has them, and a seed is needed.
    pub relative_to: Option<ToolId>,
    /// Joints that stay where the seed has them, whatever their limits, by their places among the moving joints: a track, a positioner. A seed is needed.
    pub hold: Vec<usize>,
}

impl Default for CompensatorOptions {
    fn default() -> Self {
        CompensatorOptions {
            position_tolerance: 1e-10,
            orientation_tolerance: 1e-10,
            rounds: 80,
            starts: 24,
            approach: Approach::Stated,
            tool: ToolId::FIRST,
            relative_to: None,
            hold: Vec::new(),
        }
    }
}

impl CompensatorOptions {
    /// Checks that the numbers make sense.
    ///
    /// # Errors
    /// [`CompensateError::Option`] names the one that does not.
    pub fn validate(&self) -> Result<(), CompensateError> {
        let tolerances = [
            ("position_tolerance", self.position_tolerance),
            ("orientation_tolerance", self.orientation_tolerance),
        ];
        for (option, value) in tolerances {
            // Below this, round-off of a chain of metres decides.
            if !value.is_finite() || value < 1e-13 {
                return Err(CompensateError::Option { option, value, need: "finite and at least 1e-13" });
            }
        }
        for (option, count, most) in [("rounds", self.rounds, 10_000), ("starts", self.starts, 256)] {
            if count > most || (count == 0 && option == "rounds") {
                let need = if option == "rounds" { "1 to 10 000" } else { "0 to 256" };
                return Err(CompensateError::Option { option, value: count as f64, need });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_values_are_rejected() {
        assert!(CompensatorOptions::default().validate().is_ok());
        let bad = [
            CompensatorOptions { position_tolerance: 0.0, ..Default::default() },
            CompensatorOptions { orientation_tolerance: f64::NAN, ..Default::default() },
            CompensatorOptions { rounds: 0, ..Default::default() },
            CompensatorOptions { starts: 1000, ..Default::default() },
        ];
        for options in bad {
            assert!(matches!(options.validate(), Err(CompensateError::Option { .. })), "{options:?}");
        }
    }
}
