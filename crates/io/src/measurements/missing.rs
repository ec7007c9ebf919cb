//! What to do about columns that a table lacks: all of them at once.

use super::columns::{Role, joint_names, joint_quantity};
use super::header::{Header, Needs};
use crate::IoError;
use crate::nearest::{listed, meant};
use truepose_kinematics::Chain;

impl Header {
    /// What columns are perhaps, as an error behind others; none where there is nothing to propose.
    pub(super) fn proposed(&self) -> Option<IoError> {
        let text = self.proposal.text();
        (!text.is_empty()).then(|| IoError::line(&self.file, self.line, format!("the columns{text}")))
    }

    /// No position, or nothing measured at all.
    pub(super) fn nothing_measured(&self, needs: Needs) -> String {
        let what = if needs.position { "a position" } else { "anything measured" };
        let (columns, proposal) = (self.listed(), self.proposal.text());
        format!("no columns hold {what}; add `x[mm]`, `y[mm]`, `z[mm]` (columns here: {columns}){proposal}")
    }

    /// Joints without a column.
    pub(super) fn missing_joints(&self, chain: &Chain, found: &[Option<usize>]) -> String {
        let missing: Vec<(usize, &str)> = joint_names(chain)
            .enumerate()
            .filter(|(k, _)| found[*k].is_none() && chain.is_commanded(*k))
            .collect();
        let (columns, proposal) = (self.listed(), self.proposal.text());
        if let [(k, name)] = missing[..] {
            let units: Vec<String> =
                joint_quantity(chain, k).units().take(2).map(|unit| format!("`{name}[{unit}]`")).collect();
            let others = self
                .columns
                .iter()
                .filter(|column| matches!(column.role, Role::Channel(_)))
                .map(|column| column.name.as_str());
            let hint = meant(name, others).replace("did you mean", "is it called");
            let units = units.join(" or ");
            // A mapping says the same, and more.
            let hint = if proposal.is_empty() { hint } else { String::new() };
            return format!(
                "joint `{name}` has no column{hint}; add {units} (columns here: {columns}){proposal}"
            );
        }
        let names: Vec<String> = missing.iter().map(|(_, name)| format!("`{name}`")).collect();
        format!(
            "joints {} have no columns (columns here: {columns}){proposal}",
            listed(names.iter().map(String::as_str))
        )
    }
}
