//! The effect that is right for a cause of the vocabulary, as someone declares it who knows its place: nonlinear parameters are left free
//! within wide ranges.

use super::cause::Cause;
use super::hidden::Hidden;
use crate::prelude::*;
use truepose_errormodel::History;
use truepose_errormodel::effects::{
    Backlash, Coupling, Drift, Grows, Guideway, Instrument, InstrumentMode, LinkCompliance, Shift, Side,
    Spot, Thermal,
};

impl Hidden {
    /// The right effects; none of a cause that is no row of the vocabulary, and of a payload, which is no effect.
    pub fn right(&self, chain: &Chain) -> Option<Box<dyn AnyEffect>> {
        let (joint, duration, base) = (self.joint, self.duration, Spot::Frame(FrameId::BASE));
        let (lag, lag_range) = (Some(0.05 * duration), Some([0.002 * duration, 0.6 * duration]));
        let (lower, upper) = self.limits;
        let whole = Some([0.0, duration]);
        Some(match self.cause {
            Cause::Creep => {
                JointCompliance { lag_range, ..JointCompliance::creep(joint, 0.05 * duration) }.boxed()
            }
            Cause::Heating => {
                let work = if self.u[5] > 0.5 { History::Work(joint) } else { History::Travel(joint) };
                let of = Thermal::by(Spot::Joint(joint), work, 0.05 * duration);
                Thermal { lag_range, grows: Some(Grows::Motion), ..of }.boxed()
            }
            Cause::Pauses => {
                Thermal { lag_range, ..Thermal::by(base, History::Working(300.0), 0.05 * duration) }.boxed()
            }
            Cause::Gradient => Thermal::gradient(base, "front", "back").boxed(),
            Cause::WholeArm => Thermal::arm("temperature").boxed(),
            Cause::Lubricant => JointCompliance::by_temperature(joint, "temperature", 20.0).boxed(),
            Cause::TwoConstants => Drift {
                time_constant_range: Some([0.01 * duration, 0.2 * duration]),
                second_time_constant: Some(0.5 * duration),
                second_time_constant_range: Some([0.2 * duration, 2.0 * duration]),
                ..Drift::settling(base, [0.0, duration], 0.05 * duration)
            }
            .boxed(),
            Cause::Undone => Shift {
                at_range: whole,
                until: Some(0.7 * duration),
                until_range: whole,
                ..Shift::of(base, 0.3 * duration)
            }
            .boxed(),
            Cause::Settles => Shift {
                at_range: whole,
                settling: lag,
                settling_range: lag_range,
                ..Shift::of(base, 0.3 * duration)
            }
            .boxed(),
            Cause::TiltingBearing => JointCompliance::bearing(joint).boxed(),
            Cause::Refraction => Instrument::of(InstrumentMode::Refraction).boxed(),
            Cause::Sight => Instrument::of(InstrumentMode::Sight).boxed(),
            Cause::Bridge => Guideway::sagging(joint, [lower, upper], 2).boxed(),
            Cause::Ram => {
                let length = -lower + 0.3 * (upper - lower);
                let ram_range = Some([-lower, -lower + 2.0 * (upper - lower)]);
                LinkCompliance { ram_range, ..LinkCompliance::ram(joint, length, false) }.boxed()
            }
            Cause::Wear => {
                let [middle, half] = self.worn();
                let between = Some([middle - half, middle + half]);
                Backlash { between, ..Backlash::of(joint, Side::Approach) }.boxed()
            }
            Cause::FourBar => {
                let driver = JointId(joint.0 - 1);
                let (crossed, offset) = self.crank(chain);
                let offset_range = Some([offset - 0.5, offset + 0.5]);
                Coupling { offset_range, ..Coupling::linkage(joint, driver, offset, crossed) }.boxed()
            }
            Cause::Spring => {
                let (offset, ratio_range) = (self.longest(), Some([0.1, 0.98]));
                let offset_range = Some([offset - 0.8, offset + 0.8]);
                JointCompliance {
                    offset_range,
                    ratio_range,
                    ..JointCompliance::counterbalance(joint, offset, 0.7)
                }
                .boxed()
            }
            _ => return None,
        })
    }
}
