//! Sessions, kinds of observation and landmarks on a page: as in the terminal.

use super::Page;
use crate::observers::sentences;
use crate::{KindsSummary, LandmarksSummary, SessionSummary, sessions};

impl Page {
    /// What each session leaves; nothing without sessions.
    pub(crate) fn sessions(&mut self, sessions: &[SessionSummary]) {
        if !sessions.is_empty() {
            let caption = "Sessions, RMS of the 3-D position error";
            self.table(caption, &sessions::HEAD, &sessions::cells(sessions), true);
        }
    }

    /// What each kind of observation leaves, and what is wrong with what observed; nothing where all rows are positions.
    pub(crate) fn kinds(&mut self, kinds: Option<&KindsSummary>) {
        if let Some(kinds) = kinds {
            let caption = format!("Kinds of observation, RMS. {}", KindsSummary::LEGEND);
            self.table(&caption, &KindsSummary::HEAD, &kinds.cells(), true);
            sentences(&kinds.suspects).lines().for_each(|sentence| self.text(sentence));
        }
    }

    /// The spread at each landmark; nothing without landmarks.
    pub(crate) fn landmarks(&mut self, landmarks: Option<&LandmarksSummary>) {
        if let Some(landmarks) = landmarks {
            landmarks.sentences().lines().for_each(|sentence| self.text(sentence));
            let caption = "Landmarks, RMS of the 3-D distance from their mean";
            if !landmarks.points.is_empty() {
                self.table(caption, &LandmarksSummary::HEAD, &landmarks.cells(), true);
            }
            if !landmarks.contacts.is_empty() {
                let caption = "Gap between points that meet, or error of their stated distance";
                self.table(caption, &LandmarksSummary::CONTACT_HEAD, &landmarks.contact_cells(), true);
            }
        }
    }
}
