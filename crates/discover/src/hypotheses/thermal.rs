//! What follows a temperature, at once or late.

use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use truepose_errormodel::effects::{Grows, Spot, Thermal};
use truepose_kinematics::FrameId;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let chain = setting.chain;
    for (k, channel) in setting.data.schema.channels.iter().enumerate() {
        let (Some([lower, upper]), true) = (setting.channel_range(k), channel.temperature) else { continue };
        // A derived column says in its name what it is derived from.
        let (source, lag) = match channel.name.split_once("~lag=") {
            Some((source, lag)) => (source, lag.parse().ok()),
            None => (channel.name.as_str(), None),
        };
        let reference = 0.5 * (lower + upper);
        let mut put = |spot: Spot, grows: Option<Grows>| {
            // Which temperature a slide was adjusted at nobody says.
            let offset = grows == Some(Grows::Scale);
            let effect = Thermal { grows, reference, offset, lag, ..Thermal::of(spot, source) };
            let place = Place::spot(chain, spot).following(source);
            all.push(Candidate::new(Family::Thermal, place, effect));
        };
        for &joint in chain.movable() {
            for grows in [Grows::Length, Grows::Scale, Grows::Motion] {
                put(Spot::Joint(joint), Some(grows));
            }
        }
        put(Spot::Frame(FrameId::BASE), None);
        put(Spot::Frame(chain.tool_frame()), None);
    }
}
