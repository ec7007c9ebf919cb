//! Files as types of arguments: what a verb reads and writes is collected from what was parsed, so that no argument can be forgotten.

use clap::builder::{PathBufValueParser, TypedValueParser, ValueParser, ValueParserFactory};
use clap::{Arg, ArgMatches, Command};
use std::any::{Any, TypeId};
use std::ops::Deref;
use std::path::{Path, PathBuf};

/// A file of an argument.
macro_rules! file {
    ($(#[$about:meta])* $name:ident) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct $name(PathBuf);

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }

        impl AsRef<Path> for $name {
            fn as_ref(&self) -> &Path {
                &self.0
            }
        }

        impl<P: Into<PathBuf>> From<P> for $name {
            fn from(path: P) -> Self {
                $name(path.into())
            }
        }
    };
}

file! {
    /// A file that is read; `-` is standard input, where the system has a file for it.
    Input
}
file! {
    /// A file that is written.
    Output
}
file! {
    /// A folder into which files are written.
    OutputFolder
}
file! {
    /// A file that is read where it exists, and written again.
    Record
}

/// What coefficients are shrunk towards.
#[derive(Debug, Clone, PartialEq)]
pub enum Prior {
    /// Expected sizes, so strongly.
    Sizes(truepose_identify::PriorStrength),
    /// The robots of a fleet, in this file.
    Fleet(Input),
}

/// A frame or tool of a program, and the file of the points at which it was taught.
#[derive(Debug, Clone, PartialEq)]
pub struct TaughtFrom {
    /// Of the frame or tool.
    pub name: String,
    /// The points.
    pub file: Input,
    /// The tool that touched, where it is named.
    pub tool: Option<String>,
}

impl Prior {
    /// How strongly expected sizes count where there is no fleet.
    pub fn strength(&self) -> truepose_identify::PriorStrength {
        match self {
            Prior::Sizes(strength) => *strength,
            Prior::Fleet(_) => truepose_identify::PriorStrength::VarianceGroups,
        }
    }
}

impl ValueParserFactory for Input {
    type Parser = ValueParser;

    fn value_parser() -> ValueParser {
        let stdin = |file: PathBuf| {
            Input(if cfg!(unix) && file == Path::new("-") { "/dev/stdin".into() } else { file })
        };
        PathBufValueParser::new().map(stdin).into()
    }
}

impl ValueParserFactory for Output {
    type Parser = ValueParser;

    fn value_parser() -> ValueParser {
        PathBufValueParser::new().map(Output).into()
    }
}

impl ValueParserFactory for OutputFolder {
    type Parser = ValueParser;

    fn value_parser() -> ValueParser {
        PathBufValueParser::new().map(OutputFolder).into()
    }
}

impl ValueParserFactory for Record {
    type Parser = ValueParser;

    fn value_parser() -> ValueParser {
        PathBufValueParser::new().map(Record).into()
    }
}

/// A file with the argument that names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// `--data`, `FIT`.
    pub option: String,
    /// Where it is.
    pub path: PathBuf,
    /// Whether it is read and written again.
    pub again: bool,
}

impl NamedFile {
    /// A file that is read, or written.
    pub fn new(option: &str, path: impl Into<PathBuf>) -> Self {
        NamedFile { option: option.into(), path: path.into(), again: false }
    }
}

/// The files of a parsed command line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// What is read, and not written.
    pub read: Vec<NamedFile>,
    /// What is written, or read and written again.
    pub written: Vec<NamedFile>,
    /// Folders into which is written.
    pub folders: Vec<NamedFile>,
}

impl Files {
    /// Of a verb, in the order of its arguments.
    pub fn of(command: &Command, matches: &ArgMatches) -> Self {
        let mut files = Files::default();
        let verb = matches.subcommand().and_then(|(name, of)| Some((command.find_subcommand(name)?, of)));
        let Some((verb, matches)) = verb else { return files };
        for argument in verb.get_arguments() {
            let option = name(argument);
            let named = |path: &Path| NamedFile::new(&option, path);
            files.read.extend(values::<Input>(argument, matches).map(|file| named(file)));
            files.read.extend(values::<Prior>(argument, matches).filter_map(|prior| match prior {
                Prior::Fleet(file) => Some(named(file)),
                Prior::Sizes(_) => None,
            }));
            files.read.extend(values::<TaughtFrom>(argument, matches).map(|taught| named(&taught.file)));
            files.written.extend(values::<Output>(argument, matches).map(|file| named(file)));
            files.written.extend(
                values::<Record>(argument, matches).map(|file| NamedFile { again: true, ..named(file) }),
            );
            files.folders.extend(values::<OutputFolder>(argument, matches).map(|file| named(file)));
        }
        files
    }
}

