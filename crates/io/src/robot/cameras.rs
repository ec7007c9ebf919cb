//! `[[cameras]]` of a robot description: what looks at the robot or from it, and what is known of it.

use super::names::cell_problem;
use crate::toml_tree::{Table, Value};
use crate::{IoError, Unit};
use truepose_errormodel::Landmark;
use truepose_errormodel::observation::Camera;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

const KEYS: [&str; 13] =
    ["name", "mount", "xyz", "rpy", "known", "fx", "fy", "cx", "cy", "distortion", "size", "free", "sd"];

pub(super) fn read(table: &Table<'_>, length: &Unit, angle: &Unit) -> Result<Landmark, IoError> {
    table.only(&KEYS)?;
    let name = table.require("name")?;
    let text = name.string()?;
    if let Some(problem) = cell_problem(text) {
        return Err(name.error(problem));
    }
    let mount = table.get("mount").map(|mount| mount.string().map(String::from)).transpose()?;
    // A camera in the cell looks at targets on the tool.
    let mount = mount.filter(|word| word != "base");
    let positive = |key: &str| -> Result<f64, IoError> {
        let value = table.require(key)?;
        match value.number()? {
            number if number > 0.0 => Ok(number),
            _ => Err(value.error(format!("`{key}` of camera `{text}` has to be above zero, px"))),
        }
    };
    let (fx, fy) = (positive("fx")?, positive("fy")?);
    let at = |key: &str| table.require(key).and_then(|value| value.number());
    let intrinsics = [fx, fy, at("cx")?, at("cy")?];
    let distortion =
        table.get("distortion").map(|value| coefficients(&value)).transpose()?.unwrap_or_default();
    let size = table.get("size").map(|value| value.numbers::<2>()).transpose()?;
    let xyz = table.get("xyz").map(|xyz| xyz.numbers::<3>()).transpose()?;
    let rpy = table.get("rpy").map(|rpy| rpy.numbers::<3>()).transpose()?;
    let place = match (xyz, rpy) {
        (Some(xyz), Some(rpy)) => {
            let [r, p, y] = rpy.map(|v| angle.to_si(v));
            let turn = Pose::rot(2, y) * Pose::rot(1, p) * Pose::rot(0, r);
            Some(Pose::new(turn.rotation, Vector3::from(xyz.map(|v| length.to_si(v)))))
        }
        (None, None) => None,
        _ => return Err(name.error(format!("camera `{text}` needs `xyz` and `rpy`, or neither"))),
    };
    let known = table.get("known").map(|known| known.boolean()).transpose()?.unwrap_or(place.is_some());
    if known && place.is_none() {
        return Err(name.error(format!("camera `{text}` is known, but has no `xyz` and `rpy`")));
    }
    let free = match table.get("free") {
        None => Vec::new(),
        Some(free) => free
            .elements("an array of words")?
            .iter()
            .map(|word| word.word(&[("intrinsics", ())]))
            .collect::<Result<_, _>>()?,
    };
    let sd = match table.get("sd") {
        None => None,
        Some(sd) if sd.number()? <= 0.0 => {
            return Err(sd.error(format!("`sd` of camera `{text}` has to be above zero, px")));
        }
        Some(sd) => Some(sd.number()?),
    };
    let camera = Camera { place, known, intrinsics, distortion, free_intrinsics: !free.is_empty(), size };
    let position = place.map(|place| place.translation);
    Ok(Landmark { name: text.into(), position, known, observed: Some(Box::new(camera)), mount, sd })
}

/// k1, k2, p1, p2, k3, of which the last ones may be left out.
fn coefficients(value: &Value<'_>) -> Result<[f64; 5], IoError> {
    let given = value.elements("an array of 0 to 5 numbers: k1, k2, p1, p2, k3")?;
    if given.len() > 5 {
        return Err(value.error("`distortion` has 5 numbers at the most: k1, k2, p1, p2, k3"));
    }
    let mut all = [0.0; 5];
    for (number, value) in all.iter_mut().zip(&given) {
        *number = value.number()?;
    }
    Ok(all)
}
