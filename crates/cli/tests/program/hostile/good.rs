//! One good file of each kind, made once and copied.

use crate::folder::{Folder, ROBOT};
use std::path::Path;
use std::sync::OnceLock;

/// A folder with one good file of each kind.
pub fn good() -> Folder {
    static MADE: OnceLock<Folder> = OnceLock::new();
    let made = MADE.get_or_init(made);
    let folder = Folder::empty();
    copied(made.path(), folder.path());
    folder
}

fn copied(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            std::fs::create_dir(&to).unwrap();
            copied(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), to).unwrap();
        }
    }
}

fn made() -> Folder {
    let folder = Folder::with_data();
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>()).ended(0);
    folder.write(
        "model.toml",
        "[[effects]]\nfamily = \"geometric\"\nframes = [\"base\", \"j1\", \"j2\", \"tool\"]\n\n[[effects]]\nfamily = \"transmission\"\n\
         joint = \"j1\"\nharmonics = [1, 2]\n\n[[effects]]\nfamily = \"expansion\"\nat = { motion = { joint = \"j2\" } }\n\
         factors = [{ of = { joint = \"j1\" }, basis = { powers = [1, 2] } }]\n",
    );
    run("identify --robot robot.toml --data data.csv --folds 0 --model model.toml --out fit.json");
    run("identify --robot robot.toml --data data.csv --folds 0 --report page");
    run("export --fit fit.json --format urdf --out arm.urdf");
    folder.write(
        "poses.csv",
        "x[mm],y[mm],z[mm],target,j1[deg],j2[deg],d3[mm]\n15,470,550,T2,100,55,26\n633,13,342,T1,5,26,47\n",
    );
    // Half of the rows in another installation.
    let data = folder.read("data.csv");
    let half = data.lines().count() / 2;
    let session = |(k, line): (usize, &str)| match k {
        0 => format!("{line},session\n"),
        k => format!("{line},{}\n", if k <= half { "A" } else { "B" }),
    };
    folder.write("two.csv", &data.lines().enumerate().map(session).collect::<String>());
    folder.write("sessions.toml", &format!("{ROBOT}\n[sessions]\nbase = \"own\"\ntool = \"shared\"\n"));
    run("identify --robot sessions.toml --data two.csv --folds 0 --out two.json");
    run("monitor --fit fit.json --data data.csv --history history.json");
    // Robots of one type.
    let plant = folder.read("plant.toml");
    let fits: Vec<String> = (3..7)
        .map(|seed| {
            folder.write("sister.toml", &plant.replace("seed = 3", &format!("seed = {seed}")));
            run("simulate --plant sister.toml --out sister.csv");
            run(&format!("identify --robot robot.toml --data sister.csv --folds 0 --out fleet{seed}.json"));
            format!("fleet{seed}.json")
        })
        .collect();
    run(&format!("fleet {} --out prior.json", fits.join(" ")));
    // Five poses in six cycles.
    let mut cycles = String::from("j1[deg],j2[deg],d3[mm],x[mm],y[mm],z[mm],target,visit\n");
    let (poses, mut visit) = ([4, 14, 24, 34, 44].map(|k| data.lines().nth(k).unwrap()), 0);
    for cycle in 0..6 {
        for pose in &poses {
            let cells: Vec<&str> = pose.split(',').collect();
            let at: Vec<String> = (3..6)
                .map(|k| {
                    format!(
                        "{}",
                        cells[k].parse::<f64>().unwrap() + 0.01 * f64::from((7 * cycle + k as i32) % 5)
                    )
                })
                .collect();
            cycles += &format!("{},{},{},{visit}\n", cells[..3].join(","), at.join(","), cells[6]);
            visit += 1;
        }
    }
    folder.write("repeats.csv", &cycles);
    // Two sockets.
    let sockets = "[[landmarks]]\nname = \"A\"\nkind = \"socket\"\n\n[[landmarks]]\nname = \"B\"\nxyz = [400, 0, 20]\nknown = false\n\n\
                   [[distances]]\nbetween = [\"A\", \"B\"]\nvalue = 50\nsd = 0.1\n";
    folder.write("touched.toml", &format!("{ROBOT}\n{sockets}"));
    let mut touched = String::from("kind,landmark,j1[deg],j2[deg],d3[mm],target\n");
    for k in 0..24 {
        let wave = |step: f64| (step * f64::from(k)).sin();
        let joints =
            format!("{:.3},{:.3},{:.3}", 30.0 * wave(1.3), 40.0 * wave(2.1), 120.0 + 80.0 * wave(0.7));
        touched += &format!("same_point,{},{joints},T1\n", if k < 12 { "A" } else { "B" });
    }
    folder.write("touched.csv", &touched);
    folder
        .write("head.toml", "[certificate]\nnumber = \"17\"\ncustomer = \"A & B\"\ndate = \"2026-01-31\"\n");
    folder.write(
        "frames.toml",
        "[units]\nlength = \"mm\"\nangle = \"deg\"\n[[frames]]\nname = \"j1fixture\"\nin = \"base\"\nxyz = [10, 0, 5]\nrpy = [0, 0, 9]\n",
    );
    programs(&folder);
    folder
}

/// Programs for the example's heavy arm.
fn programs(folder: &Folder) {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/01_identify");
    let file = |name: &str| example.join(name).display().to_string();
    let identify = ["identify", "--folds", "0", "--out", "heavy.json", "--robot", &file("robot.toml")];
    folder.run(&[&identify[..], &["--data", &file("measurements.csv")]].concat()).ended(0);
    folder.write("job.src", "DEF job( )\r\nPTP XP1\r\nPTP XP2\r\nEND\r\n");
    folder.write(
        "job.dat",
        "DEFDAT job\r\nDECL E6AXIS XP1={A1 50.668,A2 -106.651,A3 81.014,A4 -25.176,A5 -53.698,A6 72.074,E1 0.0}\r\n\
         DECL E6AXIS XP2={A1 48.0,A2 -100.0,A3 85.0,A4 -20.0,A5 -60.0,A6  70.000}\r\nENDDAT\r\n",
    );
    folder.write(
        "job.mod",
        "MODULE m\nCONST jointtarget j1:=[[50,-100,80,-25,-53,72],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\n\
         MoveAbsJ j1,v100,fine,tool0;\nENDPROC\nENDMODULE\n",
    );
    folder.write(
        "job.ls",
        "/PROG  JOB\n/ATTR\n/MN\n   1:J P[1] 100% FINE ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\
         \tJ1=    50.000 deg,\tJ2=  -100.000 deg,\tJ3=    80.000 deg,\n\
         \tJ4=   -25.000 deg,\tJ5=   -53.000 deg,\tJ6=    72.000 deg\n};\n/END\n",
    );
    folder.write(
        "job.script",
        "def job():\n  movej([0.8,-1.8,1.4,-0.4,-0.9,1.2], a=1, v=1)\n  movel(p[1.5,0.02,1.2,0.1,2.2,0.1], a=1.2, v=0.2)\nend\n",
    );
}
