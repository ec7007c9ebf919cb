//! What a fit is made from.

use crate::data::Data;
use crate::robot::Robot;
use truepose_errormodel::AnyEffect;
use truepose_workflow::Inputs;

/// A robot with rows and declared effects.
pub fn inputs(robot: &Robot, data: &Data, effects: Vec<Box<dyn AnyEffect>>) -> Inputs {
    Inputs {
        chain: (*robot.chain).clone(),
        details: robot.details.clone(),
        beside: (robot.beside.rules, (*robot.beside.surroundings).clone()),
        undeclared: robot.undeclared,
        effects,
        data: data.data.clone(),
        info: data.info.clone(),
    }
}
