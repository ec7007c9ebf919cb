//! Cells of a row that hold no number: targets, whether the row is used, and nothing.

use super::cells::shown;
use super::columns::Cells;
use super::row::{Kind, RowReader};
use crate::IoError;
use crate::nearest::{listed, meant};
use crate::table::unprefixed;
use truepose_errormodel::observation::KINDS as NUMBERS;
use truepose_kinematics::{TargetId, ToolId};

/// Words of the column `kind`.
const KINDS: [(&str, Kind); 3 + NUMBERS.len()] = {
    let mut all = [("position", Kind::Pose); 3 + NUMBERS.len()];
    (all[1], all[2]) = (("pose", Kind::Pose), ("same_point", Kind::SamePoint));
    let mut k = 0;
    while k < NUMBERS.len() {
        all[3 + k] = (NUMBERS[k], Kind::Number(k));
        k += 1;
    }
    all
};

/// No robot is set up anew more often while one table is filled.
const MOST_SESSIONS: usize = 1000;

impl RowReader {
    /// Reads a cell that holds no number; where it ends.
    pub(super) fn read_text(
        &mut self,
        line: u64,
        text: &[u8],
        at: usize,
        k: usize,
    ) -> Result<usize, IoError> {
        let (content, end) = self.cell(line, text, at, k)?;
        match self.kinds[k].0 {
            Cells::Target => match self.target(&content) {
                Ok(target) => {
                    self.row.target = target;
                    self.seen[k].filled += usize::from(target.is_some());
                }
                Err(message) => {
                    if let Some(error) = self.miscounted(line, text) {
                        return Err(error);
                    }
                    self.problems.push(self.header.cell_error(line, k, message));
                }
            },
            Cells::Blank => self.seen[k].filled += usize::from(!content.is_empty()),
            Cells::Use => self.use_row(line, k, &content)?,
            Cells::Id => self.take_id(k, &content),
            Cells::Session | Cells::Kind | Cells::Landmark | Cells::Point | Cells::Tool => {
                self.take_word(line, k, &content);
            }
            _ => {}
        }
        Ok(end)
    }

    /// What the row is called.
    pub(super) fn take_id(&mut self, k: usize, content: &str) {
        self.id.clear();
        self.id.push_str(unprefixed(content));
        self.seen[k].filled += usize::from(!content.is_empty());
    }

    /// Session, kind, landmark or tool of the row.
    pub(super) fn take_word(&mut self, line: u64, k: usize, content: &str) {
        let word = unprefixed(content).trim();
        match self.kinds[k].0 {
            Cells::Session => self.take_session(line, k, word),
            _ if word.is_empty() => {}
            Cells::Tool => match self.tools.iter().position(|known| known == word) {
                Some(tool) => {
                    self.row.tool = Some(ToolId(tool));
                    self.seen[k].filled += 1;
                }
                None => {
                    let known = || self.tools.iter().map(String::as_str);
                    let (hint, known) = (meant(word, known()), listed(known()));
                    let message =
                        format!("the robot has no tool `{}`{hint} (its tools: {known})", shown(word));
                    self.problems.push(self.header.cell_error(line, k, message));
                }
            },
            Cells::Kind => match KINDS.iter().find(|(known, _)| *known == word) {
                Some(&(_, kind)) => {
                    self.row.kind = kind;
                    self.seen[k].filled += 1;
                }
                None => {
                    let known = || KINDS.iter().map(|(known, _)| *known);
                    let (hint, known) = (meant(word, known()), listed(known()));
                    let message =
                        format!("`{}` is no kind of observation{hint} (known: {known})", shown(word));
                    self.problems.push(self.header.cell_error(line, k, message));
                }
            },
            cells => {
                let number = self.landmarks.iter().position(|known| known == word).unwrap_or_else(|| {
                    self.landmarks.push(word.to_owned());
                    self.landmarks.len() - 1
                });
                let at = if cells == Cells::Point { &mut self.row.point } else { &mut self.row.landmark };
                *at = Some(number);
                self.seen[k].filled += 1;
            }
        }
    }

    /// In which session the row was measured.
    fn take_session(&mut self, line: u64, k: usize, content: &str) {
        let name = content;
        let wrong = if name.is_empty() {
            "is empty; every row is of a session: name it, or remove the column".into()
        } else if name.contains('@') || name.chars().any(char::is_control) {
            format!("`{}` cannot be the name of a session; leave out `@` and control characters", shown(name))
        } else if let Some(number) = self.sessions.iter().position(|known| known == name) {
            self.row.session = number;
            self.seen[k].filled += 1;
            return;
        } else if self.sessions.len() == MOST_SESSIONS {
            format!("is the name of session {}; a table has {MOST_SESSIONS} at most", MOST_SESSIONS + 1)
        } else {
            self.row.session = self.sessions.len();
            self.sessions.push(name.to_owned());
            self.seen[k].filled += 1;
            return;
        };
        self.problems.push(self.header.cell_error(line, k, wrong));
    }

    /// Whether the row is used.
    pub(super) fn use_row(&mut self, line: u64, k: usize, content: &str) -> Result<(), IoError> {
        match content.to_lowercase().as_str() {
            "1" | "yes" | "true" | "x" => {}
            "0" | "no" | "false" => self.row.skipped = true,
            _ => {
                let message = format!("`{}` has to be 1 (the row is used) or 0", shown(content));
                self.problems.push(self.header.cell_error(line, k, message));
                return Ok(());
            }
        }
        self.seen[k].filled += 1;
        Ok(())
    }

    /// The target of this name; none for an empty one.
    pub(super) fn target(&self, name: &str) -> Result<Option<TargetId>, String> {
        let name = unprefixed(name);
        if name.is_empty() {
            return Ok(None);
        }
        if let Some(index) = self.targets.iter().position(|target| target == name) {
            return Ok(Some(TargetId(index)));
        }
        let known = || self.targets.iter().map(String::as_str);
        let name = shown(name);
        let (hint, known) = (meant(&name, known()), listed(known()));
        Err(format!(
            "the robot has no target `{name}`{hint}; declare it in [[targets]] (its targets: {known})"
        ))
    }
}
