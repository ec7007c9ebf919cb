//! `[[landmarks]]` and `[[distances]]` of a robot description: what the robot touches, and what is known of it.

use super::names::cell_problem;
use crate::nearest::{listed, meant};
use crate::toml_tree::{Table, Value};
use crate::{IoError, Unit};
use truepose_errormodel::{KnownDistance, Landmark, Surroundings};

/// Kinds of landmarks: what holds a target at one point.
const KINDS: [(&str, ()); 4] = [("point", ()), ("socket", ()), ("sphere", ()), ("cone", ())];

pub(super) fn read(root: &Table<'_>, length: &Unit) -> Result<Surroundings, IoError> {
    let mut all = Surroundings::default();
    let landmarks = root.get("landmarks").map(|value| value.tables("[[landmarks]]")).transpose()?;
    for table in landmarks.iter().flatten() {
        let found = landmark(table, length)?;
        if all.landmarks.iter().any(|other| other.name == found.name) {
            return Err(table.error(format!("landmark `{}` stands twice", found.name)));
        }
        all.landmarks.push(found);
    }
    let distances = root.get("distances").map(|value| value.tables("[[distances]]")).transpose()?;
    for table in distances.iter().flatten() {
        let found = distance(table, length, &all.landmarks)?;
        all.distances.push(found);
    }
    Ok(all)
}

fn landmark(table: &Table<'_>, length: &Unit) -> Result<Landmark, IoError> {
    table.only(&["name", "kind", "xyz", "known"])?;
    let name = table.require("name")?;
    let text = name.string()?;
    if let Some(problem) = cell_problem(text) {
        return Err(name.error(problem));
    }
    table.get("kind").map(|kind| kind.word(&KINDS)).transpose()?;
    let xyz = table.get("xyz").map(|xyz| xyz.numbers::<3>()).transpose()?;
    let position = xyz.map(|xyz| xyz.map(|v| length.to_si(v)).into());
    let said = table.get("known").map(|known| known.boolean()).transpose()?;
    let known = said.unwrap_or(position.is_some());
    if known && position.is_none() {
        return Err(name.error(format!("landmark `{text}` is known, but has no `xyz`")));
    }
    Ok(Landmark { name: text.into(), position, known })
}

fn distance(table: &Table<'_>, length: &Unit, landmarks: &[Landmark]) -> Result<KnownDistance, IoError> {
    table.only(&["between", "value", "sd"])?;
    let between = table.require("between")?;
    let names = between.elements("an array of the names of two landmarks")?;
    let [first, second] = names.as_slice() else {
        return Err(between.error("`between` names two landmarks"));
    };
    let pair = [number(first, landmarks)?, number(second, landmarks)?];
    if pair[0] == pair[1] {
        return Err(between.error("`between` names one landmark twice"));
    }
    let value = table.require("value")?;
    let metres = length.to_si(value.number()?);
    if metres <= 0.0 {
        return Err(value.error("a distance is above zero"));
    }
    let sd = match table.get("sd") {
        Some(sd) if sd.number()? < 0.0 => return Err(sd.error("a standard deviation is not below zero")),
        Some(sd) => length.to_si(sd.number()?),
        None => 0.0,
    };
    Ok(KnownDistance { between: pair, value: metres, sd })
}

fn number(name: &Value<'_>, landmarks: &[Landmark]) -> Result<usize, IoError> {
    let text = name.string()?;
    let known = || landmarks.iter().map(|landmark| landmark.name.as_str());
    known().position(|known| known == text).ok_or_else(|| {
        let (hint, known) = (meant(text, known()), listed(known()));
        name.error(format!("there is no landmark `{text}`{hint} (landmarks: {known})"))
    })
}
