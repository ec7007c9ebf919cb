//! `compensate --program BACKUP/ --out NEW/`: a whole backup at once.

use crate::folder::Folder;

const AXES: &str = "A1 50.668,A2 -106.651,A3 81.014,A4 -25.176,A5 -53.698,A6 72.074";

/// A backup of KUKA's kind: a pair, a program that is refused, one with a tool of $config.dat, and what is no program.
fn backup() -> Folder {
    let folder = Folder::with_heavy_fit();
    let write = |name: &str, text: &str| {
        let path = folder.file(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write("b/R1/Program/job.src", "DEF job()\nPTP XP1\nPTP XHOME\nEND\n");
    write("b/R1/Program/job.dat", &format!("DEFDAT job\nDECL E6AXIS XP1={{{AXES}}}\nENDDAT\n"));
    // Another program has a point of the same name.
    write("b/R1/Program/cell/job.src", "DEF job()\nPTP XP1\nEND\n");
    write(
        "b/R1/Program/cell/job.dat",
        "DEFDAT job\nDECL E6AXIS XP1={A1 46,A2 -104,A3 79,A4 -25,A5 -52,A6 72}\nENDDAT\n",
    );
    write(
        "b/R1/Program/bad.src",
        &format!("DEF bad()\nPTP {{{AXES}}}\nPTP XNOWHERE\nLIN_REL {{Z 5}}\nEND\n"),
    );
    write("b/R1/Program/open.src", "DEF open()\nLIN {X 1,\nEND\n");
    write("b/R1/Program/tool.src", &format!("DEF tool()\nBAS(#TOOL,1)\nBAS(#BASE,0)\nPTP {{{AXES}}}\nEND\n"));
    write("b/R1/Program/logic.src", "DEF logic()\n$OUT[1]=TRUE\nEND\n");
    write("b/R1/System/bas.src", "DEF bas()\nPTP $POS_ACT\nEND\n");
    write(
        "b/R1/System/$config.dat",
        "DEFDAT $CONFIG\nTOOL_DATA[1]={X 0,Y 0,Z 120,A 0,B 0,C 0}\nDECL E6AXIS XHOME={A1 48,A2 -100,A3 85,A4 -20,A5 -60,A6 70}\nENDDAT\n",
    );
    write("b/am.ini", "[Archive]\n");
    folder
}

#[test]
fn every_program_of_a_backup_is_written_or_listed_with_its_lines() {
    let folder = backup();
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>());
    let said = run("compensate --fit fit.json --program b --out new --report page").ended(1);
    let (out, log) = (&said.out, &said.log);
    assert!(
        out.contains("compensated: R1/Program/job.src, R1/Program/job.dat: 1 point: 1 corrected"),
        "{out}"
    );
    assert!(out.contains("compensated: R1/Program/tool.src: 1 point: 1 corrected"), "{out}");
    assert!(out.contains("refused: R1/Program/bad.src\n"), "{out}");
    assert!(out.contains("bad.src:3: PTP XNOWHERE: XNOWHERE has no value"), "{out}");
    assert!(out.contains("bad.src:4: LIN_REL"), "{out}");
    assert!(
        out.contains("refused: R1/Program/open.src\n")
            && out.contains("open.src:2:5: an aggregate is not closed"),
        "{out}"
    );
    assert!(out.contains("not written: no points: R1/Program/logic.src\n"), "{out}");
    assert!(out.contains("not written: frames, tools, loads: R1/System/$config.dat\n"), "{out}");
    assert!(out.contains("not written: no programs: R1/System/bas.src, am.ini\n"), "{out}");
    assert!(out.contains("3 of 5 programs written to new") && !out.contains("nothing is written"), "{out}");
    assert!(log.contains("not met: 2 programs cannot be compensated and are not written"), "{log}");
    for (name, there) in [
        ("job.src", true),
        ("job.dat", true),
        ("cell/job.dat", true),
        ("tool.src", true),
        ("bad.src", false),
        ("logic.src", false),
    ] {
        assert_eq!(folder.file(&format!("new/R1/Program/{name}")).exists(), there, "{name}");
    }
    assert!(!folder.file("new/R1/System").exists());
    assert!(folder.read("new/R1/Program/job.dat.corrections.csv").contains("XP1,2,joints"));
    // The same as alone.
    let alone = run(
        "compensate --fit fit.json --program b/R1/Program/cell/job.src --with b/R1/Program/cell/job.dat --out alone.src",
    );
    alone.ended(0);
    assert_eq!(folder.read("alone.dat"), folder.read("new/R1/Program/cell/job.dat"));
    let json = folder.json("page/compensation.json");
    let files: Vec<&str> =
        json["points"].as_array().unwrap().iter().map(|point| point["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["R1/Program/cell/job.dat", "R1/Program/job.dat", "R1/Program/tool.src"]);

    // Options of which no program has the name are one note; --mark writes what can be written.
    let marked =
        run("compensate --fit fit.json --program b --out marked --mark --tool-frame TOOL_DATA[7]=flange")
            .ended(1);
    assert!(marked.out.contains("4 of 5 programs written to marked"), "{}", marked.out);
    assert_eq!(
        marked.log.matches("no point of the program uses the tool `TOOL_DATA[7]`").count(),
        1,
        "{}",
        marked.log
    );
}

#[test]
fn a_backup_in_which_nothing_is_compensated_writes_nothing() {
    let folder = backup();
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>());
    let log = run("compensate --fit fit.json --program b --out new --limit 0.0001").ended(2).log;
    assert!(log.contains("b: no program is compensated, and nothing is written"), "{log}");
    assert!(log.contains("above the limit") && !folder.file("new").exists(), "{log}");
    for (out, words) in [
        ("b/new", "is in the folder of --program"),
        ("b", "is"),
        (".", "or that folder is in it"),
        ("fit.json", "is"),
    ] {
        let log = run(&format!("compensate --fit fit.json --program b --out {out}")).ended(2).log;
        assert!(log.contains(words), "{log}");
    }
    std::fs::write(folder.file("b/other.mod"), "MODULE M\nENDMODULE\n").unwrap();
    let log = run("compensate --fit fit.json --program b --out new").ended(2).log;
    assert!(
        log.contains("several languages (krl, rapid)") || log.contains("several languages (rapid, krl)"),
        "{log}"
    );
    run("compensate --fit fit.json --program b --out new --language krl").ended(1);
    std::fs::create_dir(folder.file("empty")).unwrap();
    let log = run("compensate --fit fit.json --program empty --out other").ended(2).log;
    assert!(log.contains("there is no robot program in it"), "{log}");
}

#[test]
fn modules_of_a_task_that_share_points_are_one_program() {
    let folder = Folder::with_heavy_fit();
    let place = "[[50.668,-106.651,81.014,-25.176,-53.698,72.074],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for (name, text) in [
        ("PROGMOD/data.mod", format!("MODULE D\nCONST jointtarget j1:={place};\nENDMODULE\n")),
        ("PROGMOD/a.mod", "MODULE A\nPERS tooldata own:=[TRUE,[[0,0,9],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC a()\nMoveAbsJ j1,v100,fine,grip;\nENDPROC\nENDMODULE\n".into()),
        ("PROGMOD/b.mod", format!("MODULE B\nPROC b()\nMoveAbsJ {place},v100,fine,grip;\nMoveL nowhere,v100,fine,grip;\nENDPROC\nENDMODULE\n")),
        ("SYSMOD/user.sys", "MODULE U(SYSMODULE)\nPERS tooldata grip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nENDMODULE\n".into()),
    ] {
        let path = folder.file(&format!("b/RAPID/TASK1/{name}"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let run = folder.run("compensate --fit fit.json --program b --out new").ended(1);
    let out = &run.out;
    assert!(
        out.contains(
            "compensated: RAPID/TASK1/PROGMOD/a.mod, RAPID/TASK1/PROGMOD/data.mod: 1 point: 1 corrected"
        ),
        "{out}"
    );
    assert!(
        out.contains("refused: RAPID/TASK1/PROGMOD/b.mod\n") && out.contains("b.mod:4: MoveL nowhere"),
        "{out}"
    );
    assert!(out.contains("not written: frames, tools, loads: RAPID/TASK1/SYSMOD/user.sys\n"), "{out}");
    assert!(out.contains("1 of 2 programs written to new"), "{out}");
}
