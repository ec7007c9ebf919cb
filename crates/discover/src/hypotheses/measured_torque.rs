//! A joint that yields with its measured torque: a channel of its motor's current or of a torque sensor.
//!
//! Which channel is whose is read from its name, so that there is at most one candidate for each channel: it ends in the joint's name, or in
//! the joint's number among those that move (`tau2`, `current_j2`). It is a torque, a force or a current by its unit or its name.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::effects::JointCompliance;
use truepose_errormodel::{AnyEffect, Channel, is_derived};
use truepose_kinematics::{Chain, JointId};

/// A joint yields with the torque that is measured in it. The sign is the sensor's, so that none is demanded.
#[derive(Debug)]
pub(crate) struct OfMeasuredTorque;

impl Hypothesis for OfMeasuredTorque {
    fn family(&self) -> Family {
        Family::JointCompliance
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let channels = setting.data.schema.channels.iter().enumerate();
        let torques =
            channels.filter(|(k, channel)| is_torque(channel) && setting.channel_range(*k).is_some());
        let of = |(_, channel): (usize, &Channel)| {
            let joint = joint_of(chain, &channel.name)?;
            let place = Place::joint(chain, joint).following(&channel.name);
            Some(Variant::new(place, JointCompliance::measured(joint, &channel.name)))
        };
        torques.filter_map(of).collect()
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The deflection of {} is proportional to its measured torque ({}): stiffness of gear, belt or drive.",
            place.part(),
            place.channel.as_deref().unwrap_or("a channel")
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Wrench]
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(place.channel.clone().map(Driver::Channel))
    }
}

/// Whether a channel is a torque, force or current, by its unit or its name.
fn is_torque(channel: &Channel) -> bool {
    const UNITS: [&str; 8] = ["N*m", "Nm", "N·m", "kN*m", "N", "kN", "A", "mA"];
    const NAMES: [&str; 6] = ["tau", "torque", "moment", "current", "effort", "force"];
    let name = channel.name.to_lowercase();
    !channel.temperature
        && !is_derived(&channel.name)
        && (UNITS.contains(&channel.unit.as_str()) || NAMES.iter().any(|word| name.starts_with(word)))
}

/// The joint whose name ends the channel's name, the longest such name; else the one whose number does.
fn joint_of(chain: &Chain, channel: &str) -> Option<JointId> {
    let name = |joint: &JointId| chain.joint(*joint).name.as_str();
    let named = chain.movable().iter().filter(|joint| channel.ends_with(name(joint)));
    let digits = channel.trim_start_matches(|c: char| !c.is_ascii_digit());
    let number =
        || digits.parse::<usize>().ok().and_then(|number| chain.movable().get(number.checked_sub(1)?));
    named.max_by_key(|joint| name(joint).len()).or_else(number).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_torque_belongs_to_the_joint_in_its_name() {
        let chain = samples::ur10();
        for (channel, joint) in [("tau2", Some(2)), ("current_j5", Some(5)), ("tau", None), ("tau9", None)] {
            assert_eq!(joint_of(&chain, channel), joint.map(JointId), "{channel}");
        }
        let channel =
            |name: &str, unit: &str| Channel { name: name.into(), unit: unit.into(), temperature: false };
        assert!(is_torque(&channel("m2", "N*m")) && is_torque(&channel("tau2", "1")));
        assert!(!is_torque(&channel("humidity2", "%")));
        assert!(!is_torque(&Channel { temperature: true, ..channel("tau2", "degC") }));
    }
}
