//! Rows in which the instrument had lost its target: it writes x = y = z = 0.
//!
//! No point of a robot is measured at the origin to the last digit. Such a row was not measured, neither its position nor its orientation;
//! a warning names such rows.

use super::header::Header;
use truepose_kinematics::{Chain, TargetId};

/// Lines that are named.
const NAMED: usize = 5;
/// Lines that are remembered: files may be larger than memory.
const REMEMBERED: usize = 10_000;
/// A robot whose target is described to stand this near to the origin, in lengths of the robot, may have been measured there.
const THERE: f64 = 0.02;

/// Which rows were lost.
#[derive(Debug)]
pub(crate) struct Lost {
    /// Where everything of it is known.
    chain: Chain,
    /// Lines of the file, in order, up to a number of them.
    lines: Vec<u64>,
    count: usize,
}

impl Lost {
    pub fn new(chain: &Chain) -> Self {
        Lost { chain: chain.clone(), lines: Vec::new(), count: 0 }
    }

    /// Whether a row with x = y = z = 0 cannot have been measured: the robot as described has its target elsewhere.
    pub fn is(&self, header: &Header, numbers: &[f64], target: Option<TargetId>) -> bool {
        let Some(slots) = &header.slots.joints else { return false };
        let known = self.chain.base().known
            && self.chain.tool().known
            && target.is_none_or(|t| self.chain.targets()[t.0].known);
        if !known {
            return true;
        }
        let mut joints: Vec<f64> = slots.iter().map(|&k| numbers[k]).collect();
        self.chain.follow(&mut joints);
        let tool = self.chain.forward(&joints);
        let at = match target {
            Some(t) => tool.apply(&self.chain.targets()[t.0].position),
            None => tool.translation,
        };
        at.norm() > THERE * self.chain.characteristic_length()
    }

    pub fn add(&mut self, line: u64) {
        self.count += 1;
        if self.lines.len() < REMEMBERED {
            self.lines.push(line);
        }
    }

    /// Whether the row of this line was.
    pub fn has(&self, line: u64) -> bool {
        self.lines.binary_search(&line).is_ok()
    }

    /// The first line, and the warning about all of them.
    pub fn words(&self) -> Option<(u64, String)> {
        let first = *self.lines.first()?;
        let named: Vec<String> = self.lines.iter().take(NAMED).skip(1).map(u64::to_string).collect();
        let others = match (self.count, named.join(", ")) {
            (1, _) => String::new(),
            (n, named) if n <= NAMED => format!(" and in line{} {named}", if n == 2 { "" } else { "s" }),
            (n, named) => format!(" and in lines {named} and {} others", n - NAMED),
        };
        Some((
            first,
            format!(
                "x, y and z are all 0{others}: read as not measured: instruments write this when the target is lost; leave the cells empty"
            ),
        ))
    }
}