/// The values of an argument, if they are of this type.
fn values<'a, T: Any + Clone + Send + Sync>(
    argument: &Arg,
    matches: &'a ArgMatches,
) -> impl Iterator<Item = &'a T> {
    let ours = argument.get_value_parser().type_id() == TypeId::of::<T>();
    let found =
        if ours { matches.try_get_many::<T>(argument.get_id().as_str()).ok().flatten() } else { None };
    found.into_iter().flatten()
}

/// As messages name it.
fn name(argument: &Arg) -> String {
    match argument.get_long() {
        Some(long) => format!("--{long}"),
        None => argument
            .get_value_names()
            .and_then(|names| names.first())
            .map_or_else(|| argument.get_id().to_string(), |name| name.to_string()),
    }
}

/// With every output in this folder, whatever the arguments say: `FOLDER/OPTION-NAME` of a file, `FOLDER/OPTION` of a folder.
pub fn redirected(command: Command, into: &Path) -> Command {
    let one = |argument: Arg| {
        let (id, folder) = (argument.get_id().to_string(), into.to_path_buf());
        let own = move |file: &Path| {
            let short = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            folder.join(format!("{id}-{short}"))
        };
        let of = argument.get_value_parser().type_id();
        if of == TypeId::of::<Output>() {
            argument.value_parser(PathBufValueParser::new().map(move |file| Output(own(&file))))
        } else if of == TypeId::of::<Record>() {
            argument.value_parser(PathBufValueParser::new().map(move |file| Record(own(&file))))
        } else if of == TypeId::of::<OutputFolder>() {
            let folder = into.join(argument.get_id().as_str());
            argument.value_parser(PathBufValueParser::new().map(move |_| OutputFolder(folder.clone())))
        } else {
            argument
        }
    };
    command.mut_args(one).mut_subcommands(|verb| redirected(verb, into))
}

#[cfg(test)]
mod tests {
    use super::super::Args;
    use super::*;

    fn of(words: &[&str]) -> Files {
        let words: Vec<String> = words.iter().map(ToString::to_string).collect();
        Args::recorded(&words, None).unwrap().files
    }

    fn options(files: &[NamedFile]) -> Vec<&str> {
        files.iter().map(|file| file.option.as_str()).collect()
    }

    #[test]
    fn files_are_collected_by_their_types() {
        let plan =
            of(&["plan", "--observe", "r.toml", "--model", "m.toml", "--among", "d.csv", "--out", "p.csv"]);
        assert_eq!(options(&plan.read), ["--observe", "--among", "--model"]);
        assert_eq!(options(&plan.written), ["--out"]);
        let prior = of(&["identify", "--robot", "r", "--data", "-", "--prior", "a.json", "--report", "x"]);
        assert_eq!(options(&prior.read), ["--robot", "--data", "--prior"]);
        assert_eq!(options(&prior.folders), ["--report"]);
        let words = "compensate --fit f --program j.ls --taught UF1=p.csv,UT9 --out o.ls";
        let taught = of(&words.split(' ').collect::<Vec<_>>());
        assert_eq!(options(&taught.read), ["--fit", "--program", "--taught"]);
        let fleet = of(&["fleet", "a.json", "b.json", "--out", "c.json"]);
        assert_eq!(options(&fleet.read), ["FIT", "FIT"]);
        let monitor = of(&["monitor", "--fit", "f", "--data", "d", "--history", "h", "--page", "p"]);
        assert_eq!(options(&monitor.written), ["--history", "--page"]);
    }

    #[test]
    fn every_argument_that_names_a_file_has_a_type_of_one() {
        let types = [
            TypeId::of::<Input>(),
            TypeId::of::<Output>(),
            TypeId::of::<OutputFolder>(),
            TypeId::of::<Record>(),
            TypeId::of::<Prior>(),
            TypeId::of::<TaughtFrom>(),
        ];
        for verb in Args::whole().get_subcommands() {
            for argument in verb.get_arguments() {
                let of = argument.get_value_parser().type_id();
                let names = argument.get_value_names().unwrap_or_default();
                let named = names.iter().any(|name| ["FILE", "DIR", "FIT"].contains(&name.as_str()));
                let typed = types.iter().any(|known| of == *known);
                let (verb, argument) = (verb.get_name(), name(argument));
                assert!(of != TypeId::of::<PathBuf>(), "{verb} {argument}: a path is Input or Output");
                assert!(typed || !named, "{verb} {argument}: names a file");
            }
        }
    }

    #[test]
    fn outputs_are_redirected_whatever_they_are_called() {
        let words = ["discover", "--robot", "r", "--data", "d", "--out", "x/f.json", "--rivals=mine"];
        let words: Vec<String> = words.iter().map(ToString::to_string).collect();
        let files = Args::recorded(&words, Some(Path::new("own"))).unwrap().files;
        assert_eq!(files.written[0].path, Path::new("own/out-f.json"));
        assert_eq!(files.folders[0].path, Path::new("own/rivals"));
        assert_eq!(files.read[1].path, Path::new("d"));
    }
}
