//! The model that a user declares: `[[effects]]` tables, with names where effects have numbers.

use crate::IoError;
use crate::nearest::{listed, meant};
use crate::text::Text;
use crate::toml_tree::{Document, Table, Value};
use serde_json::Value as Json;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use truepose_errormodel::{AnyEffect, EffectRegistry, MOST_UNKNOWNS, ModelError, Term};
use truepose_kinematics::Chain;

/// Reads a declared model: its effects, in the order of the file.
///
/// Under the keys `joint`, `joints`, `small`, `driver`, `load`, `approach`, `frame`, `frames`, `target` and `targets`, at any
/// depth, names of the robot's joints, frames (`base`, a joint's name, `tool`) and targets stand for their numbers.
///
/// # Errors
/// When the file cannot be read, or an effect is not known or does not fit the robot.
pub fn read_model(
    path: impl AsRef<Path>,
    chain: &Chain,
    registry: &EffectRegistry,
) -> Result<Vec<Box<dyn AnyEffect>>, IoError> {
    read(&Text::read(path.as_ref())?, chain, registry)
}

/// Reads a declared model from the text of such a file. `name` stands in messages where the name of a file would.
///
/// # Errors
/// As [`read_model`].
pub fn model_from_text(
    name: impl Into<PathBuf>,
    text: impl Into<String>,
    chain: &Chain,
    registry: &EffectRegistry,
) -> Result<Vec<Box<dyn AnyEffect>>, IoError> {
    read(&Text { file: name.into(), text: text.into() }, chain, registry)
}

fn read(text: &Text, chain: &Chain, registry: &EffectRegistry) -> Result<Vec<Box<dyn AnyEffect>>, IoError> {
    let path = text.file.as_path();
    let document = Document::parse(text)?;
    let root = document.root("the model");
    root.only(&["effects"])?;
    let Some(effects) = root.get("effects") else {
        return Err(IoError::file(
            path,
            "declares no effects; begin with [[effects]] and `family = \"geometric\"`",
        ));
    };
    let tables = effects.tables("effects")?;
    // Each has an unknown at least.
    if tables.len() > MOST_UNKNOWNS {
        let words =
            format!("declares {} effects; a model has at most {MOST_UNKNOWNS} unknowns", tables.len());
        return Err(IoError::file(path, words));
    }
    let mut list: Vec<Box<dyn AnyEffect>> = Vec::with_capacity(tables.len());
    let mut declared = HashSet::with_capacity(tables.len());
    for table in &tables {
        let next = effect(table, chain, registry)?;
        if !declared.insert((next.kind().to_owned(), next.parameters().to_string())) {
            return Err(table
                .error(format!("effect `{}` is declared twice in the same way; remove one", next.kind())));
        }
        list.push(next);
    }
    Ok(list)
}

fn effect(
    table: &Table<'_>,
    chain: &Chain,
    registry: &EffectRegistry,
) -> Result<Box<dyn AnyEffect>, IoError> {
    let family = table.require("family")?;
    let word = family.string()?;
    if !registry.kinds().any(|(kind, _)| kind == word) {
        let kinds = || registry.kinds().map(|(kind, _)| kind);
        let message = format!(
            "unknown effect family `{word}`{} (known: {})",
            meant(word, kinds()),
            kinds().collect::<Vec<_>>().join(", ")
        );
        return Err(family.error(message));
    }
    let mut parameters = serde_json::Map::new();
    for key in table.keys().filter(|key| !matches!(*key, "family" | "bounds")) {
        if let Some(value) = table.get(key) {
            parameters.insert(key.into(), resolved(&value, key, chain)?);
        }
    }
    let effect = registry.build(word, Json::Object(parameters), chain).map_err(|error| match error {
        ModelError::Parameters { reason, .. } => complaint(table, word, &reason),
        error => table.error(error.to_string()),
    })?;
    match table.get("bounds") {
        Some(value) => {
            let bounds = bounds(&value)?;
            Ok(Box::new(Term::new(effect).bounded(bounds).map_err(|e| value.error(e.to_string()))?))
        }
        None => Ok(effect),
    }
}

/// Lower and upper bound of an effect's unknowns, `-inf` and `inf` included.
fn bounds(value: &Value<'_>) -> Result<[f64; 2], IoError> {
    let pair = || value.error("`bounds` has to be [lower, upper], such as [0, 1e-5] or [-inf, 1e-3]");
    if !value.is_array() {
        return Err(pair());
    }
    let numbers = value.elements("bounds")?.iter().map(Value::bound).collect::<Result<Vec<f64>, _>>()?;
    <[f64; 2]>::try_from(numbers).map_err(|_| pair())
}

