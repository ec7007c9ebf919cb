//! The table and its runner: every `*.toml` beside this file.

use super::changes::{self, Step};
use super::{near, unsound};
use crate::folder::{Folder, Run};
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{LazyLock, OnceLock, mpsc};
use std::time::Duration;
use toml::Value;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub struct Table {
    folders: BTreeMap<String, Recipe>,
    pub group: Vec<Group>,
    /// Kinds of files, and what is run on a spoiled one, which is called `bad` with the same ending. Several commands take turns.
    pub kinds: Vec<(String, Vec<String>)>,
    /// Ways to spoil a file: a name, and a change of its text.
    pub spoils: Vec<Vec<String>>,
    /// One run of each verb and its result, and shells and variables around it.
    pub verbs: Vec<(String, String)>,
    pub shells: Vec<String>,
}

/// How a good folder is made from another one.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Recipe {
    from: String,
    #[serde(rename = "do")]
    steps: Vec<Step>,
    #[serde(skip)]
    made: OnceLock<Folder>,
}

/// Cases with something in common.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    about: String,
    folder: String,
    /// What every case has, unless it has its own; steps come before those of the case.
    #[serde(default)]
    all: toml::Table,
    /// Every case is run with each of these words in the place of `{key}`.
    #[serde(default)]
    variants: Vec<BTreeMap<String, String>>,
    cases: Vec<Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    pub name: String,
    folder: String,
    #[serde(rename = "do", default)]
    steps: Vec<Step>,
    run: String,
    /// More words of the command line.
    #[serde(default)]
    with: String,
    /// The exit code.
    code: Option<i32>,
    /// Errors and warnings, the whole text.
    says: Option<String>,
    /// The beginning of the error, or of the result.
    begins: Option<String>,
    prints: Option<String>,
    /// Words of the messages: all of them, one of them, none of them.
    #[serde(default)]
    contains: Vec<String>,
    #[serde(default)]
    any: Vec<String>,
    #[serde(default)]
    lacks: Vec<String>,
    /// Lines of all messages.
    lines: Option<usize>,
    /// New files; no file changes where the case is refused.
    writes: Option<Vec<String>>,
    /// Another command with the same result and the same files; or one whose JSON is the same to 1e-6.
    like: Option<String>,
    near: Option<String>,
    /// A file through a pipe on standard input.
    stdin: Option<String>,
    /// A script that runs the command, `"$0" "$@"`.
    shell: Option<String>,
    /// No message is expected: the run ends in a result or in one clear error.
    #[serde(default)]
    sound: bool,
    /// Of the slow tests alone.
    #[serde(default)]
    slow: bool,
    #[serde(default = "twenty")]
    seconds: u64,
}

fn twenty() -> u64 {
    20
}

pub fn table() -> &'static Table {
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        let mut all = Table::default();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/hostile");
        let mut files: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        for file in files.iter().filter(|file| file.extension().is_some_and(|ending| ending == "toml")) {
            let part = toml::from_str::<Table>(&std::fs::read_to_string(file).unwrap());
            let mut part = part.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            all.folders.append(&mut part.folders);
            all.group.append(&mut part.group);
            all.kinds.append(&mut part.kinds);
            all.spoils.append(&mut part.spoils);
            all.verbs.append(&mut part.verbs);
            all.shells.append(&mut part.shells);
        }
        all
    });
    &TABLE
}

impl Table {
    /// A copy of a good folder, which is made once for all tests of the process.
    pub fn folder(&self, name: &str) -> Folder {
        let made = match name {
            "empty" => return Folder::empty(),
            "data" => return Folder::with_data(),
            name => {
                let recipe = self.folders.get(name).unwrap_or_else(|| panic!("no folder `{name}`"));
                recipe.made.get_or_init(|| {
                    let folder = self.folder(&recipe.from);
                    let done = recipe.steps.iter().try_for_each(|step| changes::apply(&folder, step));
                    done.unwrap_or_else(|error| panic!("folder `{name}`: {error}"));
                    folder
                })
            }
        };
        let folder = Folder::empty();
        copied(made.path(), folder.path());
        folder
    }
}

fn copied(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let (to, from) = (to.join(entry.file_name()), entry.path());
        if let Ok(link) = std::fs::read_link(&from) {
            std::os::unix::fs::symlink(link, to).unwrap();
        } else if from.is_dir() {
            std::fs::create_dir(&to).unwrap();
            copied(&from, &to);
        } else {
            std::fs::copy(from, to).unwrap();
        }
    }
}

