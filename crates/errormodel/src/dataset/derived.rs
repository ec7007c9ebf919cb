//! Channels that are made from other columns: late ones, and the mass that is carried.
//!
//! | name | what it is | made from |
//! | --- | --- | --- |
//! | `temperature~lag=600` | a body that follows the channel late ([`late_channel`](super::late_channel)) | the channel and `time` |
//! | `z_3~w=0.05` | wind-up of a joint's friction ([`presliding_channel`](super::presliding_channel)) | the order of poses |
//! | `step~3` | last move of a joint ([`step_channel`](super::step_channel)) | the order of poses |
//! | `tau_3~lag=600`, `work_3~lag=600`, `travel_3~lag=600`, `working_300~lag=600` | what was carried, done, moved and paused ([`History`](super::History)) | joints, load and `time` of all poses |
//! | `session~` ([`SESSION`]) | number of the installation, 0… | the column `session` |
//! | `landmark~` ([`LANDMARK`]) | number of the landmark that was touched, 1…; 0: none | the columns `kind`, `landmark` |
//! | `meets~` ([`MEETS`](super::MEETS)) | the point of the robot that the row's target met; 0: none | the columns `kind`, `landmark` |
//! | `tool~` ([`TOOL`]) | number of the tool, 0… | the columns `tool`, `target` |
//! | `kind~`, `value~…`, `ray~…`, `sensor~`, `own~…` | observation of one number ([`Ray`](super::Ray)) | `kind`, `landmark` and measured scalars |
//! | `payload` ([`CARRIED`]) | the mass that is declared to be carried, kg; none is zero | the load |
//!
//! They are made at fit time and wherever a fit is used, so that no file has to hold them.

use super::landmark::LANDMARK;
use super::late::LATE;
use super::presliding::presliding_of;
use super::ray::of_observation;
use super::schema::Channel;
use super::session::SESSION;
use super::step::step_of;
use super::table::Dataset;
use super::tool::TOOL;
use truepose_kinematics::Load;

/// The channel of the mass that is declared to be carried, kg.
pub const CARRIED: &str = "payload";

/// Whether a channel of this name says what was observed in a row, and what came of it: nothing that an error of the robot could depend on.
pub fn is_of_observation(channel: &str) -> bool {
    channel == LANDMARK || of_observation(channel)
}

/// Whether a channel of this name is made from other columns.
pub fn is_derived(channel: &str) -> bool {
    channel == CARRIED
        || channel == SESSION
        || channel == TOOL
        || is_of_observation(channel)
        || channel.contains(LATE)
        || presliding_of(channel).is_some()
        || step_of(channel).is_some()
}

impl Dataset {
    /// A derived channel of this name; none where it cannot be made.
    pub(crate) fn made(&self, name: &str) -> Option<(Channel, Vec<f64>)> {
        if let Some((source, lag)) = self.late(name) {
            let made = Channel { name: name.to_owned(), ..self.schema.channels[source].clone() };
            return Some((made, self.following(source, lag)));
        }
        let made = Channel { name: CARRIED.into(), unit: "kg".into(), temperature: false };
        (name == CARRIED).then(|| self.carried()).flatten().map(|column| (made, column))
    }

    /// The mass that is carried at every row, kg; none where the data has no load, or a measured wrench in place of a mass.
    fn carried(&self) -> Option<Vec<f64>> {
        let mass = |load: &Load| match load {
            Load::None => Some(0.0),
            Load::Payload(payload) => Some(payload.mass),
            Load::Wrench(_) => None,
        };
        self.schema.load.then(|| self.load.iter().map(mass).collect()).flatten()
    }

    /// Adds the channel of the mass that is carried, where it is not always the same.
    pub fn add_carried(&mut self) {
        if self.schema.channel(CARRIED).is_none()
            && let Some((made, column)) = self.made(CARRIED)
            && column.iter().any(|mass| (mass - column[0]).abs() > 0.0)
        {
            self.schema.channels.push(made);
            self.channels.push(column);
        }
    }
}
