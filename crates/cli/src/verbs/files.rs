//! Which files a run reads and writes: nothing that it reads is overwritten, and nothing is written twice.

use super::program::table_of;
use crate::args::{Measured, Prior, Verb};
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use truepose_io::{robot_files, same_file};

/// A file with the option that names it.
type Named<'a> = (&'static str, &'a Path);

/// Refuses a run that would write over its own input or output, before anything is read.
pub fn apart(verb: &Verb) -> Result<(), Failure> {
    let (mut read, written) = named(verb);
    once(&read)?;
    let robot = read.iter().find(|(option, _)| *option == "--robot").map(|(_, file)| robot_files(file));
    read.extend(robot.iter().flatten().skip(1).map(|file| ("the robot's `urdf`", file.as_path())));
    for &(folder, path) in written.iter().filter(|(option, _)| FOLDERS.contains(option)) {
        for (other, file) in read.iter().chain(written.iter().filter(|(option, _)| !FOLDERS.contains(option)))
        {
            if may_be_written(folder, path, file) {
                let words = format!(
                    "a file in `{}` may get the name of `{}`, which {other} names; name another folder",
                    path.display(),
                    file.display()
                );
                return refused(folder, words);
            }
        }
    }
    let mut whole: Vec<(&str, PathBuf)> = Vec::new();
    for &(option, file) in &written {
        if file == Path::new("-") {
            return refused(
                option,
                "`-` does not stand for standard output; name a file, or /dev/stdout".into(),
            );
        }
        kept(option, file, &read)?;
        for (other, theirs) in &whole {
            let folders = FOLDERS.contains(&option) && FOLDERS.contains(other);
            if same_file(file, theirs) && !folders {
                let words = format!("`{}` is written by {other} as well; name another file", file.display());
                return refused(option, words);
            }
        }
        whole.push((option, file.into()));
        if option == "--report" {
            for name in PAGE {
                kept(option, &file.join(name), &read)?;
                whole.push((option, file.join(name)));
            }
        }
    }
    if let Verb::Compensate(of) = verb
        && of.robot_program.program.is_some()
    {
        kept("--out", &table_of(&of.out), &read)?;
    }
    Ok(())
}

/// Refuses to read twice what can be read once.
fn once(read: &[Named<'_>]) -> Result<(), Failure> {
    for (k, (option, file)) in read.iter().enumerate() {
        let special = file.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir());
        if let Some((other, _)) = read[..k].iter().find(|(_, other)| special && other == file) {
            let words = format!("`{}` is read by {other} already, and can be read only once", file.display());
            return refused(option, words);
        }
    }
    Ok(())
}

