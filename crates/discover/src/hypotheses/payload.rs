//! Declared payloads that are wrong at one level.

use crate::data::payload;
use crate::hypotheses::change::Change;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::AnyEffect;

/// More levels than this are no levels but a continuous quantity.
const MOST_LEVELS: usize = 12;

/// The payload that some rows declare is another one.
#[derive(Debug)]
pub(crate) struct WrongPayload;

impl Hypothesis for WrongPayload {
    fn family(&self) -> Family {
        Family::Payload
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let levels = payload::levels(setting.data);
        if levels.len() > MOST_LEVELS {
            return Vec::new();
        }
        let wrong = |level: f64| Variant {
            // Units of the file leave a rounding error in the last digits.
            place: Place { level: Some((level * 1e6).round() * 1e-6), ..Place::default() },
            change: Change::CorrectLoad { level, mass: level, deviation: 0.0 },
        };
        levels.into_iter().map(wrong).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The payload declared as {} kg does not fit. Check the declared mass.",
            place.level.unwrap_or_default()
        )
    }

    fn view(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site([Driver::Time])
    }
}
