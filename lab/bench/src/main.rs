#![doc = include_str!("../README.md")]

mod arguments;
mod child;
mod discovery;
mod growth;
mod peaks;
mod prelude;
mod robots;
mod runner;
mod summary;
mod table;
mod workload;
mod workloads;

use arguments::Arguments;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use truepose_micro::clock;
use workload::Failure;

/// A line to the terminal, or to the process that asked.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{text}");
    let _ = out.flush();
}

/// Prints the processor, the threads, and the load then and now.
pub fn say_machine(threads: &str, before: f64) {
    let (processor, after) = (clock::processor(), clock::load());
    say(&format!("{processor}, {threads}; load {before:.1} at the beginning, {after:.1} at the end"));
}

fn run() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.max(1)).build_global()?;
    if let [workload, way] = &arguments.serve[..] {
        let found = workloads::ALL.iter().find(|w| w.name == workload);
        let declared = found.and_then(|w| w.ways.iter().find(|d| d.name == way));
        let prepare = declared.ok_or(format!("there is no way `{way}` of `{workload}`"))?.prepare;
        return child::serve(prepare(&arguments.data)?);
    }
    match arguments.only.as_slice() {
        [only] if only == "growth" => growth::run(&arguments.figure),
        [only] if only == "breadth" => discovery::breadth(arguments.most_joints, arguments.threads),
        [only] if only == "discover" => discovery::rows(arguments.most_rows, arguments.threads),
        _ => runner::run(&arguments),
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr().lock(), "error: {error}");
            ExitCode::from(2)
        }
    }
}
