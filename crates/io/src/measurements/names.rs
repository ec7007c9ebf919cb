//! Headers of a file as names and units of ours: mapped by the user, or in another spelling of the unit.

use super::columns::Role;
use super::constants;
use super::mapping::ColumnMap;
use super::spelled_units::{split_unit, unit_in_words};
use crate::{Quantity, Unit};
use std::borrow::Cow;
use truepose_kinematics::Chain;

/// What headers can mean.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    pub chain: &'a Chain,
    pub map: &'a ColumnMap,
}

/// What a header is.
#[derive(Debug, PartialEq)]
pub(crate) enum Named<'h> {
    /// Left out by the user.
    Ignored,
    /// A header of ours: `name` or `name[unit]`.
    Header(Cow<'h, str>),
}

impl Names<'_> {
    /// The header of ours that a header of the file stands for.
    pub fn resolve<'h>(&self, header: &'h str) -> Named<'h> {
        let (name, unit) = split_unit(header);
        let ColumnMap { names, usual_names, ignore, usual_ignore, .. } = self.map;
        if ignore.iter().any(|word| same(header, word)) {
            return Named::Ignored;
        }
        let usual = usual_names.iter().filter(|(ours, _)| names.iter().all(|(own, _)| own != ours));
        let mapped = names.iter().chain(usual).find(|(_, theirs)| same(header, theirs));
        if mapped.is_none() && usual_ignore.iter().any(|word| same(header, word)) {
            return Named::Ignored;
        }
        if let Some((ours, theirs)) = mapped {
            let unit = unit.or(split_unit(theirs).1).or(unit_in_words(header));
            return Named::Header(match unit {
                Some(unit) => Cow::Owned(format!("{ours}[{unit}]")),
                None => Cow::Owned(ours.clone()),
            });
        }
        // A spelling of our own is left as it is, to the last character.
        if header.contains(['[', ']']) || self.role(header.trim()).is_some() {
            return Named::Header(Cow::Borrowed(header));
        }
        if let Some(unit) = unit
            && let Some(role) = self.role(name)
            && role.quantity(self.chain) == Unit::named(unit).map(|unit| unit.quantity)
        {
            return Named::Header(Cow::Owned(format!("{name}[{unit}]")));
        }
        // Of channels the unit matters where it makes them temperatures.
        if let Some(unit) = unit.filter(|unit| unit.contains('C'))
            && Unit::named(unit).is_some_and(|unit| unit.quantity == Quantity::Temperature)
        {
            return Named::Header(Cow::Owned(format!("{name}[{unit}]")));
        }
        Named::Header(Cow::Borrowed(header))
    }

    /// Entries of the map that match no header of the file, in words, and whether that is a mistake: of an option, not of a robot file that
    /// serves for several tables. A column that the file has under our own name needs no entry of a robot file, and measured columns are
    /// missing where nothing has to be measured.
    pub fn unmatched(&self, headers: &[&str], measured: bool) -> Vec<(bool, String)> {
        let has = |word: &str| headers.iter().any(|header| same(header, word));
        let asked = |column: &String| self.map.asked.contains(column);
        let optional = |name: &str| {
            let role = self.role(name);
            !measured
                && matches!(
                    role,
                    Some(Role::Position(_) | Role::Quaternion(_) | Role::RotationVector(_) | Role::Angle(_))
                )
        };
        let mapped = self.map.names.iter().filter(|(ours, theirs)| {
            !has(theirs)
                && (asked(theirs) || !has(ours))
                && !optional(ours)
                && constants::length((ours, theirs)).is_none()
        });
        let mapped = mapped.map(|(ours, theirs)| {
            let words = format!("`{ours}` is mapped to the column `{theirs}`, which is not in this file");
            (asked(theirs), words)
        });
        let ignored = self.map.ignore.iter().filter(|word| !has(word)).map(|word| {
            (asked(word), format!("the column `{word}` is to be left out, and is not in this file"))
        });
        mapped.chain(ignored).collect()
    }

    /// The meaning of a name, channels apart.
    pub fn role(&self, name: &str) -> Option<Role> {
        if let Some(role) = self.oriented(name) {
            return Some(role);
        }
        Role::of(name, self.chain, 0).ok().filter(|role| !matches!(role, Role::Channel(_)))
    }

    /// The meaning of a name in the convention of the orientations.
    pub fn oriented(&self, name: &str) -> Option<Role> {
        let convention = self.map.orientation?;
        let angle = convention.angle(name).map(Role::Angle);
        angle.or_else(|| convention.quaternion(name).map(Role::Quaternion))
    }

    /// Whether a header of the file has this meaning.
    pub fn means(&self, header: &str, role: Role) -> bool {
        match self.resolve(header) {
            Named::Ignored => false,
            Named::Header(header) => self.role(split_unit(&header).0) == Some(role),
        }
    }

    /// Whether a header of the file has a meaning.
    pub fn knows(&self, header: &str) -> bool {
        match self.resolve(header) {
            Named::Ignored => true,
            Named::Header(header) => self.role(split_unit(&header).0).is_some(),
        }
    }

    /// Whether the cells below a header are texts.
    pub fn is_text(&self, header: &str) -> bool {
        match self.resolve(header) {
            Named::Ignored => true,
            Named::Header(header) => {
                matches!(
                    self.role(split_unit(&header).0),
                    Some(
                        Role::Target
                            | Role::Note
                            | Role::Id
                            | Role::Session
                            | Role::Kind
                            | Role::Landmark
                            | Role::Tool
                    )
                )
            }
        }
    }
}

/// Whether a header is what the user calls so, with its unit or without.
fn same(header: &str, word: &str) -> bool {
    let word = word.trim();
    word == header.trim() || split_unit(word).0 == split_unit(header).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn headers_are_resolved() {
        let chain = samples::scara();
        let map = ColumnMap {
            names: vec![("r1".into(), "Joint 1[°]".into()), ("x".into(), "X (mm)".into())],
            ignore: vec!["Operator".into()],
            ..ColumnMap::default()
        };
        let names = Names { chain: &chain, map: &map };
        let header = |text: &str| match names.resolve(text) {
            Named::Ignored => "-".to_owned(),
            Named::Header(header) => header.into_owned(),
        };
        assert_eq!(header("Joint 1"), "r1[°]");
        assert_eq!(header("Joint 1 [deg]"), "r1[deg]");
        assert_eq!(header("X (mm)"), "x[mm]");
        assert_eq!(header("X"), "x[mm]");
        assert_eq!(header("Operator"), "-");
        assert_eq!(header("y (mm)"), "y[mm]");
        assert_eq!(header("slide mm"), "slide[mm]");
        // No length, so no unit of it.
        assert_eq!(header("slide_deg"), "slide_deg");
        assert_eq!(header("oil (bar)"), "oil (bar)");
        assert_eq!(header("oil (°C)"), "oil[°C]");
        assert_eq!(header("oil (K)"), "oil (K)");
        assert!(names.knows("r2 (°)") && !names.knows("oil (degC)"));
    }
}