impl Group {
    /// A case with what it has in common with the others, in one of the variants.
    fn case(&self, own: &Value, variant: usize) -> Result<Case, String> {
        let mut case = match own {
            Value::String(line) => toml::Table::from_iter([("run".to_owned(), Value::String(line.clone()))]),
            own => own.clone().try_into().map_err(|error| format!("{own}: {error}"))?,
        };
        for (key, value) in &self.all {
            match (case.get_mut(key), value) {
                (Some(Value::Array(own)), Value::Array(all)) => drop(own.splice(0..0, all.iter().cloned())),
                (Some(_), _) => (),
                (None, value) => drop(case.insert(key.clone(), value.clone())),
            }
        }
        // An expected text for each variant.
        if let Some(Value::Array(each)) = case.get("says") {
            let one = each[variant].clone();
            case.insert("says".into(), one);
        }
        let name =
            case.get("name").or(case.get("run")).and_then(Value::as_str).unwrap_or_default().to_owned();
        let mut words = self.variants.get(variant).cloned().unwrap_or_default();
        words.insert("name".into(), name.clone());
        words.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        case.insert("name".into(), Value::String(name));
        case.insert("folder".into(), Value::String(self.folder.clone()));
        case.iter_mut().for_each(|(_, value)| fill(value, &words));
        Value::Table(case).try_into().map_err(|error| format!("{own}: {error}"))
    }

    /// All cases, with the name of what they have in common.
    pub fn cases(&self) -> Vec<(String, Result<Case, String>)> {
        let variants = 0..self.variants.len().max(1);
        let about = |k: usize| match self.variants.get(k) {
            Some(words) => format!("{} {:?}", self.about, words.values().collect::<Vec<_>>()),
            None => self.about.clone(),
        };
        // Where there are many pairs, each case and each variant is in some of those that are run; the slow tests have all.
        let many = self.cases.len() * self.variants.len() > 20;
        let step = if many && !cfg!(feature = "slow") { self.variants.len().min(4) } else { 1 };
        let chosen =
            |at: usize| variants.clone().filter(move |k| (at + k).is_multiple_of(step)).collect::<Vec<_>>();
        let each = self.cases.iter().enumerate();
        each.flat_map(|(at, case)| chosen(at).into_iter().map(move |k| (about(k), self.case(case, k))))
            .collect()
    }
}

fn fill(value: &mut Value, words: &BTreeMap<String, String>) {
    match value {
        Value::String(text) => {
            words.iter().for_each(|(key, word)| *text = text.replace(&format!("{{{key}}}"), word));
        }
        Value::Array(all) => all.iter_mut().for_each(|value| fill(value, words)),
        _ => (),
    }
}

/// What a run emits besides its result: errors and warnings, without help on the usage.
fn remarks(run: &Run) -> String {
    let log = run.log.split("\n\n").next().unwrap_or_default();
    let of_the_result =
        |line: &&str| ["warning: ", "Check the data first: "].iter().any(|head| line.starts_with(head));
    let warnings = run.out.lines().filter(of_the_result);
    let all = log.lines().filter(|line| !line.starts_with("wrote ")).chain(warnings);
    all.collect::<Vec<_>>().join("\n")
}

/// All files and folders by their names, and what is in the files.
pub type Files = BTreeMap<String, Option<Vec<u8>>>;

pub fn files(folder: &Folder, contents: bool) -> Files {
    let (mut all, mut open) = (Files::new(), vec![folder.path().to_owned()]);
    while let Some(above) = open.pop() {
        for entry in std::fs::read_dir(above).into_iter().flatten().map(|entry| entry.unwrap()) {
            let (path, kind) = (entry.path(), entry.file_type().unwrap());
            let name = path.strip_prefix(folder.path()).unwrap().to_string_lossy().into_owned();
            let read = contents && kind.is_file();
            all.insert(name, read.then(|| std::fs::read(&path).unwrap_or_default()));
            open.extend(kind.is_dir().then_some(path));
        }
    }
    all
}

/// Runs a command line in a folder, by a script and with a file on standard input where there are any, and ends it after some seconds.
pub fn run(folder: &Folder, line: &str, shell: Option<&str>, stdin: Option<&str>, seconds: u64) -> Run {
    let program = env!("CARGO_BIN_EXE_truepose");
    let mut command = Command::new(shell.map_or(program, |_| "sh"));
    shell.map(|script| command.args(["-c", script, program]));
    let words = line.split(' ').filter(|_| !line.is_empty());
    command.current_dir(folder.path()).args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
    let text = stdin.map(|name| std::fs::read(folder.file(name)).unwrap());
    command.stdin(if text.is_some() { Stdio::piped() } else { Stdio::null() });
    let mut child = command.spawn().unwrap();
    let (id, input) = (child.id().to_string(), child.stdin.take());
    let (end, ended) = mpsc::channel::<()>();
    let output = std::thread::scope(|scope| {
        scope.spawn(move || {
            if ended.recv_timeout(Duration::from_secs(seconds)) == Err(mpsc::RecvTimeoutError::Timeout) {
                let _ = Command::new("kill").args(["-KILL", &id]).status();
            }
        });
        // The program may end without reading.
        scope.spawn(move || input.zip(text).map(|(mut input, text)| input.write_all(&text)));
        let output = child.wait_with_output().unwrap();
        drop(end);
        output
    });
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Run {
        command: line.into(),
        code: output.status.code(),
        out: text(&output.stdout),
        log: text(&output.stderr),
    }
}

