//! `[[landmarks]]` and `[[distances]]` of a robot description: what the robot touches or is observed by, and what is known of it.

use super::cameras;
use super::names::cell_problem;
use crate::nearest::{listed, meant};
use crate::toml_tree::{Table, Value};
use crate::{IoError, Unit};
use truepose_errormodel::observation::{Distance, Linear, Observation, Plane, Relative, Sphere};
use truepose_errormodel::{KnownDistance, Landmark, Surroundings};
use truepose_kinematics::nalgebra::Vector3;

/// What a landmark is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// What holds a target at one point.
    Point,
    /// A ball: it holds a cone at one point, or is probed.
    Sphere,
    Distance,
    Plane,
    Linear,
    /// Positions in a frame of their own.
    Relative,
}

/// Words for them.
const KINDS: [(&str, Kind); 9] = [
    ("point", Kind::Point),
    ("socket", Kind::Point),
    ("cone", Kind::Point),
    ("sphere", Kind::Sphere),
    ("distance", Kind::Distance),
    ("anchor", Kind::Distance),
    ("plane", Kind::Plane),
    ("linear", Kind::Linear),
    ("relative", Kind::Relative),
];

pub(super) fn read(root: &Table<'_>, length: &Unit, angle: &Unit) -> Result<Surroundings, IoError> {
    let mut all = Surroundings::default();
    let landmarks = root.get("landmarks").map(|value| value.tables("[[landmarks]]")).transpose()?;
    for table in landmarks.iter().flatten() {
        let found = landmark(table, length)?;
        if all.landmarks.iter().any(|other| other.name == found.name) {
            return Err(table.error(format!("landmark `{}` stands twice", found.name)));
        }
        all.landmarks.push(found);
    }
    let cameras = root.get("cameras").map(|value| value.tables("[[cameras]]")).transpose()?;
    for table in cameras.iter().flatten() {
        let found = cameras::read(table, length, angle)?;
        if all.landmarks.iter().any(|other| other.name == found.name) {
            return Err(table.error(format!("`{}` stands twice among landmarks and cameras", found.name)));
        }
        all.landmarks.push(found);
    }
    all.open = landmarks.is_none();
    let distances = root.get("distances").map(|value| value.tables("[[distances]]")).transpose()?;
    for table in distances.iter().flatten() {
        let found = distance(table, length, &mut all)?;
        all.distances.push(found);
    }
    Ok(all)
}

fn landmark(table: &Table<'_>, length: &Unit) -> Result<Landmark, IoError> {
    table.only(&["name", "kind", "xyz", "known", "normal", "radius", "gain", "offset", "free", "sd"])?;
    let name = table.require("name")?;
    let text = name.string()?;
    if let Some(problem) = cell_problem(text) {
        return Err(name.error(problem));
    }
    let kind = table.get("kind").map(|kind| kind.word(&KINDS)).transpose()?.unwrap_or(Kind::Point);
    for (key, kinds) in [
        ("normal", &[Kind::Plane, Kind::Linear][..]),
        ("radius", &[Kind::Sphere]),
        ("gain", &[Kind::Distance, Kind::Linear]),
        ("offset", &[Kind::Distance, Kind::Linear]),
        ("free", &[Kind::Distance, Kind::Linear, Kind::Sphere]),
        ("sd", &[Kind::Distance, Kind::Linear, Kind::Sphere, Kind::Plane, Kind::Relative]),
    ] {
        if let Some(value) = table.get(key).filter(|_| !kinds.contains(&kind)) {
            let words = KINDS.iter().filter(|(_, known)| kinds.contains(known));
            let words: Vec<String> = words.map(|(word, _)| format!("`{word}`")).collect();
            return Err(value.error(format!("`{key}` belongs to a landmark of kind {}", words.join(" or "))));
        }
    }
    let xyz = table.get("xyz").map(|xyz| xyz.numbers::<3>()).transpose()?;
    let position: Option<Vector3<f64>> = xyz.map(|xyz| xyz.map(|v| length.to_si(v)).into());
    let of = Numbers { table, length, text, position, normal: normal(table)? };
    let said = table.get("known").map(|known| known.boolean()).transpose()?;
    let given = match kind {
        Kind::Plane => of.normal.is_some() && position.is_some(),
        Kind::Linear => of.normal.is_some(),
        _ => position.is_some(),
    };
    let known = said.unwrap_or(given);
    if known && kind == Kind::Relative {
        return Err(name.error(format!(
            "the frame of series `{text}` is found from its rows; leave out `xyz` and `known`"
        )));
    }
    if known && !given {
        let lacks = match kind {
            Kind::Plane => "no `normal`, or no `xyz` of a point of it",
            Kind::Linear => "no `normal`",
            _ => "no `xyz`",
        };
        return Err(name.error(format!("landmark `{text}` is known, but has {lacks}")));
    }
    let (observed, sd) = (of.observation(kind, known)?, of.above_zero("sd")?);
    Ok(Landmark { name: text.into(), position, known, observed, mount: None, sd })
}

