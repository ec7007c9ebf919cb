//! `[[couplings]]` of a robot description.

use crate::IoError;
use crate::frame_names::joint_called;
use crate::nearest::meant;
use crate::toml_tree::Table;
use truepose_kinematics::{Chain, Coupling, JointId};

/// The couplings that a description declares between these joints; every error joins the others.
pub(super) fn read(
    root: &Table<'_>,
    chain: &Chain,
    errors: &mut Vec<IoError>,
) -> Result<Vec<Coupling>, IoError> {
    let Some(value) = root.get("couplings") else { return Ok(Vec::new()) };
    let mut couplings: Vec<Coupling> = Vec::new();
    for table in value.tables("couplings")? {
        match coupling(&table, chain) {
            Ok(found) if couplings.iter().any(|c| (c.joint, c.driver) == (found.joint, found.driver)) => {
                errors.push(
                    table.error("the same two joints are coupled a second time; remove one of the two"),
                );
            }
            Ok(found) => couplings.push(found),
            Err(error) => errors.push(error),
        }
    }
    Ok(couplings)
}

fn coupling(table: &Table<'_>, chain: &Chain) -> Result<Coupling, IoError> {
    table.only(&["joint", "driver", "factor"])?;
    let (joint, driver) = (joint(table, "joint", chain)?, joint(table, "driver", chain)?);
    let value = table.require("driver")?;
    if joint == driver {
        return Err(
            value.error("a joint is not coupled to itself; `driver` is the joint whose value is added")
        );
    }
    if chain.joint(joint).kind != chain.joint(driver).kind {
        return Err(value.error("a revolute and a prismatic joint cannot be coupled"));
    }
    let factor = table.get("factor").map_or(Ok(1.0), |value| value.number())?;
    Ok(Coupling { joint, driver, factor })
}

fn joint(table: &Table<'_>, key: &str, chain: &Chain) -> Result<JointId, IoError> {
    let value = table.require(key)?;
    let name = value.string()?;
    let moves = joint_called(chain, name).filter(|&joint| chain.joint(joint).moves());
    moves.ok_or_else(|| {
        let names = chain.movable().iter().map(|&joint| chain.joint(joint).name.as_str());
        let hint = meant(name, names.clone());
        let known: Vec<&str> = names.collect();
        value
            .error(format!("the robot has no moving joint `{name}`{hint} (its joints: {})", known.join(", ")))
    })
}
