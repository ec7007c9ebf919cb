//! Component errors as functions of one joint each, interpolated linearly.

use truepose_errormodel::GeneralizedErrors;
use truepose_kinematics::{Chain, JointId, Site};

/// Errors that come with one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorTable {
    /// The joint.
    pub joint: JointId,
    /// Its values, ascending, rad or m.
    pub at: Vec<f64>,
    /// Which components move with it.
    pub sites: Vec<Site>,
    /// Change from the reference, one column a site, m or rad.
    pub columns: Vec<Vec<f64>>,
}

/// The tables of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorTables {
    /// The joints at which the constants hold, rad or m.
    pub reference: Vec<f64>,
    /// All errors at the reference, constant ones included; sites without an error are left out.
    pub constant: Vec<(Site, f64)>,
    /// One a joint with which anything moves.
    pub tables: Vec<ErrorTable>,
}

impl ErrorTables {
    /// The generalized errors at these joints, as the tables have them.
    pub fn errors(&self, chain: &Chain, joints: &[f64]) -> GeneralizedErrors {
        let mut errors = GeneralizedErrors::zero(chain);
        for &(site, value) in &self.constant {
            errors.add(site, value);
        }
        for (table, more) in self.tables.iter().zip(self.by_joint(chain, joints)) {
            table.sites.iter().for_each(|&site| errors.add(site, more.get(site)));
        }
        errors
    }

    /// The change that each table has at these joints.
    pub(super) fn by_joint(&self, chain: &Chain, joints: &[f64]) -> Vec<GeneralizedErrors> {
        let one = |table: &ErrorTable| {
            let mut errors = GeneralizedErrors::zero(chain);
            let q = chain.coordinate(table.joint).and_then(|k| joints.get(k)).copied().unwrap_or(0.0);
            let above = table.at.partition_point(|&v| v <= q).clamp(1, table.at.len().max(2) - 1);
            let (Some(&low), Some(&high)) = (table.at.get(above - 1), table.at.get(above)) else {
                return errors;
            };
            let share = if high > low { ((q - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
            for (&site, column) in table.sites.iter().zip(&table.columns) {
                errors.add(site, column[above - 1] + share * (column[above] - column[above - 1]));
            }
            errors
        };
        self.tables.iter().map(one).collect()
    }
}