/// A direction as a unit vector.
fn normal(table: &Table<'_>) -> Result<Option<Vector3<f64>>, IoError> {
    let Some(value) = table.get("normal") else { return Ok(None) };
    let direction = Vector3::from(value.numbers::<3>()?);
    match direction.try_normalize(1e-9) {
        Some(unit) => Ok(Some(unit)),
        None => Err(value.error("a normal has a length above zero")),
    }
}

/// A landmark whose rows measure numbers.
struct Numbers<'a> {
    table: &'a Table<'a>,
    length: &'a Unit,
    text: &'a str,
    position: Option<Vector3<f64>>,
    normal: Option<Vector3<f64>>,
}

impl Numbers<'_> {
    /// How it is observed by numbers; none of a point.
    fn observation(&self, kind: Kind, known: bool) -> Result<Option<Box<dyn Observation>>, IoError> {
        let gain = match self.table.get("gain") {
            Some(gain) if gain.number()?.abs() < f64::MIN_POSITIVE => {
                return Err(gain.error("a gain is not zero"));
            }
            Some(gain) => gain.number()?,
            None => 1.0,
        };
        let offset = self.table.get("offset").map(|value| value.number()).transpose()?;
        let offset = offset.map(|value| self.length.to_si(value));
        let radius = self.above_zero("radius")?;
        Ok(match kind {
            Kind::Point => None,
            Kind::Distance => {
                let free = self.free(&["gain", "offset"])?;
                Some(Box::new(Distance {
                    anchor: self.position,
                    known,
                    gain,
                    free_gain: free.contains(&"gain"),
                    offset: offset.unwrap_or(0.0),
                    free_offset: free.contains(&"offset"),
                }))
            }
            Kind::Plane => Some(Box::new(Plane { normal: self.normal, point: self.position, known })),
            Kind::Sphere => {
                let free = self.free(&["radius"])?;
                let free_radius = radius.is_none() || free.contains(&"radius");
                Some(Box::new(Sphere { centre: self.position, known, radius, free_radius }))
            }
            Kind::Relative => Some(Box::new(Relative::default())),
            Kind::Linear => {
                let free = self.free(&["gain", "offset"])?;
                Some(Box::new(Linear {
                    direction: self.normal,
                    known,
                    about: self.position.unwrap_or_default(),
                    gain,
                    free_gain: free.contains(&"gain"),
                    offset: offset.unwrap_or(0.0),
                    free_offset: offset.is_none() || free.contains(&"offset"),
                }))
            }
        })
    }

    /// What is estimated though a value is given.
    fn free(&self, words: &[&'static str]) -> Result<Vec<&'static str>, IoError> {
        let Some(free) = self.table.get("free") else { return Ok(Vec::new()) };
        let known: Vec<(&str, &'static str)> = words.iter().map(|word| (*word, *word)).collect();
        free.elements("an array of words")?.iter().map(|word| word.word(&known)).collect()
    }

    /// A length above zero, m.
    fn above_zero(&self, key: &str) -> Result<Option<f64>, IoError> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        match value.number()? {
            number if number > 0.0 => Ok(Some(self.length.to_si(number))),
            _ => Err(value.error(format!("`{key}` of landmark `{}` has to be above zero", self.text))),
        }
    }
}

fn distance(table: &Table<'_>, length: &Unit, all: &mut Surroundings) -> Result<KnownDistance, IoError> {
    table.only(&["between", "value", "sd"])?;
    let between = table.require("between")?;
    let names = between.elements("an array of the names of two landmarks")?;
    let [first, second] = names.as_slice() else {
        return Err(between.error("`between` names two landmarks"));
    };
    let pair = [number(first, all)?, number(second, all)?];
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

/// The landmark of a name; where the file lists none it is one.
fn number(name: &Value<'_>, all: &mut Surroundings) -> Result<usize, IoError> {
    let text = name.string()?;
    let landmarks = &all.landmarks;
    if all.open && landmarks.iter().all(|landmark| landmark.name != text) {
        if let Some(problem) = cell_problem(text) {
            return Err(name.error(problem));
        }
        all.landmarks.push(Landmark { name: text.into(), ..Landmark::default() });
        return Ok(all.landmarks.len() - 1);
    }
    let known = || landmarks.iter().map(|landmark| landmark.name.as_str());
    known().position(|known| known == text).ok_or_else(|| {
        let (hint, known) = (meant(text, known()), listed(known()));
        name.error(format!("there is no landmark `{text}`{hint} (landmarks: {known})"))
    })
}
