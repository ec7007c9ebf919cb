//! Single rows that no repeatable effect explains: not a hypothesis of the screen, but reported beside those.

use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;

/// Rows that are kept out. They are judged by their residuals in every fit, so that there is no variant to screen.
#[derive(Debug)]
pub(crate) struct Outlying;

impl Hypothesis for Outlying {
    fn family(&self) -> Family {
        Family::Outlier
    }

    fn variants(&self, _: &Setting<'_>) -> Vec<Variant> {
        Vec::new()
    }

    fn meaning(&self, _: &Place) -> String {
        "No repeatable effect explains these rows. Check the instrument's log.".into()
    }
}
