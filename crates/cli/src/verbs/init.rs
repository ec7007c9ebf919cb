//! `truepose init`: a robot description from the library, a table to fill in, and a first check.

use super::check::robot_text;
use super::template;
use crate::args::Init;
use crate::failure::Failure;
use crate::terminal;
use std::path::{Path, PathBuf};
use truepose_io::{RobotOptions, check_writable, read_robot, same_file, write_whole};
use truepose_kinematics::{Chain, JointKind};
use truepose_report::Alignment::Left;
use truepose_report::table;
use truepose_workflow::{Known, Nominal, ROBOTS};

/// Runs the verb.
pub fn run(args: &Init) -> Result<(), Failure> {
    if let Some(rows) = args.dh {
        return unfilled(rows, args);
    }
    let Some(word) = args.name.as_deref().filter(|_| !args.list) else {
        let row = |robot: &Known| vec![robot.name.to_owned(), robot.title().to_owned()];
        let rows: Vec<Vec<String>> = ROBOTS.iter().map(row).collect();
        terminal::print(&table(&["name", "robot"], &[Left, Left], &rows));
        return Ok(());
    };
    let known = Known::named(word).ok_or_else(|| unknown(word))?;
    let out =
        args.out.as_deref().map_or_else(|| PathBuf::from(format!("{}.toml", known.name)), Path::to_path_buf);
    free(&out, args)?;
    write_whole(&out, known.text.as_bytes())?;
    let (chain, _) = read_robot(&out, &RobotOptions::default())?;
    if let Some(csv) = &args.csv {
        write_whole(csv, measurements(&chain, known.title()).as_bytes())?;
    }
    terminal::print(&format!("{}, written to {}\n\n", known.title(), out.display()));
    terminal::print(&robot_text(&chain));
    terminal::print(&Nominal::of(&chain, None, &[]).text());
    terminal::print(&next(&out, args.csv.as_deref()));
    Ok(())
}

/// Refuses files that exist.
fn free(out: &Path, args: &Init) -> Result<(), Failure> {
    for file in std::iter::once(out).chain(args.csv.as_deref()) {
        if file.exists() {
            let message = format!("{}: the file exists; remove it, or write to another one", file.display());
            return Err(Failure::Input(message));
        }
        check_writable(file)?;
    }
    if args.csv.as_ref().is_some_and(|csv| same_file(csv, out)) {
        return Err(Failure::Input(format!(
            "--csv: {} is the robot description; name another file",
            out.display()
        )));
    }
    Ok(())
}

/// A description whose numbers are still to be filled in.
fn unfilled(rows: u16, args: &Init) -> Result<(), Failure> {
    let out = args.out.as_deref().unwrap_or(Path::new("robot.toml"));
    free(out, args)?;
    write_whole(out, template::robot(rows).as_bytes())?;
    let (chain, _) = read_robot(out, &RobotOptions::default())?;
    if let Some(csv) = &args.csv {
        write_whole(csv, measurements(&chain, "robot").as_bytes())?;
    }
    terminal::print(&format!(
        "a robot of {rows} revolute joints, written to {}; its parameters are all zero\n\nnext\n fill in theta, d, a and alpha of each joint \
         from the data sheet\n",
        out.display()
    ));
    let data = args.csv.as_ref().map_or_else(String::new, |csv| format!(" --data {}", csv.display()));
    terminal::print(&format!(
        " truepose check --robot {}{data}   prints the pose of the flange at all zeros, to be compared with the pendant\n",
        out.display()
    ));
    Ok(())
}

fn unknown(word: &str) -> Failure {
    let near = Known::near(word);
    let hint = if near.is_empty() { String::new() } else { format!("; did you mean {}?", near.join(", ")) };
    Failure::Input(format!("the library has no robot `{word}`{hint} (`truepose init --list` lists all)"))
}

/// A table with the columns of measurements of this robot.
fn measurements(chain: &Chain, title: &str) -> String {
    let unit = |kind| if kind == JointKind::Prismatic { "mm" } else { "deg" };
    let joints = chain.movable().iter().map(|&joint| chain.joint(joint));
    let header: Vec<String> = joints.map(|joint| format!("{}[{}]", joint.name, unit(joint.kind))).collect();
    format!(
        "# Measurements of a {title}: one row for each pose, the joint values that the controller shows and the\n\
         # measured position in the frame of the instrument. Other units: m, in, rad. Orientations, several\n\
         # reflectors, loads, time and temperatures have columns of their own: docs/files.md lists them.\n\
         # At least 30 poses, spread over the whole range of every joint; measure some of them twice.\n\
         {},x[mm],y[mm],z[mm]\n",
        header.join(",")
    )
}

/// What to do with the files.
fn next(robot: &Path, csv: Option<&Path>) -> String {
    let data = csv.map_or_else(|| "DATA.csv".into(), |csv| csv.display().to_string());
    let robot = robot.display();
    format!(
        "\nnext\n compare the flange at all zeros with the robot's pendant (no tool, base frame)\n \
         measure, and fill in {data}\n truepose check --robot {robot} --data {data}\n \
         truepose identify --robot {robot} --data {data} --out fit.json\n"
    )
}