/// A value as JSON, in which names have become numbers.
fn resolved(value: &Value<'_>, key: &str, chain: &Chain) -> Result<Json, IoError> {
    if value.is_array() {
        let elements = value.elements("an array")?;
        return elements.iter().map(|element| resolved(element, key, chain)).collect();
    }
    if value.is_table() {
        let table = value.table(value.name())?;
        let mut object = serde_json::Map::new();
        for key in table.keys() {
            if let Some(value) = table.get(key) {
                let value = if value.is_string() && matches!(key, "joints" | "small" | "frames" | "targets") {
                    return Err(list_wanted(&value));
                } else {
                    resolved(&value, key, chain)?
                };
                object.insert(key.into(), value);
            }
        }
        return Ok(Json::Object(object));
    }
    if !value.is_string() {
        return value.scalar();
    }
    let word = value.string()?;
    let unknown = |what: &str, known: Vec<&str>| {
        let hint = meant(word, known.iter().copied());
        value.error(format!("the robot has no {what} `{word}`{hint} (known: {})", listed(known)))
    };
    match key {
        "joint" | "joints" | "small" | "driver" | "load" | "approach" => match chain.joint_named(word) {
            Some(joint) => Ok(joint.0.into()),
            None => Err(unknown("joint", chain.joints().iter().map(|joint| joint.name.as_str()).collect())),
        },
        "frames" if word == "targets" => Ok(word.into()),
        "frame" | "frames" => match chain.frame_named(word) {
            Some(frame) => Ok(frame.0.into()),
            None => {
                let mut known: Vec<&str> = chain.frames().map(|frame| chain.frame_word(frame)).collect();
                if key == "frames" {
                    known.push("targets");
                }
                Err(unknown("frame", known))
            }
        },
        "target" | "targets" => match chain.target_named(word) {
            Some(target) => Ok(target.0.into()),
            None => {
                Err(unknown("target", chain.targets().iter().map(|target| target.name.as_str()).collect()))
            }
        },
        _ => value.scalar(),
    }
}

fn list_wanted(value: &Value<'_>) -> IoError {
    value.error(format!("{} has to be an array of names, such as [\"…\"]", value.name()))
}

