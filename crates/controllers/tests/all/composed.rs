//! Programs composed of the statements of the manuals' lists, in the styles of pendants and offline tools: each motion is read, or refused by
//! its line.

use crate::counted::{Tally, held};
use crate::programs::Draw;
use crate::statements::{FANUC, INFORM, KRL, RAPID, URSCRIPT, VAL3};
use std::fmt::Write;
use truepose_controllers::Dialect;

/// Programs of each language.
const PROGRAMS: u64 = 48;

/// Statements of a program.
const STATEMENTS: usize = 14;

/// A place near others, as the language writes it.
fn place(dialect: Dialect, draw: &mut Draw) -> String {
    let [x, y, z] = [draw.within(600.0, 900.0), draw.within(-300.0, 300.0), draw.within(200.0, 600.0)];
    match dialect {
        Dialect::Krl => format!("{{X {x:.3}, Y {y:.1},Z {z:.0},A 0.0,B 90.0,C -180.0}}"),
        Dialect::Rapid => {
            format!("[[{x:.2},{y:.2},{z:.2}],[0,0,1,0],[0,-1,0,0],[9E+09,9E9,9E9,9E9,9E9,9E9]]")
        }
        _ => format!("p[{:.4}, {:.4},{:.4}, 0.0,3.1,0.0]", 1e-3 * x, 1e-3 * y, 1e-3 * z),
    }
}

/// The declarations and the frame of a program around its statements.
fn around(dialect: Dialect, statements: &str, draw: &mut Draw) -> String {
    let places = [(); 6].map(|()| place(dialect, draw));
    let [a, b, c, d, e, f] = places;
    match dialect {
        Dialect::Krl => format!(
            "&ACCESS RVP\n&REL 4\nDEF job( )\nDECL E6POS XP1,XOFF\nDECL E6POS XQ[3]\nDECL E6POS XP2\nDECL FDAT FP1\n;FOLD INI\nBAS (#INITMOV,0 )\n;ENDFOLD (INI)\nXP1={a}\nXP2={b}\nXQ[1]={c}\nXQ[2]={d}\n$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\n{statements}END\n"
        ),
        Dialect::Rapid => format!(
            "MODULE Job\n  CONST robtarget p1:={a};\n  LOCAL PERS robtarget p2:={b};\n  CONST jointtarget j1:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
             CONST jointtarget j9:=[[0,0,0,0,0,0],[5,9E9,9E9,9E9,9E9,9E9]];\nCONST robtarget grid{{2,2}}:=[[{c},{d}],[{e},{f}]];\n  PROC main()\n{statements}  ENDPROC\nENDMODULE\n"
        ),
        Dialect::Fanuc => {
            let mut text = format!("/PROG  JOB\n/ATTR\nOWNER\t\t= MNEDITOR;\n/APPL\n/MN\n{statements}/POS\n");
            for n in 1..=5 {
                let _ = write!(
                    text,
                    "P[{n}]{{\n   GP1:\n\tUF : 1, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {:9.3}  mm,\tY = {:9.3}  mm,\tZ =   300.000  mm,\n\tW =   180.000 deg,\tP =     0.000 deg,\tR =     0.000 deg\n}};\n",
                    draw.within(700.0, 900.0),
                    draw.within(-99.0, 99.0)
                );
            }
            text + "/END\n"
        }
        Dialect::UrScript => format!(
            "def job():\n  set_tcp(p[0,0,0.1,0,0,0])\n  home = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]\n  part = p[0.4,0.0,0.1,0,0,0.5]\n  global w1 = {a}\n  w2 = {b}\n  w3 = {c}\n{statements}end\ndef shifted(pose, h):\n  return pose_add(pose, p[0,0,h,0,0,0])\nend\n"
        ),
        _ => {
            let mut text =
                "/JOB\n//NAME JOB\n//POS\n///NPOS 3,1,1,0,0,0\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\n"
                    .to_owned();
            for n in 0..3 {
                let _ = writeln!(text, "C{n:05}={},-2000,3000,0,5000,60", draw.below(9000));
            }
            text + "BC00000=0\nEC00000=0,1\n//INST\n///DATE 2024/01/01 10:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n"
                + statements
                + "END\n"
        }
    }
}

