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

    fn meaning(&self, place: &Place) -> String {
        match (place.level, &place.mode) {
            (Some(level), _) => format!(
                "No effect explains these rows, and more of them declare {level} kg than by chance would. Check the log of loads, and how \
                 this load was fastened."
            ),
            (None, Some(_)) => "No effect explains these rows, and more of them lie close together in the record than by chance would. Check \
                                what was different then: fixture, tool, instrument."
                .into(),
            _ => "No repeatable effect explains these rows. Check the instrument's log.".into(),
        }
    }
}
