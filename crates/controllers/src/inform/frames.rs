//! Frames and tools of a controller: `UFRAME.CND` and `TOOL.CND`.
//!
//! ```text
//! //UFRAME 1                       //TOOL 1
//! ///NAME TABLE                    ///NAME GUN
//! ////BUSER x,y,z,Rx,Ry,Rz         x,y,z,Rx,Ry,Rz
//!                                  x,y,z            centre of gravity, mm
//!                                  w                weight, kg; in some files in front of the centre
//! ```

use crate::Dialect;
use crate::definitions::{Definition, Definitions};
use crate::lines::lines;
use crate::number::number_at;
use truepose_kinematics::nalgebra::Vector3;

/// Whether a text is one of these.
pub(super) fn is(text: &[u8]) -> bool {
    lines(text).iter().any(|line| head(line.trimmed()).is_some())
}

/// `USER 1`, `TOOL 1`, … with their values.
pub(super) fn read(text: &[u8], definitions: &mut Definitions) {
    let mut name: Option<String> = None;
    let mut load = Weight::default();
    for line in lines(text) {
        if let Some(found) = head(line.trimmed()) {
            name = Some(found);
            load.put(definitions);
            continue;
        }
        if load.tool.is_some() {
            load.read(&list(line.trimmed()));
        }
        let user = name.as_ref().is_some_and(|name| name.starts_with("USER"));
        let numbers = if user { line.after("////BUSER") } else { Some(line.trimmed()) };
        let Some(numbers) = numbers.map(|bytes| list(bytes.trim_ascii())) else { continue };
        if numbers.len() == 6
            && let Some(name) = name.take()
        {
            let found = Dialect::Inform.pose(&numbers);
            let unusable = || Definition::Unusable(format!("{name} is not made of numbers"));
            definitions.put(name.clone(), found.map_or_else(unusable, Definition::Value));
            load.tool = Some(name).filter(|_| !user);
        }
    }
    load.put(definitions);
}

/// Weight and centre of gravity of a tool.
#[derive(Debug, Default)]
struct Weight {
    tool: Option<String>,
    mass: Option<f64>,
    center: Option<Vector3<f64>>,
}

impl Weight {
    fn read(&mut self, numbers: &[f64]) {
        match *numbers {
            [mass] => self.mass = self.mass.or(Some(mass)),
            [x, y, z] => self.center = self.center.or(Some(1e-3 * Vector3::new(x, y, z))),
            _ => {}
        }
    }

    /// As `TOOL 1.W`; without a weight none is stated.
    fn put(&mut self, definitions: &mut Definitions) {
        if let Weight { tool: Some(tool), mass: Some(mass), center: Some(center) } = std::mem::take(self)
            && mass > 0.0
        {
            definitions.put(format!("{tool}.W"), Definition::Load(mass, center));
        }
    }
}

/// `//UFRAME 1`, `//TOOL 1`.
fn head(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut words = text.split_whitespace();
    let kind = match words.next()? {
        "//UFRAME" => "USER",
        "//TOOL" => "TOOL",
        _ => return None,
    };
    let number: u32 = words.next()?.parse().ok()?;
    Some(format!("{kind} {number}"))
}

/// Numbers between commas.
fn list(bytes: &[u8]) -> Vec<f64> {
    let one = |part: &[u8]| {
        let part = part.trim_ascii();
        number_at(part).filter(|(_, length)| *length == part.len()).map(|(value, _)| value)
    };
    let all: Option<Vec<f64>> = bytes.split(|&byte| byte == b',').map(one).collect();
    all.unwrap_or_default()
}
