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

/// Stretches of the record in which a label may be wrong: runs of quarters of the time, s; none of data without a time.
fn stretches(setting: &Setting<'_>) -> impl Iterator<Item = [f64; 2]> {
    const PARTS: usize = 4;
    let range = setting.time_range();
    range.into_iter().flat_map(|[first, last]| {
        // The last row belongs to the last part.
        let at = move |k: usize| first + (last - first) * (1.0 + 1e-9) * k as f64 / PARTS as f64;
        let runs = (0..PARTS).flat_map(|from| (from + 1..=PARTS).map(move |to| (from, to)));
        runs.filter(|&(from, to)| to - from < PARTS).map(move |(from, to)| [at(from), at(to)])
    })
}

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
        let wrong = |level: f64, during: Option<[f64; 2]>| Variant {
            place: Place {
                level: Some(payload::rounded(level)),
                mode: during.map(|_| "stretch".into()),
                ..Place::default()
            },
            change: Change::CorrectLoad { level, mass: level, deviation: 0.0, during },
        };
        let whole = levels.iter().map(|&level| wrong(level, None));
        let parts = levels.iter().flat_map(|&level| {
            let part = move |during: &[f64; 2]| payload::is_part(setting.data, level, *during);
            stretches(setting).filter(part).map(move |during| wrong(level, Some(during)))
        });
        whole.chain(parts).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        let level = place.level.unwrap_or_default();
        match place.mode {
            Some(_) => format!(
                "The payload declared as {level} kg was another one for a stretch of the poses. Check the log of loads at that time."
            ),
            None => format!("The payload declared as {level} kg does not fit. Check the declared mass."),
        }
    }

    fn view(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site([Driver::Time])
    }
}