impl Case {
    /// What is not as expected, if anything is.
    fn problem(&self, folder: &Folder, line: &str) -> Result<(), String> {
        self.steps.iter().try_for_each(|step| changes::apply(folder, step))?;
        let before = files(folder, true);
        let found = run(folder, line, self.shell.as_deref(), self.stdin.as_deref(), self.seconds);
        let after = files(folder, true);
        let new: Vec<&String> = after.keys().filter(|name| !before.contains_key(*name)).collect();
        let check = |right: bool, expected: String| {
            let ended =
                format!("exit code {:?}, new files {new:?}\n{}\n{}", found.code, found.log, found.out);
            if right { Ok(()) } else { Err(format!("expected: {expected}\nfound: {}", short(&ended))) }
        };
        if self.sound {
            let usage = found.code == Some(2) && found.log.contains("Usage: ");
            let outputs: Vec<&str> = self.writes.iter().flatten().map(String::as_str).collect();
            let problem = unsound(&found, &outputs, &before, &after).filter(|_| !usage);
            problem
                .map_or(Ok(()), |problem| check(false, format!("a result or one error, not {problem}")))?;
        }
        let code = self.code.or((!self.sound).then_some(2));
        check(code.is_none_or(|code| found.code == Some(code)), format!("exit code {code:?}"))?;
        let (told, log) = (remarks(&found), &found.log);
        if let Some(says) = &self.says {
            check(told == says.trim_end(), format!("the message\n{says}"))?;
        }
        if let Some(begins) = &self.begins {
            let error = told.lines().rfind(|line| line.starts_with("error: ")).unwrap_or_default();
            check(error.starts_with(begins), format!("an error that begins with\n{begins}"))?;
        }
        let lines = log.lines().count();
        check(
            self.lines.is_none_or(|expected| lines == expected),
            format!("{:?} lines of messages", self.lines),
        )?;
        if let Some(prints) = &self.prints {
            check(found.out.starts_with(prints), format!("a result that begins with\n{prints}"))?;
        }
        check(self.contains.iter().all(|words| log.contains(words)), format!("all of {:?}", self.contains))?;
        check(!self.lacks.iter().any(|words| log.contains(words)), format!("none of {:?}", self.lacks))?;
        let any = self.any.is_empty() || self.any.iter().any(|words| log.contains(words));
        check(any, format!("one of {:?}", self.any))?;
        check(found.code != Some(2) || self.sound || found.out.is_empty(), "no result".into())?;
        if found.code != Some(0) && !(self.sound && found.code == Some(3)) {
            let changed: Vec<_> =
                before.iter().filter(|(name, text)| after.get(*name) != Some(text)).collect();
            check(
                changed.is_empty() && new.is_empty(),
                format!("no file is written; {:?}", changed.first()),
            )?;
        } else if let Some(writes) = self.writes.as_ref().filter(|_| !self.sound) {
            check(new.iter().copied().eq(writes), format!("new files {writes:?}"))?;
        }
        let other = |like: &str| {
            let again = run(folder, like, None, None, self.seconds);
            check(again.code == found.code, format!("what `{like}` gives: {:?} {}", again.code, again.log))?;
            Ok::<_, String>(again)
        };
        if let Some(like) = &self.like {
            let again = other(like)?;
            check(
                again.out == found.out && files(folder, true) == after,
                format!("what `{like}` gives:\n{}", again.out),
            )?;
        }
        if let Some(like) = &self.near {
            let again = other(like)?;
            near::result(&again.out, &found.out)
                .or_else(|at| check(false, format!("what `{like}` gives, but: {at}")))?;
        }
        Ok(())
    }
}

fn short(text: &str) -> String {
    text.chars().take(1500).collect()
}

/// What fails of the whole table, each with its name and command, and the number of cases with these words in them.
pub fn failures(table: &Table, only: &str) -> (Vec<String>, usize) {
    let line = |case: &Case| match &case.with[..] {
        "" => case.run.clone(),
        with => format!("{} {with}", case.run),
    };
    let mut all: Vec<_> = table.group.iter().flat_map(Group::cases).collect();
    all.retain(|(about, case)| {
        case.as_ref().map_or(true, |case| {
            (cfg!(feature = "slow") || !case.slow)
                && format!("{about}: {} {}", case.name, line(case)).contains(only)
        })
    });
    let failure = |(about, case): &(String, Result<Case, String>)| {
        let case = match case {
            Ok(case) => case,
            Err(error) => return Some(format!("{about}: {error}")),
        };
        let line = line(case);
        let problem = case.problem(&table.folder(&case.folder), &line).err()?;
        if problem.starts_with("SKIPPED") {
            println!("{about}: {}: {problem}", case.name);
            return None;
        }
        Some(format!("{about}: {}\ntruepose {}\n{problem}\n", case.name, short(&line)))
    };
    (all.par_iter().filter_map(failure).collect(), all.len())
}
