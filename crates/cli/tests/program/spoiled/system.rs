//! What is too large or too strange to be a committed file: endless lines, rings of links, full disks, and being killed.

use super::remarks;
use crate::folder::Folder;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A way to spoil a folder, and what is run in it.
type Case = (&'static str, fn(&Folder), &'static [&'static str]);

const IDENTIFY: &[&str] = &["identify", "--robot", "robot.toml", "--data", "spoiled.csv"];
const CHECK: &[&str] = &["check", "--robot", "spoiled.toml"];

const CASES: &[Case] = &[
    ("an endless line", |f| f.write("spoiled.csv", &"1,".repeat(700_000)), IDENTIFY),
    ("an endless comment", |f| f.write("spoiled.csv", &format!("#{}", "a".repeat(2 << 20))), IDENTIFY),
    (
        "an endless cell",
        |f| f.write("spoiled.csv", &format!("{}\n\"{}", f.read("data.csv"), "a".repeat(2 << 20))),
        IDENTIFY,
    ),
    ("a million columns", |f| f.write("spoiled.csv", &",".repeat(1_000_000)), IDENTIFY),
    (
        "five thousand columns",
        |f| f.write("spoiled.csv", &(0..5000).map(|k| format!("c{k},")).collect::<String>()),
        IDENTIFY,
    ),
    (
        "a name of ten thousand words",
        |f| f.write("spoiled.csv", &format!("{}\n10", "j1[deg]1".repeat(5000))),
        IDENTIFY,
    ),
    (
        "a thousand names of thirty numbers",
        |f| {
            let name = |k: usize| (0..30).map(|part| format!("{}_", part * k)).collect::<String>();
            f.write("spoiled.csv", &(0..1000).map(|k| name(k) + ",").collect::<String>());
        },
        IDENTIFY,
    ),
    (
        "a file without an end",
        |f| std::os::unix::fs::symlink("/dev/zero", f.file("spoiled.csv")).unwrap(),
        IDENTIFY,
    ),
    (
        "noise without an end",
        |f| std::os::unix::fs::symlink("/dev/urandom", f.file("spoiled.csv")).unwrap(),
        IDENTIFY,
    ),
    (
        "a ring of links",
        |f| std::os::unix::fs::symlink("spoiled.csv", f.file("spoiled.csv")).unwrap(),
        IDENTIFY,
    ),
    (
        "a link to nothing",
        |f| std::os::unix::fs::symlink("nothing", f.file("spoiled.csv")).unwrap(),
        IDENTIFY,
    ),
    ("a folder", |f| std::fs::create_dir(f.file("spoiled.csv")).unwrap(), IDENTIFY),
    ("a robot of nine megabytes", |f| f.write("spoiled.toml", &"# nothing\n".repeat(950_000)), CHECK),
    ("a robot of brackets", |f| f.write("spoiled.toml", &format!("a = {}", "[".repeat(100_000))), CHECK),
    ("a robot of tables", |f| f.write("spoiled.toml", &format!("a = {}", "{a=".repeat(100_000))), CHECK),
    (
        "a URDF of links within links",
        |f| f.write("spoiled.urdf", &"<link>".repeat(100_000)),
        &["check", "--robot", "spoiled.urdf"],
    ),
    (
        "a fit of brackets",
        |f| f.write("spoiled.json", &format!("{{\"format\": 1, \"robot\": {}", "[".repeat(100_000))),
        &["predict", "--fit", "spoiled.json", "--data", "data.csv", "--out", "out.csv"],
    ),
    (
        "a full disk",
        |_| (),
        &["identify", "--robot", "robot.toml", "--data", "data.csv", "--folds", "0", "--out", "/dev/full"],
    ),
    (
        "a report on a file",
        |f| f.write("page", ""),
        &["identify", "--robot", "robot.toml", "--data", "data.csv", "--folds", "0", "--report", "page"],
    ),
    (
        "a result in a ring of links",
        |f| std::os::unix::fs::symlink("ring.json", f.file("ring.json")).unwrap(),
        &["identify", "--robot", "robot.toml", "--data", "data.csv", "--folds", "0", "--out", "ring.json"],
    ),
];

/// No refusal takes longer: most take milliseconds.
const SECONDS: u64 = 20;

#[test]
fn what_has_no_end_is_refused() {
    let mut said = String::new();
    for (what, spoil, run) in CASES {
        let folder = Folder::with_data();
        spoil(&folder);
        let before = folder.names();
        let began = Instant::now();
        let run = folder.run(run).ended(2);
        assert!(began.elapsed() < Duration::from_secs(SECONDS), "{what} took {:?}", began.elapsed());
        let told = remarks(&run);
        assert!(told.contains("error: ") && told.len() < 600, "{what}: {told}");
        assert_eq!(folder.names(), before, "{what}: a file was left behind");
        // Where noise without an end is no text is chance.
        let told = if what.starts_with("noise") { "[2] (some reason)".into() } else { told };
        said += &format!("{what}\n    {told}\n");
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_folder_that_is_not_writable_keeps_what_it_has() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_data();
    let closed = folder.file("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(closed.join("probe"), "").is_ok() {
        println!("SKIPPED: this user may write everywhere");
        return;
    }
    let run =
        folder.run(&["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "closed/fit.json"]);
    assert_eq!(
        remarks(&run.ended(2)),
        "[2] error: closed/fit.json: cannot be written: the folder `closed` is not writable"
    );
}

#[test]
fn being_killed_leaves_the_old_file_or_the_new_one() {
    let folder = Folder::with_data();
    folder
        .run(&[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--folds",
            "0",
            "--out",
            "fit.json",
        ])
        .ended(0);
    // Enough rows that writing takes a while.
    let data = folder.read("data.csv");
    let (head, rows) = data.split_once('\n').unwrap();
    let head: Vec<&str> = head.split(',').take(7).collect();
    let row: Vec<&str> = rows.lines().next().unwrap().split(',').take(7).collect();
    folder.write(
        "many.csv",
        &format!("{}\n{}", head.join(","), format!("{}\n", row.join(",")).repeat(150_000)),
    );
    let predict = ["predict", "--fit", "fit.json", "--data", "many.csv", "--out", "out.csv"];
    let began = Instant::now();
    folder.run(&predict).ended(0);
    let whole = folder.read("out.csv");
    let took = began.elapsed();
    let mut killed = 0;
    for step in 1..=16 {
        folder.write("out.csv", "an older result");
        let mut child = Command::new(env!("CARGO_BIN_EXE_truepose"))
            .current_dir(folder.path())
            .args(predict)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(took * step / 16);
        child.kill().unwrap();
        killed += usize::from(!child.wait().unwrap().success());
        let left = folder.read("out.csv");
        assert!(
            left == "an older result" || left == whole,
            "a file of {} bytes was left, not {}",
            left.len(),
            whole.len()
        );
    }
    assert!(killed > 3, "the program was never killed: {killed}");
}
