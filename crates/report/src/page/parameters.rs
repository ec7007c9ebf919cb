//! The part of a page with the parameters of the robot.

use super::Page;
use crate::ParametersSummary;

impl Page {
    /// The part, where there is a table.
    pub(crate) fn parameters(&mut self, summary: Option<&ParametersSummary>) {
        let Some(summary) = summary else { return };
        self.section("Parameters of the robot");
        if let Some(why) = &summary.absent {
            self.text(&format!("There is no table of parameters: {why}."));
            return;
        }
        self.note(&summary.note());
        self.table(
            "Zero offsets of the joints, to be added to the reading of each; valid together with the parameters above",
            &ParametersSummary::OFFSETS,
            &summary.offsets(),
            true,
        );
        self.table(
            "Parameters in the convention and the units of the robot file, with 95 % confidence intervals",
            &ParametersSummary::HEAD,
            &summary.rows(),
            true,
        );
    }
}
