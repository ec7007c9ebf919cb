//! A process that does one workload one way, as often as it is told: a peer, or this program.
//!
//! Both speak the same lines: `run N` does the work N times and answers `{"cpu": […], "wall": […]}` in seconds, `check`
//! answers `{"answer": {…}, "peak_mb": …}`. So each side has a process of its own, with its own peak of memory, and its data
//! stays loaded between rounds.

use crate::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Lines, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Seconds of some runs.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
pub struct Times {
    /// Of the process, on all of its threads.
    pub cpu: Vec<f64>,
    /// On the wall.
    pub wall: Vec<f64>,
}

/// What came of it.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
pub struct Checked {
    /// Numbers by name.
    pub answer: Answer,
    /// Largest resident memory, MB.
    pub peak_mb: f64,
    /// The same when the data had been read and nothing done.
    #[serde(default)]
    pub before_mb: f64,
}

/// The other side of the lines.
pub struct Process {
    child: Child,
    to: ChildStdin,
    from: Lines<BufReader<ChildStdout>>,
    /// What it said when it was ready.
    pub ready: Value,
}

impl Process {
    /// Starts it and waits until its data has been read.
    pub fn start(command: &mut Command) -> Outcome<Self> {
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn()?;
        let to = child.stdin.take().ok_or("no pipe to the process")?;
        let from = BufReader::new(child.stdout.take().ok_or("no pipe from the process")?).lines();
        let mut made = Process { child, to, from, ready: Value::Null };
        made.ready = made.answer()?;
        Ok(made)
    }

    fn answer(&mut self) -> Outcome<Value> {
        for line in &mut self.from {
            // What libraries print is not for us.
            if let Ok(value @ Value::Object(_)) = serde_json::from_str(&line?) {
                return match value.get("error") {
                    Some(error) => Err(error.to_string().into()),
                    None => Ok(value),
                };
            }
        }
        Err("the process ended before it answered".into())
    }

    fn ask(&mut self, what: &str) -> Outcome<Value> {
        writeln!(self.to, "{what}")?;
        self.to.flush()?;
        self.answer()
    }

    /// Does the work some times.
    pub fn run(&mut self, times: usize) -> Outcome<Times> {
        Ok(serde_json::from_value(self.ask(&format!("run {times}"))?)?)
    }

    /// What came of the last time.
    pub fn check(&mut self) -> Outcome<Checked> {
        Ok(serde_json::from_value(self.ask("check")?)?)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = writeln!(self.to, "end");
        let _ = self.to.flush();
        let _ = self.child.wait();
    }
}

/// This side of the lines, for one of our ways.
pub fn serve(mut way: Way) -> Outcome {
    let before = clock::memory_mb("VmHWM:");
    say(&json!({ "ready": true }).to_string());
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let answer = match line.split_once(' ') {
            Some(("run", times)) => {
                let mut taken = Times::default();
                for _ in 0..times.parse::<usize>()? {
                    let (cpu, wall, done) = clock::timed(|| (way.run)());
                    done?;
                    taken.cpu.push(cpu);
                    taken.wall.push(wall);
                }
                serde_json::to_value(taken)?
            }
            None if line == "check" => {
                let peak_mb = clock::memory_mb("VmHWM:");
                let answer = (way.check)()?;
                serde_json::to_value(Checked { answer, peak_mb, before_mb: before })?
            }
            _ => break,
        };
        say(&answer.to_string());
    }
    Ok(())
}
