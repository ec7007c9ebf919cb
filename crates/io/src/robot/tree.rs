//! What makes a description a tree: `parent` of joints, `[[tools]]`, `tool` of targets.

use super::names::cell_problem;
use crate::IoError;
use crate::frame_names::joint_name;
use crate::nearest::{listed, meant};
use crate::toml_tree::{Table, Value};
use truepose_kinematics::{Chain, JointId, Placed, Tool, ToolId};

/// No robot has more hands.
const MOST_TOOLS: usize = 100;

/// The joint in front of each joint, by the word `parent` (a joint declared before, or `base`); none of them, where no joint has it.
pub(super) fn parents(
    joints: &[Table<'_>],
    errors: &mut Vec<IoError>,
) -> Result<Vec<Option<JointId>>, IoError> {
    if joints.iter().all(|table| table.get("parent").is_none()) {
        return Ok(Vec::new());
    }
    let mut names: Vec<String> = Vec::with_capacity(joints.len());
    let mut parents = Vec::with_capacity(joints.len());
    for table in joints {
        let before = names.len();
        parents.push(match table.get("parent") {
            None => (before > 0).then_some(JointId(before)),
            Some(parent) => {
                let word = parent.string()?;
                let called = joint_name(word);
                let found = names.iter().position(|name| *name == called).filter(|_| word != "base");
                if found.is_none() && word != "base" {
                    let known = || names.iter().map(String::as_str);
                    let hint = meant(word, known());
                    errors.push(parent.error(format!(
                        "no joint `{word}` is declared before this one{hint}; `parent` is such a joint, or `base`"
                    )));
                }
                found.map(|k| JointId(k + 1))
            }
        });
        let name = table.get("name").map(|name| name.string()).transpose()?.unwrap_or_default();
        names.push(joint_name(name).into_owned());
    }
    Ok(parents)
}

fn tables<'d>(root: &Table<'d>) -> Result<Vec<Table<'d>>, IoError> {
    let Some(value) = root.get("tools") else { return Ok(Vec::new()) };
    if let Some(tool) = root.get("tool") {
        return Err(tool.error("[tool] and [[tools]] exclude each other; keep one of them"));
    }
    let tables = value.tables("tools")?;
    match tables.get(MOST_TOOLS) {
        Some(table) => Err(table.error(format!("a robot has at most {MOST_TOOLS} tools"))),
        None => Ok(tables),
    }
}

fn name(table: &Table<'_>) -> Result<String, IoError> {
    let name = table.require("name")?;
    match cell_problem(name.string()?) {
        Some(problem) => Err(name.error(problem)),
        None => Ok(name.string()?.to_owned()),
    }
}

/// Names of the tools; none without `[[tools]]`.
pub(super) fn names(root: &Table<'_>) -> Result<Vec<String>, IoError> {
    tables(root)?.iter().map(name).collect()
}

/// The joint in front of each tool, as it is called; none without `[[tools]]`.
pub(super) fn ends<'d>(root: &Table<'d>) -> Result<Vec<(String, Value<'d>)>, IoError> {
    let tables = tables(root)?;
    let end = |table: &Table<'d>| {
        let joint = table.require("joint")?;
        Ok((joint.string()?.to_owned(), joint))
    };
    tables.iter().map(end).collect()
}

/// The tools of a description; none without `[[tools]]`.
pub(super) fn tools(
    root: &Table<'_>,
    chain: &Chain,
    placed: impl Fn(&Table<'_>) -> Result<Placed, IoError>,
) -> Result<Option<Vec<Tool>>, IoError> {
    let mut tools: Vec<Tool> = Vec::new();
    for table in tables(root)? {
        table.only(&["name", "joint", "xyz", "rpy", "known"])?;
        let name = name(&table)?;
        if tools.iter().any(|tool| tool.name == name) {
            let message = format!("two tools have the name `{name}`; names must be different");
            return Err(table.require("name")?.error(message));
        }
        let joint = table.require("joint")?;
        let word = joint.string()?;
        let on = chain.joint_named(&joint_name(word)).filter(|_| word != "base");
        if on.is_none() && word != "base" {
            let joints = || chain.joints().iter().map(|joint| joint.name.as_str());
            let (hint, known) = (meant(word, joints()), listed(joints()));
            return Err(joint.error(format!("the robot has no joint `{word}`{hint} (its joints: {known})")));
        }
        tools.push(Tool::on(name, on, placed(&table)?));
    }
    Ok((!tools.is_empty()).then_some(tools))
}

/// The tool of a target: the only one, or the one that it names.
pub(super) fn tool_of(target: &Table<'_>, tools: &[String]) -> Result<ToolId, IoError> {
    let known = || listed(tools.iter().map(String::as_str));
    let Some(tool) = target.get("tool") else {
        if tools.len() > 1 {
            let message =
                format!("{} lacks `tool`, the tool that carries it (tools: {})", target.name(), known());
            return Err(target.error(message));
        }
        return Ok(ToolId::FIRST);
    };
    let word = tool.string()?;
    tools.iter().position(|name| name == word).map(ToolId).ok_or_else(|| {
        let hint = meant(word, tools.iter().map(String::as_str));
        tool.error(format!("there is no tool `{word}`{hint} (tools: {})", known()))
    })
}

#[cfg(test)]
mod tests {
    use crate::{RobotOptions, robot_from_text};

    const JOINTS: &str = "[[joints]]\nname = \"t\"\norigin = { axis = [0, 0, 1] }\n\
        [[joints]]\nname = \"l\"\norigin = { xyz = [1, 0, 0], axis = [0, 1, 0] }\n\
        [[joints]]\nname = \"r\"\nparent = \"t\"\norigin = { xyz = [0, 1, 0], axis = [0, 1, 0] }\n";
    const TOOLS: &str = "[[tools]]\nname = \"L\"\njoint = \"l\"\n[[tools]]\nname = \"R\"\njoint = \"r\"\n";

    #[test]
    fn what_is_wrong_with_a_tree_is_said_with_its_place() {
        let read = |text: &str| robot_from_text("r.toml", text, &RobotOptions::default());
        let whole = [JOINTS, TOOLS].concat();
        assert_eq!(read(&whole).unwrap().0.tools().len(), 2);
        let target = |tool: &str| format!("{whole}[[targets]]\nname = \"P\"\n{tool}xyz = [0, 0, 0]\n");
        for (text, words) in [
            (
                whole.replace("parent = \"t\"", "parent = \"tt\""),
                "r.toml:9:10: no joint `tt` is declared before this one",
            ),
            (
                whole.replace("name = \"l\"\no", "name = \"l\"\nparent = \"r\"\no"),
                "r.toml:6:10: no joint `r` is declared before this one",
            ),
            (format!("{whole}size = 1\n"), "unknown key `size`"),
            (whole.replace("joint = \"r\"", "joint = \"q\""), "the robot has no joint `q`"),
            (whole.replace("name = \"R\"", "name = \"L\""), "two tools have the name `L`"),
            (format!("{whole}[tool]\nxyz = [0, 0, 1]\n"), "[tool] and [[tools]] exclude each other"),
            (target(""), "lacks `tool`, the tool that carries it (tools: L, R)"),
            (target("tool = \"l\"\n"), "there is no tool `l`"),
        ] {
            let found = read(&text).unwrap_err().to_string();
            assert!(found.contains(words), "{found}");
        }
    }
}
