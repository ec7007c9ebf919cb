//! Studies of several parts on numbered robots: `study NAME [PART…] [--robots N] [--half tuning|locked]`.

use crate::journal::commit;
use crate::prelude::*;
use crate::results::keep;

#[derive(Parser)]
struct Options {
    parts: Vec<String>,
    #[arg(long)]
    robots: Option<u64>,
    #[arg(long, value_enum, default_value = "tuning")]
    half: Half,
}

/// The robots of a part.
pub struct Scope {
    robots: u64,
    /// Whether the robots are those to which nothing is tuned.
    pub locked: bool,
}

impl Scope {
    /// One record a robot, of its number.
    pub fn each<T: Send>(&self, one: impl Fn(u64) -> Outcome<T> + Sync) -> Outcome<Vec<T>> {
        let of = |number| one(number).map_err(|error| format!("robot {number}: {error}").into());
        (0..self.robots).into_par_iter().map(of).collect()
    }
}

/// Runs the requested parts, all of them where none is named, of `parts` with the number of robots of each. The table of each is
/// printed as it is complete.
pub fn run(
    study: &str,
    parts: &[(&'static str, u64)],
    arguments: &[String],
    table: impl Fn(&str, &Scope) -> Outcome<String>,
) -> Outcome {
    let options: Options = parsed(arguments)?;
    let locked = options.half == Half::Locked;
    let known = |word: &String| {
        let part = parts.iter().find(|(name, _)| name == word);
        part.copied().ok_or_else(|| format!("unknown part `{word}`"))
    };
    let mut wanted = options.parts.iter().map(known).collect::<Result<Vec<_>, _>>()?;
    if wanted.is_empty() {
        wanted = parts.to_vec();
    }
    let mut all = String::new();
    let half = options.half.word();
    for (part, count) in wanted {
        let scope = Scope { robots: options.robots.unwrap_or(count), locked };
        let table = table(part, &scope)?;
        let mut text = String::new();
        writeln!(text, "{part}, {half} half, {} robots, commit {}\n{table}", scope.robots, commit())?;
        print(&text);
        all += &(text + "\n");
    }
    keep(study, &folder(study)?.join("table.txt"), &all)
}