/// An effect's complaint about its parameters, at the key that it is about, with the nearest known word.
fn complaint(table: &Table<'_>, family: &str, reason: &str) -> IoError {
    let (about, expected) = reason.split_once(", expected").unwrap_or((reason, ""));
    let quoted =
        |text: &'_ str| -> Vec<String> { text.split('`').skip(1).step_by(2).map(String::from).collect() };
    let (named, known) = (quoted(about), quoted(expected));
    let hint = match named.first() {
        Some(word) if reason.starts_with("unknown") => meant(word, known.iter().map(String::as_str)),
        _ => String::new(),
    };
    let message = format!("effect `{family}`: {reason}{hint}");
    match named.iter().find(|word| table.keys().any(|key| key == word.as_str())) {
        Some(key) => table.error_at_key(key, message),
        None => table.error(message),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use truepose_kinematics::samples;

    fn read(toml: &str) -> Result<Vec<(String, Json)>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.toml");
        std::fs::write(&path, toml).unwrap();
        read_model(&path, &samples::pps(), &EffectRegistry::builtin())
            .map(|effects| effects.iter().map(|e| (e.kind().to_string(), e.parameters())).collect())
            .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn names_become_numbers() {
        let effects = read(
            r#"
[[effects]]
family = "geometric"

[[effects]]
family = "geometric"
frames = ["base", "d2", "tool", "targets"]
components = ["x", "rz"]

[[effects]]
family = "joint_compliance"
joints = ["roll", "pitch"]

[[effects]]
family = "expansion"
at = { motion = { joint = "theta" } }
factors = [{ of = { joint = "d1" }, basis = { powers = [1, 2] } }, { of = { load = "pitch" }, basis = { powers = [1] } }]

[[effects]]
family = "expansion"
at = { target = { target = "P2", components = ["z"] } }
factors = [{ of = { wrench = { frame = "tool", component = 2 } }, basis = { powers = [1] } }, { of = "time", basis = { powers = [1] } }]
"#,
        )
        .unwrap();
        let expansion = |at: Json, factors: Json| json!({ "at": at, "factors": factors });
        assert_eq!(
            effects,
            [
                ("geometric".into(), json!({})),
                ("geometric".into(), json!({ "frames": [0, 2, 7, "targets"], "components": ["x", "rz"] })),
                ("joint_compliance".into(), json!({ "joints": [5, 6] })),
                (
                    "expansion".into(),
                    expansion(
                        json!({ "motion": { "joint": 4 } }),
                        json!([
                            { "of": { "joint": 1 }, "basis": { "powers": [1, 2] } },
                            { "of": { "load": 6 }, "basis": { "powers": [1] } }
                        ])
                    )
                ),
                (
                    "expansion".into(),
                    expansion(
                        json!({ "target": { "target": 1, "components": ["z"] } }),
                        json!([
                            { "of": { "wrench": { "frame": 7, "component": 2 } }, "basis": { "powers": [1] } },
                            { "of": "time", "basis": { "powers": [1] } }
                        ])
                    )
                ),
            ]
        );
    }

    #[test]
    fn every_family_can_be_declared() {
        let effects = read(
            r#"
[[effects]]
family = "polynomial"
degree = 3
small = ["roll", "pitch"]
wrench = ["fy"]

[[effects]]
family = "link_compliance"
joints = ["d3"]
own_weight = "free"

[[effects]]
family = "thermal"
joint = "d1"
channel = "temperature"
lag = 600

[[effects]]
family = "drift"
frame = "tool"
components = ["x", "rz"]
range = [0, 3600]

[[effects]]
family = "shift"
frame = "base"
at = 1200.5
at_range = [600, 1800]

[[effects]]
family = "coupling"
joint = "theta"
driver = "d2"
"#,
        )
        .unwrap();
        let kinds: Vec<&str> = effects.iter().map(|(kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, ["polynomial", "link_compliance", "thermal", "drift", "shift", "coupling"]);
        assert_eq!(effects[0].1["small"], json!([5, 6]));
        assert_eq!(effects[3].1["frame"], json!(7));
        assert_eq!(effects[4].1, json!({ "frame": 0, "at": 1200.5, "at_range": [600.0, 1800.0] }));
        assert_eq!((&effects[5].1["joint"], &effects[5].1["driver"]), (&json!(4), &json!(2)));
    }

    #[test]
    fn bounds_are_the_fits_and_not_the_effects() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.toml");
        let text = "[[effects]]\nfamily = \"joint_compliance\"\njoints = [\"roll\"]\nbounds = [-inf, 1e-5]\n";
        std::fs::write(&path, text).unwrap();
        let effects = read_model(&path, &samples::pps(), &EffectRegistry::builtin()).unwrap();
        let [lower, upper] = effects[0].columns(&samples::pps())[0].bounds;
        assert!(lower == f64::NEG_INFINITY && (upper - 1e-5).abs() < 1e-20);
        assert_eq!(effects[0].parameters(), json!({ "joints": [5] }));

        let error = |bounds: &str| {
            read(&format!("[[effects]]\nfamily = \"geometric\"\nbounds = {bounds}\n")).unwrap_err()
        };
        assert_eq!(
            error("[1e-3]"),
            "m.toml:3:10: `bounds` has to be [lower, upper], such as [0, 1e-5] or [-inf, 1e-3]"
        );
        assert_eq!(error("2"), error("[1e-3]"));
        assert_eq!(error("[1, 0]"), "m.toml:3:10: effect `geometric`: `bounds` have to ascend, not [1, 0]");
        assert!(error("[0, \"x\"]").contains("has to be a number"), "{}", error("[0, \"x\"]"));
        assert!(error("[0, nan]").contains("has to be a number, inf or -inf"), "{}", error("[0, nan]"));
    }

    #[test]
    fn what_is_wrong_is_reported() {
        let error = |rest: &str| read(&format!("[[effects]]\n{rest}\n")).unwrap_err();
        let cases = [
            (
                error("family = \"geometrc\""),
                "m.toml:2:10: unknown effect family `geometrc`; did you mean `geometric`? \
                 (known: backlash, base_compliance, coupling, drift, expansion, geometric, guideway, instrument, joint_compliance, \
                 landmarks, link_compliance, load_nonlinearity, observed, polynomial, session, shift, thermal, transmission)",
            ),
            (error("frames = [\"base\"]"), "m.toml:1:1: [[effects]] 1 lacks `family`; add it"),
            (
                error("family = \"joint_compliance\"\njoints = [\"roll\", \"pich\"]"),
                "m.toml:3:19: the robot has no joint `pich`; did you mean `pitch`? \
                 (known: d1, d2, d3, theta, roll, pitch)",
            ),
            (
                error("family = \"geometric\"\nframes = [\"bse\"]"),
                "m.toml:3:11: the robot has no frame `bse`; did you mean `base`? \
                 (known: base, d1, d2, d3, theta, roll, pitch, tool, targets)",
            ),
            (
                error("family = \"joint_compliance\"\njonts = [\"roll\"]"),
                "m.toml:3:1: effect `joint_compliance`: unknown field `jonts`, expected one of `joints`, `own_weight`, `links`, `channel`, `mode`, \
                 `lag`, `lag_range`, `reference`, `offset`, `offset_range`, `ratio`, `ratio_range`; did you mean `joints`?",
            ),
            (
                error("family = \"geometric\"\ncomponents = [\"x\", \"rq\"]"),
                "m.toml:1:1: effect `geometric`: unknown variant `rq`, expected one of `x`, `y`, `z`, `rx`, `ry`, `rz`",
            ),
            (
                error("family = \"joint_compliance\"\njoints = [9]"),
                "m.toml:1:1: effect `joint_compliance` refers to joint 9, but the robot has 6",
            ),
            (
                read("[[effect]]\nfamily = \"geometric\"").unwrap_err(),
                "m.toml:1:3: unknown key `effect` in the model; did you mean `effects`? (known: effects)",
            ),
            (
                read("").unwrap_err(),
                "m.toml: declares no effects; begin with [[effects]] and `family = \"geometric\"`",
            ),
        ];
        for (message, expected) in cases {
            assert_eq!(message, expected);
        }
    }
}
