//! Points outside of the data of the fit, in words with the numbers that decide.

use truepose_errormodel::{Beyond, Channel, FittedModel, Interval};
use truepose_kinematics::{Chain, Conditions, JointKind, Load};

/// # Errors
/// In words, where something is beyond: each input with its value and the range of the data.
pub(super) fn outside(
    fitted: &FittedModel,
    channels: &[Channel],
    conditions: &Conditions,
    beyond: &[(Beyond, f64)],
) -> Result<(), String> {
    if beyond.is_empty() {
        return Ok(());
    }
    let one = |&(what, by): &(Beyond, f64)| words(fitted, channels, conditions, (what, by));
    let list: Vec<String> = beyond.iter().map(one).collect();
    Err(format!("it is outside of the data of the fit: {}", list.join(", ")))
}

fn words(
    fitted: &FittedModel,
    channels: &[Channel],
    conditions: &Conditions,
    (what, by): (Beyond, f64),
) -> String {
    let domain = &fitted.domain;
    match what {
        Beyond::Joint(k) => {
            let chain = fitted.chain();
            let joint = chain.joint(chain.movable()[k]);
            let (scale, unit) =
                if joint.kind == JointKind::Prismatic { (1e3, " mm") } else { (1f64.to_degrees(), "°") };
            match domain.joints.get(k).filter(|_| is_controllers(chain, &conditions.joints, k)) {
                Some(range) => {
                    format!("{} = {}", joint.name, against(conditions.joints[k], range, (scale, unit)))
                }
                None => format!("{}, by {}{unit}", joint.name, number(scale * by)),
            }
        }
        Beyond::Payload => {
            let mass = match conditions.load {
                Load::Payload(payload) => payload.mass,
                Load::None | Load::Wrench(_) => 0.0,
            };
            match &domain.payload {
                Some(range) => format!("payload = {}", against(mass, range, (1.0, " kg"))),
                None => format!("payload = {} kg; none in the data", number(mass)),
            }
        }
        Beyond::Time => format!("time, by {} s", number(by)),
        Beyond::Channel(k) => match channels.get(k) {
            Some(channel) => {
                format!("{}, by {} {}", channel.name, number(by), channel.unit).trim_end().to_owned()
            }
            None => "a channel".into(),
        },
        Beyond::Leverage => {
            format!("the combination of joints (standard deviation {} × the largest in the data)", number(by))
        }
    }
}

/// Whether the controller shows this joint's value as the fit has it: no coupling changes it.
fn is_controllers(chain: &Chain, joints: &[f64], k: usize) -> bool {
    let mut shown = joints.to_vec();
    chain.joints_to_controller(&mut shown);
    (shown[k] - joints[k]).abs() < 1e-12
}

fn against(value: f64, range: &Interval, (scale, unit): (f64, &str)) -> String {
    let [value, from, to] = [value, range.lower, range.upper].map(|x| number(scale * x));
    format!("{value}{unit} (data: {from}{unit} to {to}{unit})")
}

/// With one decimal, or with two significant digits where that is nothing.
fn number(value: f64) -> String {
    match value.abs() < 0.95 && value != 0.0 {
        true => format!("{value:.3}").trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => format!("{value:.1}").trim_end_matches(".0").to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::{Domain, ErrorModel};
    use truepose_kinematics::nalgebra::{DMatrix, Vector3};
    use truepose_kinematics::{Payload, samples};

    fn fitted() -> FittedModel {
        let chain = samples::pps();
        let joints = chain.movable().len();
        let model = ErrorModel::new(chain, Vec::new()).expect("a model");
        let mut fitted = FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0)).expect("a fit");
        fitted.domain = Domain {
            joints: vec![Interval { lower: -0.2, upper: 0.25 }; joints],
            payload: Some(Interval { lower: 0.0, upper: 5.0 }),
            ..Domain::default()
        };
        fitted
    }

    #[test]
    fn a_point_outside_is_refused_with_the_numbers_that_decide() {
        let fitted = fitted();
        let load = Load::Payload(Payload { mass: 6.5, com: Vector3::zeros() });
        let joints = [0.3, 0.0, 0.0, -0.5, 0.0, 0.0];
        let conditions = Conditions::at(fitted.chain(), &joints).with_load(load);
        let all = [
            (Beyond::Joint(0), 0.05),
            (Beyond::Joint(3), 0.3),
            (Beyond::Payload, 1.5),
            (Beyond::Leverage, 3.21),
        ];
        assert_eq!(
            outside(&fitted, &[], &conditions, &all).expect_err("outside"),
            "it is outside of the data of the fit: d1 = 300 mm (data: -200 mm to 250 mm), theta = -28.6° (data: -11.5° to 14.3°), \
             payload = 6.5 kg (data: 0 kg to 5 kg), the combination of joints (standard deviation 3.2 × the largest in the data)"
        );
        assert_eq!(outside(&fitted, &[], &conditions, &[]), Ok(()));
    }
}
