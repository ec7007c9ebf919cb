//! Where encoder gains are looked for, and what a finding means.

use crate::EncoderGain;
use truepose_discover::{Driver, Family, Hypothesis, Place, Setting, TraceView, Variant};
use truepose_errormodel::{AnyEffect, Effect};

/// Some joint's encoder reads a constant fraction too little.
#[derive(Debug)]
pub struct EncoderGains;

impl Hypothesis for EncoderGains {
    fn family(&self) -> Family {
        Family::Other(EncoderGain::FAMILY)
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let moved = setting.chain.movable().iter().filter(|&&joint| setting.range(joint).is_some());
        moved.map(|&joint| Variant::new(Place::joint(setting.chain, joint), EncoderGain { joint })).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The encoder of {} reads a constant fraction off: check its line count and gear ratio.",
            place.part()
        )
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(self.drivers(place, effects))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_discover::Library;

    #[test]
    fn a_library_with_it_knows_its_word_and_without_it_does_not() {
        let library = Library::standard().with(EncoderGains);
        let family = EncoderGains.family();
        assert_eq!(library.family("acme/encoder_gain"), Some(family));
        assert_eq!(library.clone().without(family), Library::standard());
        assert_ne!(library, Library::standard());
    }
}
