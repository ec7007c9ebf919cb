//! Another installation: base or tool stand elsewhere in a further session.
//!
//! ```text
//! ε(s) = c_k        at the base (or the tool) in session k = 1, 2, …;  nothing in session 0
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | c_k | unknown: six components for each further session | m, rad |
//! | k | the channel [`SESSION`], or `chosen` | |
//!
//! Rows of all sessions are in the measurement frame of the first ([`crate::FittedModel::sessions`] has the poses of the bases); these are
//! what is left of the difference, once the arm is known. The errors of the arm are common to all sessions.

use super::checks::refused;
use super::geometric::EXPECTED_ANGLE;
use crate::{Column, Effect, Emission, ModelError, SESSION, Signal};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, Posture, Site};

/// What a session has of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Own {
    /// The base: the robot, or the instrument, was set up anew.
    Base,
    /// The tool: it was mounted anew.
    Tool,
}

/// Installations of further sessions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// What stands elsewhere.
    pub own: Own,
    /// Names of the further sessions, the second one first.
    pub sessions: Vec<String>,
    /// The session in which the robot is, by its number; the channel says it where this is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen: Option<usize>,
}

/// An installation is found with the nominal arm and takes its share of the arm's errors: a few times what a frame is expected to err by.
const INSTALLED: f64 = 4.0;

impl Session {
    fn frame(&self, chain: &Chain) -> FrameId {
        match self.own {
            Own::Base => FrameId::BASE,
            Own::Tool => chain.tool_frame(),
        }
    }
}

impl Effect for Session {
    const FAMILY: &'static str = "session";
    const ABOUT: &'static str =
        "base or tool of a further session; made from the column `session` of the data";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let frame = self.frame(chain);
        let of = |(k, name): (usize, &String)| {
            Axis::ALL.map(|axis| {
                let site = Site::Frame(frame, axis);
                let length = if axis.is_rotation() { 1.0 } else { chain.characteristic_length() };
                let scale = INSTALLED * EXPECTED_ANGLE * length;
                let word = format!("{} in session {name}", chain.site_word(site));
                // In the session that is chosen it is a constant error.
                let site = (self.chosen == Some(k + 1)).then_some(site);
                Column { site, ..Column::new(word, axis.unit(), scale) }
            })
        };
        self.sessions.iter().enumerate().flat_map(of).collect()
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        // Numbers of sessions are small and whole.
        let number = self.chosen.unwrap_or_else(|| at.signal(0) as usize);
        if number == 0 || number > self.sessions.len() {
            return;
        }
        let frame = self.frame(at.chain());
        for (k, axis) in Axis::ALL.into_iter().enumerate() {
            out.push(6 * (number - 1) + k, Site::Frame(frame, axis), 1.0);
        }
    }

    fn needs(&self) -> Vec<Signal> {
        if self.chosen.is_some() { Vec::new() } else { vec![Signal::Channel(SESSION.into())] }
    }

    fn validate(&self, _chain: &Chain) -> Result<(), ModelError> {
        if self.sessions.is_empty() {
            return Err(refused(Self::FAMILY, "`sessions` is empty; name the sessions after the first"));
        }
        for (k, name) in self.sessions.iter().enumerate() {
            if self.sessions[..k].contains(name) {
                return Err(refused(Self::FAMILY, format!("session `{name}` stands twice in `sessions`")));
            }
        }
        match self.chosen {
            Some(number) if number > self.sessions.len() => {
                Err(refused(Self::FAMILY, "`chosen` is the number of no session"))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::{Conditions, samples};

    fn session(own: Own) -> Session {
        Session { own, sessions: vec!["B".into(), "C".into()], chosen: None }
    }

    #[test]
    fn conforms() {
        for chain in samples::all() {
            for own in [Own::Base, Own::Tool] {
                check_effect(&session(own), &chain);
                check_effect(&Session { chosen: Some(1), ..session(own) }, &chain);
            }
        }
    }

    #[test]
    fn a_session_has_its_own_installation_and_the_first_one_has_none() {
        let chain = samples::ur10();
        let columns = |effect: &Session, number: f64| -> Vec<usize> {
            let mut at = Conditions::at(&chain, &[0.3; 6]);
            at.channels = vec![number];
            emitted(effect, &chain, &at).iter().map(|entry| entry.column).collect()
        };
        let effect = session(Own::Base);
        assert!(columns(&effect, 0.0).is_empty());
        assert_eq!(columns(&effect, 1.0), [0, 1, 2, 3, 4, 5]);
        assert_eq!(columns(&effect, 2.0), [6, 7, 8, 9, 10, 11]);
        // Once it is chosen no channel is read.
        let chosen = Session { chosen: Some(2), ..effect };
        assert!(Effect::needs(&chosen).is_empty());
        assert_eq!(columns(&chosen, 0.0), [6, 7, 8, 9, 10, 11]);
        assert_eq!(Effect::columns(&chosen, &chain)[7].name, "y@base in session C");
        let refused = |effect: Session| Effect::validate(&effect, &chain).unwrap_err().to_string();
        assert!(refused(Session { chosen: Some(3), ..chosen.clone() }).contains("no session"));
        assert!(refused(Session { sessions: vec!["B".into(); 2], ..chosen }).contains("twice"));
    }
}
