//! Sessions: rows of one installation of robot and instrument.
//!
//! The session of a row is a channel of the data set, [`SESSION`], whose value is the session's number 0… in order of first appearance. So it
//! follows its row into every part of the data, and an effect reads it like any other signal.

use super::schema::Channel;
use super::table::Dataset;

/// The channel of the session's number. No file can have a column of this name, and no cause is looked for in it.
pub const SESSION: &str = "session~";

/// What each session has of its own; what it has not, all sessions share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SessionRules {
    /// Where robot and instrument stand to each other.
    pub base: bool,
    /// How the tool is mounted.
    pub tool: bool,
    /// Where the targets sit on the tool.
    pub targets: bool,
}

impl Default for SessionRules {
    fn default() -> Self {
        SessionRules { base: true, tool: false, targets: false }
    }
}

impl Dataset {
    /// The number of each row's session; none where the data has one installation only.
    pub fn sessions(&self) -> Option<&[f64]> {
        self.schema.channel(SESSION).map(|k| self.channels[k].as_slice())
    }

    /// The number of a row's session; zero where the data has one installation only.
    pub fn session(&self, row: usize) -> usize {
        // Numbers are small and whole.
        self.sessions().map_or(0, |numbers| numbers[row] as usize)
    }

    /// True when both rows were measured in one installation.
    pub fn same_session(&self, a: usize, b: usize) -> bool {
        self.sessions().is_none_or(|numbers| numbers[a].to_bits() == numbers[b].to_bits())
    }

    /// With these numbers of sessions, one a row; one installation only where they are none.
    pub fn set_sessions(&mut self, numbers: Option<Vec<f64>>) {
        self.set_numbers(SESSION, numbers);
    }

    /// With these numbers in a channel of this name; without it where they are none.
    pub(super) fn set_numbers(&mut self, name: &str, numbers: Option<Vec<f64>>) {
        if let Some(k) = self.schema.channel(name) {
            self.schema.channels.remove(k);
            self.channels.remove(k);
        }
        if let Some(numbers) = numbers {
            self.schema.channels.push(Channel { name: name.into(), unit: "1".into(), temperature: false });
            self.channels.push(numbers);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{DatasetBuilder, Measurement};
    use truepose_kinematics::samples;

    #[test]
    fn a_session_follows_its_row() {
        let chain = samples::ur10();
        let mut builder = DatasetBuilder::new(&chain);
        for k in 0..4 {
            builder.push(Measurement::at([0.1 * f64::from(k); 6]).position([0.5, 0.2, 0.3])).unwrap();
        }
        let mut data = builder.finish();
        assert!(data.sessions().is_none() && data.session(2) == 0 && data.same_session(0, 3));
        data.set_sessions(Some(vec![0.0, 0.0, 1.0, 1.0]));
        data.validate(&chain).unwrap();
        let part = data.select(&[3, 1]);
        assert_eq!([part.session(0), part.session(1)], [1, 0]);
        assert!(!part.same_session(0, 1) && data.same_session(2, 3));
        data.set_sessions(None);
        assert!(data.schema.channels.is_empty() && data.channels.is_empty());
    }
}