/// A program, and the first lines of statements that have to be read, and refused.
fn composed(dialect: Dialect, forms: &[&str], draw: &mut Draw) -> (String, [Vec<usize>; 2]) {
    let mark = "\u{1}";
    let mut statements = String::new();
    for number in 1..=STATEMENTS {
        let form = draw.of(forms);
        let (class, mut form) = match form.split_at(1) {
            ("+", form) => ("+", form.to_owned()),
            ("-", form) => ("-", form.to_owned()),
            _ => ("", form.to_owned()),
        };
        let joints = match dialect {
            Dialect::Krl => "{A1 5.0,A2 -90.0,A3 90.0,A4 0.0,A5 45.0,A6 0.0}",
            Dialect::Rapid => "[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]",
            _ => "[0.1,-1.4, 1.5,-1.6,-1.5,0.2]",
        };
        if dialect == Dialect::Val3 {
            form = form.replace('%', &number.to_string());
        } else if dialect != Dialect::Fanuc && dialect != Dialect::Inform {
            form = form.replace('~', joints);
            while form.contains('@') {
                form = form.replacen('@', &place(dialect, draw), 1);
            }
            if dialect == Dialect::Krl {
                form = form.replace("C #,", "C {X 800.0,Y 10.0,Z 300.0},");
            }
        }
        let form = format!("{mark}{class}{mark}{form}");
        let _ = match dialect {
            Dialect::Fanuc => writeln!(statements, "{number:4}:{form}    ;"),
            Dialect::Inform => writeln!(statements, "{form}"),
            _ => writeln!(statements, "  {form}"),
        };
    }
    let marked = around(dialect, &statements, draw);
    let mut classes = [Vec::new(), Vec::new()];
    for (k, line) in marked.split('\n').enumerate() {
        for (class, list) in ["+", "-"].into_iter().zip(&mut classes) {
            if line.contains(&format!("{mark}{class}{mark}")) {
                list.push(k + 1);
            }
        }
    }
    let text =
        ["+", "-", ""].iter().fold(marked, |text, class| text.replace(&format!("{mark}{class}{mark}"), ""));
    (text, classes)
}

#[test]
fn statements_of_the_manuals_are_read_or_refused_by_line() {
    let all = [
        (Dialect::Krl, KRL),
        (Dialect::Rapid, RAPID),
        (Dialect::Fanuc, FANUC),
        (Dialect::UrScript, URSCRIPT),
        (Dialect::Inform, INFORM),
        (Dialect::Val3, VAL3),
    ];
    let mut wrong = Vec::new();
    for (dialect, forms) in all {
        let mut draw = Draw::new(57);
        let made: Vec<(String, String, [Vec<usize>; 2])> = (0..PROGRAMS)
            .map(|k| {
                let (text, classes) = composed(dialect, forms, &mut draw);
                (format!("job{k}.txt"), text, classes)
            })
            .collect();
        let programs: Vec<(String, String)> =
            made.iter().map(|(name, text, _)| (name.clone(), text.clone())).collect();
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.txt", dialect.word()));
        let corpus: String = programs.iter().map(|(name, text)| format!("=== {name}\n{text}")).collect();
        std::fs::write(&path, corpus).expect("written");
        let Some(Tally { motions, silent, lines }) = held(dialect, &path, &programs) else {
            eprintln!("SKIPPED: no python3");
            return;
        };
        assert!(motions > 200, "{dialect:?}: {motions}");
        wrong.extend(silent);
        for ((name, text, [read, refused]), (reached, noted)) in made.iter().zip(&lines) {
            let shown = |line: usize| {
                format!("{dialect:?} {name}:{line}: {}", text.lines().nth(line - 1).unwrap_or(""))
            };
            wrong.extend(
                read.iter()
                    .filter(|line| noted.contains(line) || !reached.contains(line))
                    .map(|line| format!("not read: {}", shown(*line))),
            );
            wrong.extend(
                refused
                    .iter()
                    .filter(|line| !noted.contains(line))
                    .map(|line| format!("not refused: {}", shown(*line))),
            );
            let known = |line: &&usize| !read.contains(line) && !refused.contains(line);
            wrong.extend(noted.iter().filter(known).map(|line| format!("noted: {}", shown(*line))));
        }
    }
    wrong.sort();
    assert!(wrong.is_empty(), "{} statements:\n{}", wrong.len(), wrong.join("\n"));
}
