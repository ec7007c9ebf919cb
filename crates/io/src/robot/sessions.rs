//! `[sessions]` of a robot description: what each session of a campaign has of its own.

use crate::IoError;
use crate::toml_tree::Table;
use truepose_errormodel::SessionRules;

/// Of its own, or the same in all sessions.
const WORDS: [(&str, bool); 2] = [("own", true), ("shared", false)];

pub(super) fn read(root: &Table<'_>) -> Result<SessionRules, IoError> {
    let mut rules = SessionRules::default();
    let Some(sessions) = root.get("sessions") else { return Ok(rules) };
    let sessions = sessions.table("[sessions]")?;
    sessions.only(&["base", "tool", "targets"])?;
    let own = |key: &str| sessions.get(key).map(|value| value.word(&WORDS)).transpose();
    rules.base = own("base")?.unwrap_or(rules.base);
    rules.tool = own("tool")?.unwrap_or(rules.tool);
    rules.targets = own("targets")?.unwrap_or(rules.targets);
    Ok(rules)
}