/// Refuses to write one of the files that are read.
pub fn kept(option: &str, file: &Path, read: &[Named<'_>]) -> Result<(), Failure> {
    match read.iter().find(|(_, other)| same_file(file, other)) {
        Some((other, _)) => {
            let file = file.display();
            refused(
                option,
                format!("`{file}` is what {other} reads, and would be overwritten; name another file"),
            )
        }
        None => Ok(()),
    }
}

/// Options that name a folder into which files are written.
const FOLDERS: [&str; 2] = ["--report", "--rivals"];

/// Whether a run may write this file into a folder, besides those of [`PAGE`]: figures of a report (`NAME.svg`) and rivals (`NUMBER-NAME.json`),
/// whose names only the result has.
fn may_be_written(option: &str, folder: &Path, file: &Path) -> bool {
    let target = file.canonicalize().unwrap_or_else(|_| file.into());
    [file, &target].into_iter().any(|file| {
        let Some(name) = file.file_name().map(|name| name.to_string_lossy().to_lowercase()) else {
            return false;
        };
        let above = file.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let named = match option {
            "--report" => name.ends_with(".svg"),
            _ => {
                let number = name.split('-').next().unwrap_or("");
                let numbered = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
                numbered && number.len() < name.len() && name.ends_with(".json")
            }
        };
        named && same_file(above, folder)
    })
}

/// Files of a report, whichever verb writes it.
const PAGE: [&str; 11] = [
    "index.html",
    "summary.html",
    "run.json",
    "identification.json",
    "discovery.json",
    "comparison.json",
    "compensation.json",
    "map.json",
    "plan.json",
    "prediction.json",
    "acceptance.json",
];

fn refused(option: &str, words: String) -> Result<(), Failure> {
    Err(Failure::Input(format!("{option}: {words}")))
}

/// What a verb reads, and what it writes; the folder of a report first, so that the message names the other file.
pub fn named(verb: &Verb) -> (Vec<Named<'_>>, Vec<Named<'_>>) {
    fn list<'a>(all: &[(&'static str, Option<&'a PathBuf>)]) -> Vec<Named<'a>> {
        all.iter().filter_map(|(option, file)| Some((*option, file.as_ref()?.as_path()))).collect()
    }
    fn measured(of: &Measured) -> Vec<Named<'_>> {
        list(&[
            ("--robot", Some(&of.robot.robot)),
            ("--data", Some(&of.data)),
            ("--model", of.model.as_ref()),
        ])
    }
    fn with<'a>(mut read: Vec<Named<'a>>, certificate: Option<&'a PathBuf>) -> Vec<Named<'a>> {
        read.extend(certificate.map(|file| ("--certificate", file.as_path())));
        read
    }
    fn with_fleet<'a>(mut read: Vec<Named<'a>>, prior: &'a Prior) -> Vec<Named<'a>> {
        if let Prior::Fleet(file) = prior {
            read.push(("--prior", file.as_path()));
        }
        read
    }
    match verb {
        Verb::Identify(of) => (
            with(with_fleet(measured(&of.measured), &of.prior), of.certificate.as_ref()),
            list(&[
                ("--report", of.report.as_ref()),
                ("--out", of.out.as_ref()),
                ("--parameters", of.parameters.as_ref()),
            ]),
        ),
        Verb::Discover(of) => (
            with(measured(&of.measured), of.certificate.as_ref()),
            list(&[
                ("--report", of.report.as_ref()),
                ("--rivals", of.rivals.as_ref()),
                ("--out", of.out.as_ref()),
                ("--parameters", of.parameters.as_ref()),
            ]),
        ),
        Verb::Compare(of) => (measured(&of.measured), list(&[("--report", of.report.as_ref())])),
        Verb::Plan(of) => (
            list(&[
                ("--robot", of.robot.as_ref()),
                ("--fit", of.fit.as_ref()),
                ("--rival", of.rival.as_ref()),
                ("--at", of.at.as_ref()),
                ("--certificate", of.certificate.as_ref()),
            ]),
            list(&[("--report", of.report.as_ref()), ("--out", Some(&of.out))]),
        ),
        Verb::Predict(of) => (
            list(&[
                ("--fit", Some(&of.fit)),
                ("--data", Some(&of.data)),
                ("--certificate", of.certificate.as_ref()),
            ]),
            list(&[("--report", of.report.as_ref()), ("--out", Some(&of.out))]),
        ),
        Verb::Compensate(of) => (
            {
                let mut read = list(&[
                    ("--fit", Some(&of.fit)),
                    ("--poses", of.poses.as_ref()),
                    ("--joints", of.joints.as_ref()),
                    ("--program", of.robot_program.program.as_ref()),
                    ("--frames", of.frames.as_ref()),
                    ("--certificate", of.certificate.as_ref()),
                ]);
                read.extend(of.robot_program.with.iter().map(|file| ("--with", file.as_path())));
                read
            },
            list(&[("--report", of.report.as_ref()), ("--out", Some(&of.out))]),
        ),
        Verb::Export(of) => (
            list(&[("--fit", Some(&of.fit)), ("--urdf", of.urdf.as_ref()), ("--like", of.like.as_ref())]),
            list(&[("--out", Some(&of.out))]),
        ),
        Verb::Map(of) => (
            list(&[("--fit", Some(&of.fit)), ("--certificate", of.certificate.as_ref())]),
            list(&[("--report", of.report.as_ref()), ("--out", Some(&of.out))]),
        ),
        Verb::Iso9283(of) => (
            list(&[
                ("--robot", of.robot.as_ref()),
                ("--data", Some(&of.data)),
                ("--fit", of.fit.as_ref()),
                ("--certificate", of.certificate.as_ref()),
            ]),
            list(&[("--report", of.report.as_ref())]),
        ),
        Verb::Transfer(of) => {
            (list(&[("--fit", Some(&of.fit)), ("--data", Some(&of.data))]), list(&[("--out", Some(&of.out))]))
        }
        Verb::Fleet(of) => {
            (of.fits.iter().map(|fit| ("FIT", fit.as_path())).collect(), list(&[("--out", Some(&of.out))]))
        }
        // A history is read and written again.
        Verb::Monitor(of) => (
            list(&[("--fit", Some(&of.fit)), ("--data", Some(&of.data))]),
            list(&[("--history", of.history.as_ref()), ("--page", of.page.as_ref())]),
        ),
        Verb::Simulate(of) => (
            list(&[("--plant", Some(&of.plant))]),
            list(&[("--out", Some(&of.out)), ("--truth", of.truth.as_ref())]),
        ),
        Verb::Check(of) => (
            list(&[
                ("--robot", Some(&of.robot.robot)),
                ("--data", of.data.as_ref()),
                ("--model", of.model.as_ref()),
            ]),
            Vec::new(),
        ),
        Verb::Init(of) => (Vec::new(), list(&[("--out", of.out.as_ref()), ("--csv", of.csv.as_ref())])),
        Verb::Effects(_) | Verb::Verify(_) | Verb::Completions(_) => (Vec::new(), Vec::new()),
    }
}
