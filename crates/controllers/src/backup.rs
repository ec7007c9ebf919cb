//! The files of a controller's backup: which are programs, which have frames and tools, and which programs share points.

use crate::event::Event;
use crate::{Dialect, Program};
use std::path::Path;

/// What a file of a backup is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A program, or data of one.
    Program,
    /// Frames, tools, loads or the base of the controller: of all programs.
    Table,
    /// Something else.
    Other,
}

/// Frames and tools of every program.
const ALWAYS: [&str; 4] = ["WOBJ0", "TOOL0", "BASE_DATA[0]", "TOOL_DATA[0]"];

impl Dialect {
    /// What a file is to programs of this language, by its name and its text.
    pub fn role(self, path: &Path, text: &[u8]) -> Role {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
        let table = match self {
            Dialect::Krl => name.starts_with('$') && ending == "dat",
            Dialect::Rapid => ending == "cfg",
            Dialect::Fanuc => ending == "va",
            Dialect::Inform => ending == "cnd" || ending == "prm",
            Dialect::UrScript | Dialect::Val3 => false,
        };
        if table {
            // Those that every program has are no facts of this one.
            let own =
                |read: Program| read.definitions().0.keys().any(|name| !ALWAYS.contains(&name.as_str()));
            let own = |read: Program| !read.points().is_empty() || own(read);
            return if Program::read(text, &[], self).is_ok_and(own) { Role::Table } else { Role::Other };
        }
        // Routines of the controller's maker.
        let system = self == Dialect::Krl
            && path
                .parent()
                .and_then(Path::file_name)
                .is_some_and(|folder| folder.eq_ignore_ascii_case("system"));
        match Dialect::of_file(path) {
            Ok(dialect) if dialect == self && !system => Role::Program,
            _ => Role::Other,
        }
    }
}

/// Whether a program's text calls the program of this name, which may select frames, tools and loads: of FANUC, where the values of these are in files of
/// their own.
pub fn calls(dialect: Dialect, text: &[u8], name: &str) -> bool {
    let (text, name) = (String::from_utf8_lossy(text).to_uppercase(), name.to_uppercase());
    let word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    let called = |at: usize| {
        let (before, behind) = (&text[..at], &text[at + name.len()..]);
        let verb = ["CALL", "AUFRUF", "RUN"].iter().any(|verb| before.trim_end().ends_with(verb));
        verb && !before.ends_with(word) && !behind.starts_with(word)
    };
    dialect == Dialect::Fanuc && text.match_indices(&name).any(|(at, _)| called(at))
}

/// Groups of files, each read with all others ([`Program::read_all`]), between which motions go to points: they are compensated together
/// or not at all. Files without a motion and without a point are in none.
pub fn linked(programs: &[Program]) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..programs.len()).collect();
    let mut moves = vec![false; programs.len()];
    for (owner, program) in programs.iter().enumerate() {
        moves[owner] |= !program.points().is_empty();
        for (place, events) in program.route.iter().enumerate() {
            // The others follow in their order.
            let file = if place == 0 { owner } else { place - usize::from(place <= owner) };
            let mut visits = events.iter().filter_map(|event| match event {
                Event::Visit(visit) => Some(visit),
                _ => None,
            });
            moves[file] |= visits.clone().next().is_some();
            if visits.any(|visit| !visit.points.is_empty()) && group[file] != group[owner] {
                let (from, to) = (group[file], group[owner]);
                group.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
            }
        }
    }
    let mut all: Vec<Vec<usize>> = vec![Vec::new(); programs.len()];
    (0..programs.len()).filter(|&k| moves[k]).for_each(|k| all[group[k]].push(k));
    all.retain(|group| !group.is_empty());
    all.sort();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_between_which_motions_go_are_one_group() {
        let place = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
        let data = |name: &str| format!("MODULE D\nCONST robtarget {name}:={place};\nENDMODULE\n");
        let job =
            |name: &str| format!("MODULE J\nPROC a()\nMoveL {name},v1,fine,tool0;\nENDPROC\nENDMODULE\n");
        let texts = [job("p2"), data("p1"), "MODULE E\nENDMODULE\n".into(), data("p2"), job("p1"), job("p9")];
        let texts: Vec<&[u8]> = texts.iter().map(String::as_bytes).collect();
        let programs = Program::read_all(&texts, Dialect::Rapid).expect("programs");
        assert_eq!(linked(&programs), [vec![0, 3], vec![1, 4], vec![5]]);
    }

    #[test]
    fn calls_are_those_of_the_whole_name() {
        let of = |text: &str| calls(Dialect::Fanuc, text.as_bytes(), "Init");
        assert!(of(" 1:  CALL INIT ;\n") && of(" 2:  IF R[1]=1,CALL INIT(3) ;"));
        assert!(!of(" 1:  CALL INIT_2 ;\n") && !of(" 1:  !INIT ;\n") && !of(" 1:  CALL A-INIT ;"));
    }

    #[test]
    fn files_are_told_apart_by_their_names_and_texts() {
        let of = |dialect: Dialect, name: &str, text: &str| dialect.role(Path::new(name), text.as_bytes());
        let tool = "//TOOL 1\n///NAME A\n1,2,3,0,0,0\n";
        assert_eq!(of(Dialect::Inform, "a/TOOL.CND", tool), Role::Table);
        assert_eq!(of(Dialect::Inform, "a/WEAV.CND", "//WEAV 1\n"), Role::Other);
        assert_eq!(of(Dialect::Inform, "a/JOB1.JBI", "/JOB\n"), Role::Program);
        assert_eq!(of(Dialect::Inform, "a/JOB1.LST", "/JOB\n"), Role::Other);
        assert_eq!(of(Dialect::Krl, "R1/Program/job.SRC", ""), Role::Program);
        assert_eq!(of(Dialect::Krl, "R1/System/bas.src", ""), Role::Other);
        let config = "BASE_DATA[1]={X 1,Y 2,Z 3,A 0,B 0,C 0}\n";
        assert_eq!(of(Dialect::Krl, "R1/System/$config.dat", config), Role::Table);
        assert_eq!(of(Dialect::Krl, "R1/System/$custom.dat", "DEFDAT $CUSTOM\nENDDAT\n"), Role::Other);
        assert_eq!(
            of(
                Dialect::Rapid,
                "SYSPAR/MOC.cfg",
                "MOC:CFG_1.0::\nROBOT:\n  -name \"R\" -base_frame_pos_z 0.5\n"
            ),
            Role::Table
        );
        assert_eq!(of(Dialect::Rapid, "SYSPAR/EIO.cfg", "EIO:CFG_1.0::\n"), Role::Other);
    }
}
