//! The values of a program's frames and tools.

use super::options::CorrectOptions;
use crate::ControllerError;
use crate::program::{Program, Value};
use crate::reference::Reference;
use std::collections::BTreeSet;
use truepose_kinematics::Pose;

/// Names of the frames and tools of a program's points.
pub(super) fn used(program: &Program) -> [BTreeSet<String>; 2] {
    let mut used: [BTreeSet<String>; 2] = Default::default();
    for point in program.points() {
        if let Value::Pose { frame, tool, .. } = &point.value {
            for (names, reference) in used.iter_mut().zip([frame, tool]) {
                if let Reference::Named(name) = reference {
                    names.insert(program.definitions().last_name(name).to_owned());
                }
            }
        }
    }
    used
}

/// Frames and tools of the options that no point of the programs uses: name, and in words.
pub fn unused(programs: &[Program], options: &CorrectOptions) -> Vec<(String, String)> {
    let all: Vec<[BTreeSet<String>; 2]> = programs.iter().map(used).collect();
    let mut found = Vec::new();
    for (which, given) in [&options.frames, &options.tools].into_iter().enumerate() {
        let names: BTreeSet<&str> = all.iter().flat_map(|used| &used[which]).map(String::as_str).collect();
        let kind = ["frame", "tool"][which];
        let known: Vec<&str> = names.iter().copied().collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        for (name, _) in given.iter().filter(|(name, _)| !names.iter().any(|other| same(other, name))) {
            let words = format!("no point of the program uses the {kind} `{name}` (used by name: {known})");
            found.push((name.clone(), words));
        }
    }
    let given = options.taught.iter().map(|taught| &taught.name).chain(&options.stated);
    let given = given.chain(options.work.iter().map(|(name, _)| name));
    for name in given.filter(|name| !all.iter().flatten().flatten().any(|other| same(other, name))) {
        let words = format!(
            "no point of the program uses the frame or tool `{name}` (--taught, --measured, --cad, --work)"
        );
        found.push((name.clone(), words));
    }
    found
}

/// The frames of points, in the words of tables, that are stated to be taught, measured, or those of a drawing.
pub fn is_stated(name: &str, program: &Program, options: &CorrectOptions) -> bool {
    let name = program.definitions().last_name(name);
    let mut given = options.taught.iter().map(|taught| &taught.name).chain(&options.stated);
    given.any(|other| same(other, name))
}

pub(super) struct Frames<'p> {
    program: &'p Program,
    options: &'p CorrectOptions,
    /// The controller's base in which frames are, in its world: KUKA's $ROBROOT.
    root: Pose,
    /// How many names of frames, and of tools, have no value.
    open: [usize; 2],
}

impl<'p> Frames<'p> {
    /// # Errors
    /// When the controller's base in its world has no usable value.
    pub(super) fn new(program: &'p Program, options: &'p CorrectOptions) -> Result<Self, ControllerError> {
        let root = program.definitions().get("$ROBROOT").map_err(ControllerError::Option)?;
        let mut frames = Frames { program, options, root: root.unwrap_or(Pose::IDENTITY), open: [0, 0] };
        for (which, (names, given)) in used(program).iter().zip([&options.frames, &options.tools]).enumerate()
        {
            let valued = |name: &&String| {
                given.iter().any(|(other, _)| same(name, other))
                    || program.definitions().get(name).is_ok_and(|value| value.is_some())
            };
            frames.open[which] = names.iter().filter(|name| !valued(name)).count();
        }
        Ok(frames)
    }

    /// A frame in the controller's base.
    pub(super) fn frame(&self, reference: &Reference) -> Result<Pose, String> {
        let of_options = (&self.options.frames, self.options.frame);
        let (pose, given) = self.value(reference, 0, of_options.0, of_options.1)?;
        // Frames of the program are in the controller's world, those of the options in its base.
        Ok(if given { pose } else { self.root.inverse() * pose })
    }

    /// A frame in the axes of the unit that carries it.
    pub(super) fn carried(&self, reference: &Reference) -> Result<Pose, String> {
        let Some(name) = self.name(reference) else { return self.frame(reference) };
        if let Some((_, pose)) = self.options.frames.iter().find(|(other, _)| same(other, name)) {
            return Ok(*pose);
        }
        let definitions = self.program.definitions();
        match definitions.excluded(name).map_or_else(|| definitions.carried(name), |words| Err(words.into()))
        {
            Ok(Some(pose)) => Ok(pose),
            Ok(None) => {
                Err(format!("its frame {name} has no value in the files given (--frame \"{name}=…\")"))
            }
            Err(words) => Err(format!("its frame {name} is not known: {words}")),
        }
    }

    /// The value of a frame in its own terms: the controller's world, or of an option its base.
    pub(super) fn stated(&self, reference: &Reference) -> Result<Pose, String> {
        let on = |name: &str| self.options.work.iter().any(|(other, _)| same(other, name));
        if self.name(reference).is_some_and(on) {
            return self.carried(reference);
        }
        self.value(reference, 0, &self.options.frames, self.options.frame).map(|(pose, _)| pose)
    }

    /// A tool in the controller's flange.
    pub(super) fn tool(&self, reference: &Reference) -> Result<Pose, String> {
        self.value(reference, 1, &self.options.tools, self.options.tool).map(|(pose, _)| pose)
    }

    /// The last name of a frame or tool.
    pub(super) fn name<'a>(&'a self, reference: &'a Reference) -> Option<&'a str> {
        match reference {
            Reference::Named(name) => Some(self.program.definitions().last_name(name)),
            _ => None,
        }
    }

    /// The value, and whether it is an option's.
    fn value(
        &self,
        reference: &Reference,
        which: usize,
        named: &[(String, Pose)],
        any: Option<Pose>,
    ) -> Result<(Pose, bool), String> {
        let (kind, option) = [("frame", "--frame"), ("tool", "--tool-frame")][which];
        match reference {
            Reference::Identity => Ok((Pose::IDENTITY, false)),
            Reference::Value(pose) => Ok((*pose, false)),
            Reference::Excluded(words) => Err(words.clone()),
            Reference::Unknown(words) => match any {
                Some(pose) => Ok((pose, true)),
                None => Err(format!("its {kind} is not known: {words} ({option})")),
            },
            Reference::Named(name) => {
                let definitions = self.program.definitions();
                if let Some(words) = definitions.excluded(name) {
                    return Err(words.into());
                }
                let name = definitions.last_name(name);
                if let Some((_, pose)) = named.iter().find(|(other, _)| same(other, name)) {
                    return Ok((*pose, true));
                }
                match definitions.get(name) {
                    Err(words) => Err(format!("its {kind} {name} is not known: {words}")),
                    Ok(Some(pose)) => Ok((pose, false)),
                    Ok(None) => match any {
                        Some(pose) if self.open[which] <= 1 => Ok((pose, true)),
                        Some(_) => Err(format!(
                            "its {kind} {name} has no value in the files given, and {} others neither: name each ({option} \"{name}=…\")",
                            self.open[which] - 1
                        )),
                        None => Err(format!(
                            "its {kind} {name} has no value in the files given ({option} \"{name}=…\")"
                        )),
                    },
                }
            }
        }
    }
}

/// Names without their blanks, in any case: `UF 1` is `UF1`.
pub(super) fn same(a: &str, b: &str) -> bool {
    let plain = |name: &str| name.to_ascii_uppercase().replace(' ', "");
    plain(a) == plain(b)
}
