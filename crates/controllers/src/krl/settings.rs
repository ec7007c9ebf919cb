//! What sets frame, tool, load and mode.

use super::aggregate::Aggregate;
use super::candidate::pose;
use super::file::{FIXED_TOOL, Reader, name};
use crate::ControllerError;
use crate::definitions::Definition;
use crate::flow::{FRAME, LOAD, TOOL};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind};
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

impl<'t> Reader<'t> {
    /// `#TCP`, `#BASE`.
    pub(super) fn mode(&mut self, at: &mut Cursor<'t>) {
        at.take(b'#');
        let on_robot = at.word().is_some_and(|word| word.eq_ignore_ascii_case("BASE"));
        let to = if on_robot { Reference::Identity } else { Reference::Excluded(FIXED_TOOL.into()) };
        self.mode.set(FRAME, to);
    }

    /// `LOAD_DATA[1]={M 12.0,CM {X 0.0,Y 0.0,Z 80.0,A …},J {…}}`.
    pub(super) fn load(&mut self, name: &str, aggregate: &Aggregate<'_>) {
        let definition = match self.mass(aggregate) {
            Some((mass, _)) if mass < 0.0 => {
                Definition::Unusable(format!("{name} is the largest load (M is negative)"))
            }
            Some((mass, com)) => Definition::Load(mass, com),
            None => Definition::Unusable(format!("{name} is not made of numbers")),
        };
        self.file.definitions.push((name.into(), definition));
    }

    /// Mass and centre of gravity, m.
    fn mass(&self, aggregate: &Aggregate<'_>) -> Option<(f64, Vector3<f64>)> {
        let center = aggregate.entry("CM")?.tokens;
        let mut at = Cursor::new(self.text, center);
        let center =
            if at.take(b'{') { Aggregate::read(&mut at, aggregate.line).ok()? } else { return None };
        let [x, y, z] = ["X", "Y", "Z"].map(|name| center.value(name));
        Some((aggregate.value("M")?, 1e-3 * Vector3::new(x?, y?, z?)))
    }

    /// `BAS(#BASE,2)`.
    pub(super) fn bas(&mut self, at: &mut Cursor<'t>) {
        at.word();
        at.take(b'(');
        at.take(b'#');
        let what = at.word().map(str::to_ascii_uppercase);
        let which = match what.as_deref() {
            Some("BASE" | "EX_BASE") => FRAME,
            Some("TOOL") => TOOL,
            _ => return,
        };
        let list = if which == FRAME { "BASE_DATA" } else { "TOOL_DATA" };
        at.take(b',');
        let to = match at.number() {
            Some((number, _)) if what.as_deref() == Some("EX_BASE") && at.take(b')') => {
                self.on_kinematics(format!("EX_AX_DATA[{number:.0}].OFFSET"))
            }
            Some((number, _)) if at.take(b')') => Reference::Named(format!("{list}[{number:.0}]")),
            _ => Reference::Unknown("its number is computed".into()),
        };
        if which == TOOL {
            let load = match &to {
                Reference::Named(name) => Reference::Named(name.replace("TOOL_DATA", "LOAD_DATA")),
                unknown => unknown.clone(),
            };
            self.flow.set(LOAD, load);
        }
        self.flow.set(which, to);
    }

    /// The right side of `$BASE =`.
    pub(super) fn reference(
        &mut self,
        at: &mut Cursor<'t>,
        which: usize,
    ) -> Result<Reference, ControllerError> {
        let line = at.peek().map_or(0, |token| token.line);
        let found = if at.take(b'{') {
            let aggregate = Aggregate::read(at, line)?;
            if which == LOAD {
                let name = format!("$LOAD in line {line}");
                self.load(&name, &aggregate);
                return Ok(Reference::Named(name));
            }
            match pose(&aggregate) {
                Some(pose) => self.unnamed(which, pose, line),
                None => Reference::Unknown(format!("its value in line {line} is incomplete or computed")),
            }
        } else {
            match name(at).as_deref() {
                Some("$NULLFRAME") => Reference::Identity,
                Some("STOOL2" | "STOOL" | "SBASE" | "SLOAD") if at.take(b'(') => {
                    let data = name(at).unwrap_or_default();
                    at.skip_closed();
                    let part = ["BASE_NO", "TOOL_NO", "LOAD_NO"][which];
                    Reference::Named(format!("{data}.{part}"))
                }
                Some("EK") if at.take(b'(') => self.kinematics(at),
                Some(name) => Reference::Named(name.into()),
                None => Reference::Unknown("its value is computed".into()),
            }
        };
        let ends = at.peek().is_none_or(|token| token.kind == Kind::End || token.is(b','));
        Ok(if ends { found } else { Reference::Unknown("its value is computed".into()) })
    }

    /// The arguments of `EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,BASE_DATA[3])`: the last is the frame in the axes of the external kinematics.
    fn kinematics(&mut self, at: &mut Cursor<'t>) -> Reference {
        let (mut last, mut plain) = (None, true);
        while let Some(token) = at.peek().filter(|token| token.kind != Kind::End) {
            if at.take(b')') {
                break;
            }
            if token.kind == Kind::Word {
                let mut whole = name(at).unwrap_or_default();
                while at.take(b'.') {
                    whole = format!("{whole}.{}", name(at).unwrap_or_default());
                }
                last = Some(whole);
            } else {
                plain &= token.is(b',');
                at.at += 1;
            }
        }
        match last.filter(|_| plain) {
            Some(name) => self.on_kinematics(name),
            None => Reference::Unknown("its value is computed".into()),
        }
    }

    fn on_kinematics(&mut self, frame: String) -> Reference {
        let name = format!("EK({frame})");
        let value = Definition::Carried(Reference::Named(frame));
        if !self.file.definitions.iter().any(|(other, _)| *other == name) {
            self.file.definitions.push((name.clone(), value));
        }
        Reference::Named(name)
    }

    /// A frame without a name is that of the first line that sets its value.
    fn unnamed(&mut self, which: usize, pose: Pose, line: usize) -> Reference {
        let kind = ["$BASE in line ", "$TOOL in line "][which];
        let value = Definition::Value(pose);
        let same = |(name, other): &&(String, Definition)| name.starts_with(kind) && *other == value;
        if let Some((name, _)) = self.file.definitions.iter().find(same) {
            return Reference::Named(name.clone());
        }
        let name = format!("{kind}{line}");
        self.file.definitions.push((name.clone(), value));
        Reference::Named(name)
    }

    /// `FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}`.
    pub(super) fn frame_data(&mut self, name: &str, aggregate: &Aggregate<'_>) {
        let still = aggregate.entry("IPO_FRAME").is_some_and(|entry| {
            entry
                .tokens
                .last()
                .is_some_and(|token| self.text[token.range.clone()].eq_ignore_ascii_case(b"TCP"))
        });
        for (part, list) in [("BASE_NO", "BASE_DATA"), ("TOOL_NO", "TOOL_DATA"), ("LOAD_NO", "LOAD_DATA")] {
            let number = if part == "LOAD_NO" { "TOOL_NO" } else { part };
            let definition = match aggregate.value(number) {
                _ if still => Definition::Excluded(format!(
                    "the tool stands still (IPO_FRAME #TCP in {name}), which is not compensated"
                )),
                Some(number) => Definition::SameAs(format!("{list}[{number:.0}]")),
                None => Definition::Unusable(format!("{name} has no {number}")),
            };
            self.file.definitions.push((format!("{name}.{part}"), definition));
        }
    }
}
