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
        self.table(ParametersSummary::OF_OFFSETS, &ParametersSummary::OFFSETS, &summary.offsets(), true);
        self.note(summary.of_offsets());
        if !summary.zero_offsets_apart.is_empty() {
            self.table(ParametersSummary::OF_APART, &ParametersSummary::APART, &summary.apart(), true);
        }
        self.table(
            "Parameters in the convention and the units of the robot file, with 95 % confidence intervals",
            &ParametersSummary::HEAD,
            &summary.rows(),
            true,
        );
    }
}
