//! Frames that a positioner carries.

use truepose_controllers::{Dialect, Program, Value};

fn frame(dialect: Dialect, text: &str) -> (Program, String) {
    let program = Program::read(text.as_bytes(), &[], dialect).expect("a program");
    let names = program.points().iter().filter_map(|point| match &point.value {
        Value::Pose { frame, .. } => Some(frame.words()),
        Value::Joints(_) => None,
    });
    let names = names.collect::<Vec<_>>().join(" ");
    (program, names)
}

#[test]
fn frames_of_external_kinematics_are_known_by_name_and_not_taken_for_frames_of_the_base() {
    let pose = "{X 1,Y 2,Z 3,A 0,B 0,C 0}";
    for (set, name) in [
        ("$BASE=EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,BASE_DATA[3])", "EK(BASE_DATA[3])"),
        (
            "$BASE = EK (EX_AX_DATA[1].ROOT, EX_AX_DATA[1].EX_KIN, EX_AX_DATA[1].OFFSET)",
            "EK(EX_AX_DATA[1].OFFSET)",
        ),
        ("BAS(#EX_BASE,1)", "EK(EX_AX_DATA[1].OFFSET)"),
    ] {
        let text = format!("DEF a()\nBAS(#BASE,7)\n{set}\nLIN {pose}\nEND\n");
        let (program, names) = frame(Dialect::Krl, &text);
        assert_eq!(names, name, "{set}");
        let words = program.definitions().get(name).expect_err("no frame of the base");
        assert!(words.contains(&format!("--work {name}=TOOL")), "{words}");
    }
    let (_, names) = frame(Dialect::Krl, &format!("DEF a()\n$BASE=EK(a,b,c:d)\nLIN {pose}\nEND\n"));
    assert_eq!(names, "unknown");
}

#[test]
fn what_only_looks_like_a_motion_or_a_point_is_refused_by_its_line() {
    let refused = |dialect: Dialect, text: &str| {
        let (program, _) = frame(dialect, text);
        program.notes().iter().filter(|note| note.refuses).map(|note| note.line).collect::<Vec<_>>()
    };
    let pose = "{X 1,Y 2,Z 3,A 0,B 0,C 0}";
    for line in
        [format!("IF $IN[1] THEN LIN {pose}"), format!("ELSE PTP {pose}"), format!("UNTIL $IN[1] LIN {pose}")]
    {
        assert_eq!(refused(Dialect::Krl, &format!("DEF a()\n{line}\nEND\n")), [2], "{line}");
    }
    for line in ["IF $IN[1] AND (XP1.X > 5) THEN", "FOR I=1 TO 5", "WHILE XP1.X < Y"] {
        assert!(refused(Dialect::Krl, &format!("DEF a()\n{line}\nEND\n")).is_empty(), "{line}");
    }
    let job = |line: &str| {
        format!(
            "/JOB\n//NAME A\n//POS\n///TOOL 0\n///POSTYPE BASE\nC00000=1,2,3,0,0,0\n//INST\nNOP\n{line}\nEND\n"
        )
    };
    for (line, lines) in [
        ("MOVL C00000 V=5 TL#(2)", vec![9]),
        ("MOVL C00000 V=5 UF#(1)", vec![9]),
        ("MOVL C00000 V=5 PL=0", vec![]),
    ] {
        assert_eq!(refused(Dialect::Inform, &job(line)), lines, "{line}");
    }
    let data = |kind: &str, values: &str| {
        format!(
            "<Database><Datas>\n<Data name=\"a\" type=\"{kind}\"><Value key=\"0\" {values}/></Data>\n</Datas></Database>"
        )
    };
    let (place, axes) = ("x=\"1\" y=\"2\" z=\"3\" rx=\"0\" ry=\"0\" rz=\"0\"", "j1=\"1\" j2=\"2\"");
    for (kind, values, lines) in [
        ("joint6", axes, vec![2]),
        ("pointXy", place, vec![2]),
        ("trsf", place, vec![]),
        ("mdesc", "accel=\"5\"", vec![]),
    ] {
        assert_eq!(refused(Dialect::Val3, &data(kind, values)), lines, "{kind}");
    }
}
