//! What is a point in each language and what is none, on small programs.

use truepose_controllers::{Branch, Dialect, Program, Reference, Replacement, Role, Value};

fn read(dialect: Dialect, text: &str, others: &[&str]) -> Program {
    let others: Vec<&[u8]> = others.iter().map(|other| other.as_bytes()).collect();
    Program::read(text.as_bytes(), &others, dialect).unwrap()
}

fn names(program: &Program) -> Vec<&str> {
    program.points().iter().map(|point| point.name.as_str()).collect()
}

/// Frame and tool of a point.
fn active<'p>(program: &'p Program, name: &str) -> (&'p Reference, &'p Reference) {
    let point = program.points().iter().find(|point| point.name == name).unwrap();
    let Value::Pose { frame, tool, .. } = &point.value else { panic!("{name} is no pose") };
    (frame, tool)
}

fn named(reference: &Reference) -> &str {
    match reference {
        Reference::Named(name) => name,
        other => panic!("{other:?}"),
    }
}

/// All numbers of the program's points replaced by 1, 2, 3, …
fn counted(program: &Program) -> String {
    let mut next = 0.0;
    let all: Vec<Option<Replacement>> = program
        .points()
        .iter()
        .map(|point| {
            let count = match &point.value {
                Value::Joints(values) => values.len(),
                Value::Pose { .. } => 3 + program.dialect().orientation().count(),
            };
            let mut number = || {
                next += 1.0;
                next
            };
            point
                .fixed
                .is_none()
                .then(|| Replacement { numbers: (0..count).map(|_| number()).collect(), turns: vec![] })
        })
        .collect();
    String::from_utf8(program.rewritten(&all).unwrap()).unwrap()
}

const SRC: &str = "&ACCESS RVP\r\n&REL 12\r\nDEF pick( )\r\n;FOLD INI\r\nBAS (#INITMOV,0 )\r\n;ENDFOLD\r\n$BASE = BASE_DATA[2] ; {X 1,Y 2}\r\n\
    BAS(#TOOL,1)\r\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}\r\nLIN XP1 C_DIS ; LIN {X 9,Y 9,Z 9,A 9,B 9,C 9}\r\n\
    circ {x 10.5, y -2,Z 3,A 0,B 0,C 0,S 2,T 'B001010'} , {X 1,Y 2,Z 3,A 4,B 5,C 6}\r\nMSG(\"LIN {X 1,Y 2}\")\r\n\
    SPTP XP2 WITH $VEL_AXIS[1] = SVEL_JOINT(100.0), $TOOL = STOOL2(FP2), $BASE = SBASE(FP2.BASE_NO)\r\nEND\r\n";
const DAT: &str = "DEFDAT pick PUBLIC\r\nDECL E6POS XP1={X 100.0,Y 200.0,Z 300.0,A 0.0,B 90.0,C 0.0,S 2,T 10,E1 0.0}\r\n\
    DECL E6POS  XP2={X 1.5E2,Y +2,Z -.5,A 0,B 0,C 0,S 2,T 10,E1 7.5} , XP3={X 1,Y 2,Z 3,A 4,B 5,C 6}\r\n\
    DECL FDAT FP1={TOOL_NO 3,BASE_NO 4,IPO_FRAME #BASE,POINT2[] \" \"}\r\nDECL FDAT FP2={TOOL_NO 5,BASE_NO 0,IPO_FRAME #BASE,POINT2[] \" \"}\r\n\
    DECL FDAT FP3={TOOL_NO 6,BASE_NO 1,IPO_FRAME #TCP}\r\nDECL FRAME F9={X 1,Y 0,Z 0,A 0,B 0,C 0}\r\nDECL PDAT PP1={VEL 100.0,ACC 50.0}\r\nENDDAT\r\n";

#[test]
fn krl_points_are_declared_assigned_or_in_a_motion() {
    let src = read(Dialect::Krl, SRC, &[DAT]);
    assert_eq!(names(&src), ["PTP in line 9", "CIRC in line 11", "CIRC in line 11"]);
    assert!(src.notes().is_empty(), "{:?}", src.notes());
    let dat = read(Dialect::Krl, DAT, &[SRC]);
    assert_eq!(names(&dat), ["XP1", "XP2", "XP3"]);
    let (frame, tool) = active(&dat, "XP1");
    // The motion, not the FDAT that only the inline form would use.
    assert_eq!((named(frame), named(tool)), ("BASE_DATA[2]", "TOOL_DATA[1]"));
    let (frame, tool) = active(&dat, "XP2");
    assert_eq!(dat.definitions().last_name(named(frame)), "BASE_DATA[0]");
    assert_eq!(dat.definitions().last_name(named(tool)), "TOOL_DATA[5]");
    assert_eq!(dat.points()[1].external, [("E1".to_owned(), 7.5)]);
    let (frame, _) = active(&dat, "XP3");
    assert!(dat.definitions().get(named(frame)).is_err());
    assert!(matches!(
        &dat.points()[0].value,
        Value::Pose { branch: Branch::Kuka { status: 2, turn: Some(10) }, .. }
    ));
    assert_eq!(
        counted(&dat).lines().nth(2).unwrap(),
        "DECL E6POS  XP2={X 7.000,Y +8.000,Z 9.000,A 10.0000,B 11.0000,C 12.0000,S 2,T 10,E1 7.5} , \
         XP3={X 13.000,Y 14.000,Z 15.000,A 16.0000,B 17.0000,C 18.0000}"
    );
    assert!(counted(&src).contains(
        "circ {x 7.000, y 8.000,Z 9.000,A 10.0000,B 11.0000,C 12.0000,S 2,T 'B001010'} , {X 13.000"
    ));
    assert!(counted(&src).contains("; LIN {X 9,Y 9,Z 9,A 9,B 9,C 9}\r\n"));
}

#[test]
fn krl_frames_that_depend_on_the_way_are_unknown() {
    let text = "DEF a()\n$BASE=BASE_DATA[1]\n$TOOL=$NULLFRAME\nIF x THEN\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n$BASE=BASE_DATA[2]\n\
        LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\nENDIF\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\nWHILE y\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n$BASE=BASE_DATA[3]\n\
        ENDWHILE\n$BASE={X 5,Y 0,Z 0,A 0,B 0,C 0}\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\nsub()\nLIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n\
        LIN_REL {Z 10}\nXP1.X = 5\nLIN {X 1,Y 2,Z 3,A 4,B 5,C q}\nEND\n";
    let program = read(Dialect::Krl, text, &[]);
    let frames: Vec<&Reference> = program
        .points()
        .iter()
        .filter_map(|point| match &point.value {
            Value::Pose { frame, .. } => Some(frame),
            Value::Joints(_) => None,
        })
        .collect();
    let known: Vec<bool> = frames.iter().map(|frame| !matches!(frame, Reference::Unknown(_))).collect();
    assert_eq!(known, [true, true, false, false, true, false, false]);
    assert_eq!(program.notes().iter().filter(|note| note.refuses).count(), 1);
    assert!(program.points().last().unwrap().fixed.as_deref().unwrap().contains('C'));
    let own = read(Dialect::Krl, "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6,S 18,T 2}\n", &[]);
    assert!(own.points()[0].fixed.as_deref().unwrap().contains("absolute-accuracy"));
}

const MOD: &str = "MODULE M\r\n  CONST robtarget p10:=[[600.5,0,800],[0,0,1,0], ! here\r\n    [0,-1,1,0],[9E+09,9E9,9E9,9E9,9E9,9E9]];\r\n\
    LOCAL PERS robtarget p20 := [[1,2,3],[1,0,0,0],[0,0,0,0],[0,9E9,9E9,9E9,9E9,9E9]];\r\n\
    VAR jointtarget j{2}:=[[[0,1,2,3,4,5],[9E9,9E9,9E9,9E9,9E9,9E9]],[[6,7,8,9,10,11],[9E9,9E9,9E9,9E9,9E9,9E9]]];\r\n\
    PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\r\n\
    PERS wobjdata wFix:=[FALSE,TRUE,\"\",[[1,2,3],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\r\n\
    PERS wobjdata wTurn:=[FALSE,FALSE,\"STN1\",[[1,2,3],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\r\n\
    ! CONST robtarget p99:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\r\n  PROC main()\r\n    TPWrite \"p10:=[[1,2,3]]\";\r\n\
    MoveAbsJ j{1}\\NoEOffs, v100, fine, tool0;\r\n    movel p10,v100,z1,tGrip\\WObj:=wFix;\r\n    MoveC p10,\r\n      p20, v50, z1, tGrip\\WObj := wFix ;\r\n\
    MoveL [[7,8,9],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0\\WObj:=wTurn;\r\n    MoveL Offs(p10,0,0,50),v5,fine,tGrip;\r\n  ENDPROC\r\nENDMODULE\r\n";

#[test]
fn rapid_targets_may_span_lines_and_stand_in_arrays() {
    let program = read(Dialect::Rapid, MOD, &[]);
    assert_eq!(names(&program), ["P10", "P20", "J{1}", "J{2}", "MoveL in line 16"]);
    let (frame, tool) = active(&program, "P10");
    assert_eq!((named(frame), named(tool)), ("WFIX", "TGRIP"));
    assert!(program.definitions().get("WTURN").unwrap_err().contains("a unit that moves carries it"));
    let tool = program.definitions().get("TGRIP").unwrap().unwrap();
    assert!((tool.translation.z - 0.1).abs() < 1e-15);
    assert!(matches!(&program.points()[0].value, Value::Pose { branch: Branch::Abb([0, -1, 1, 0]), .. }));
    let refusing: Vec<_> = program.notes().iter().filter(|note| note.refuses).collect();
    assert_eq!(refusing.len(), 1);
    assert!(refusing[0].name.starts_with("MoveL Offs(p10"));
    let text = counted(&program);
    assert!(
        text.contains(
            "[[1.000,2.000,3.000],[4.0000000,5.0000000,6.0000000,7.0000000], ! here\r\n    [0,-1,1,0]"
        ),
        "{text}"
    );
    assert!(text.contains("! CONST robtarget p99:=[[1,2,3]") && text.contains("\"p10:=[[1,2,3]]\""));
    let bare =
        read(Dialect::Rapid, &MOD.replace("PROC main()", "PROC main() p20.trans.z:=5; PDispSet q;"), &[]);
    assert!(bare.points()[1].fixed.is_some());
    assert!(matches!(active(&bare, "P10").0, Reference::Unknown(_)));
}

const LS: &str = "/PROG  TEST\n/ATTR\nCOMMENT\t= \"P[9]{\";\n/MN\n   1:  UFRAME_NUM=1 ;\n   2:J P[1] 100% FINE    ;\n   3:  !L P[9] x ;\n   4:C P[2]    \n    :  P[3:\"a ] b\"] 100mm/sec CNT10    ;\n\
   5:L P[4] 10mm/sec FINE Offset,PR[1]    ;\n   6:L PR[2] 10mm/sec FINE ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1=      .000 deg,\tJ2=    10.000 deg,\tJ3=   -10.000 deg,\n\
\tJ4=      .000 deg,\tJ5=   -90.000 deg,\tJ6=      .000 deg\n};\nP[2:\"UF : 7; }\"]{\n   GP1:\n\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, -1',\n\tX =   500.000  mm,\tY =      .000  mm,\tZ =   300.000  mm,\n\
\tW =  -180.000 deg,\tP =      .000 deg,\tR =      .000 deg\n   GP2:\n\tUF : 1, UT : 1,\t\n\tJ1=     5.000 deg\n};\nP[3]{\n   GP1:\n\tUF : F, UT : 2,\t\tCONFIG : 'F D B, 0, 0, 0',\n\tX = ********  mm,\tY =      .000  mm,\tZ =   300.000  mm,\n\
\tW =  -180.000 deg,\tP =      .000 deg,\tR =      .000 deg\n};\nP[4]{\n   GP1:\n\tUF : 0, UT : 0,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX =   500.000  mm,\tY =      .000  mm,\tZ =   300.000  mm,\n\
\tW =  -180.000 deg,\tP =      .000 deg,\tR =      .000 deg\n};\n/END\n";

#[test]
fn fanuc_positions_keep_their_columns() {
    let program = read(Dialect::Fanuc, LS, &[]);
    assert_eq!(names(&program), ["P[1]", "P[2]", "P[3]", "P[4]"]);
    let (frame, tool) = active(&program, "P[2]");
    assert_eq!((named(frame), named(tool)), ("UF1", "UT2"));
    assert_eq!(program.points()[1].external, [("GP2 J1".to_owned(), 5.0)]);
    assert!(program.points()[2].fixed.as_deref().unwrap().contains('X'));
    assert!(program.points()[3].fixed.as_deref().unwrap().contains("OFFSET"));
    assert_eq!(program.notes().len(), 1);
    assert!(!program.notes()[0].refuses);
    assert!(matches!(
        &program.points()[1].value,
        Value::Pose { branch: Branch::Fanuc { flip: false, up: true, toward: true, turns: [0, 0, -1] }, .. }
    ));
    let text = counted(&program);
    assert!(text.contains("\tJ1=     1.000 deg,\tJ2=     2.000 deg,"), "{text}");
    assert!(text.contains("\tX =     7.000  mm,\tY =     8.000  mm,"), "{text}");
}

const SCRIPT: &str = "def prog():\n  # movel(p[1,2,3,0,0,0])\n  set_tcp(p[0,0,0.1,0,0,0])\n  global home=[0,-1.57,1.57,-1.57,-1.57,0]\n  movej(home, a=1.2)\n\
  wp = p[0.4,-0.1,0.3,3.14,0,0]\n  movel(wp, a=1.2, v=0.25)\n  movej(get_inverse_kin(p[0.5,-0.1,0.3,\n    3.14,0,0], qnear=home))\n  plane = p[0.1,0,0,0,0,0]\n\
  movel(pose_trans(plane, p[0.3,0,0.3,3.14,0,0]))\n  textmsg(\"movel(p[9,9,9,0,0,0])\")\n  movel(pose_add(wp, p[0,0,0.1,0,0,0]))\n  movec(p[1,0,0,0,0,0], pose_to=p[2,0,0,0,0,0], a=1)\nend\n";

#[test]
fn script_literals_are_points_where_a_motion_goes_to_them() {
    let program = read(Dialect::UrScript, SCRIPT, &[]);
    assert_eq!(
        names(&program),
        ["home", "wp", "movej in line 8", "movel in line 11", "movec in line 14", "movec in line 14"]
    );
    assert!(matches!(
        &program.points()[2].value,
        Value::Pose { branch: Branch::Near(_), tool: Reference::Value(_), .. }
    ));
    let (frame, _) = active(&program, "movel in line 11");
    let pose = program.definitions().get(named(frame)).unwrap().unwrap();
    assert!((pose.translation.x - 0.1).abs() < 1e-15);
    assert_eq!(program.notes().len(), 1);
    assert!(program.notes()[0].refuses && program.notes()[0].line == 13);
    assert!(counted(&program).contains("set_tcp(p[0,0,0.1,0,0,0])"));
    assert!(counted(&program).contains("# movel(p[1,2,3,0,0,0])"));
}

const JBI: &str = "/JOB\r\n//NAME TEST\r\n//POS\r\n///NPOS 3,0,0,0,0,0\r\n///TOOL 1\r\n///POSTYPE PULSE\r\n///PULSE\r\nC00000=0,100,-200,0,0,5\r\n\
///USER 2\r\n///POSTYPE USER\r\n///RECTAN\r\n///RCONF 0,0,0,0,0,0,0,0\r\nC00001=185.000,0.000,15.000,180.0000,0.0000,0.0000\r\nEC00000=5\r\n\
//INST\r\n///DATE 2020/01/01 10:00\r\nNOP\r\n'MOVL C00001\r\nMOVJ C0000 VJ=0.78\r\nMOVL C00001 V=93.0\r\nEND\r\n";

#[test]
fn inform_positions_are_pulses_or_poses() {
    let program = read(Dialect::Inform, JBI, &[]);
    assert_eq!(names(&program), ["C00000", "C00001"]);
    let (frame, tool) = active(&program, "C00001");
    assert_eq!((named(frame), named(tool)), ("USER 2", "TOOL 1"));
    assert!(counted(&program).contains("C00000=1,2,3,4,5,6\r\n"));
    assert!(counted(&program).contains("C00001=7.000,8.000,9.000,10.0000,11.0000,12.0000\r\n"));
    let shifted = read(Dialect::Inform, &JBI.replace("NOP", "SFTON P001"), &[]);
    assert!(shifted.points().iter().all(|point| point.fixed.is_some()));
}

const DTX: &str = "<?xml version=\"1.0\" encoding=\"utf-8\" ?>\n<!-- <Value x=\"1\"/> -->\n<Database xmlns=\"http://www.staubli.com/robotics/VAL3/Data/2\">\n<Datas>\n\
<Data name=\"pPick\" access=\"private\" xsi:type=\"array\" type=\"pointRx\" size=\"2\">\n<Value key=\"0\" x=\"100\" y='200.5' rz=\"90\" shoulder=\"lefty\" elbow=\"epositive\" wrist=\"wpositive\" fatherId=\"fPart[0]\"/>\n\
<Value key=\"1\" x=\"a\" fatherId=\"world[0]\"/></Data>\n<Data name=\"jHome\" type=\"jointRx\" size=\"1\"><Value key=\"0\" j2=\"10\" j6=\"1\"/></Data>\n\
<Data name=\"fPart\" type=\"frame\"><Value key=\"0\" x=\"5\" fatherId=\"fCell[0]\"/></Data><Data name=\"fCell\" type=\"frame\"><Value key=\"0\" y=\"7\" fatherId=\"world[0]\"/></Data>\n\
<Data name=\"n\" type=\"num\"><Value key=\"0\" value=\"3\"/></Data></Datas></Database>\n";

#[test]
fn val3_absent_numbers_are_zero_and_are_added() {
    let program = read(Dialect::Val3, DTX, &[]);
    assert_eq!(names(&program), ["pPick[0]", "pPick[1]", "jHome[0]"]);
    assert!(program.points()[1].fixed.is_some());
    let frame = program.definitions().get("fPart[0]").unwrap().unwrap();
    assert!((frame.translation.x - 0.005).abs() < 1e-15 && (frame.translation.y - 0.007).abs() < 1e-15);
    let text = counted(&program);
    assert!(
        text.contains(
            "x=\"1.000\" y='2.000' rz=\"6.0000\" z=\"3.000\" rx=\"4.0000\" ry=\"5.0000\" shoulder=\"lefty\""
        ),
        "{text}"
    );
    assert!(text.contains("<!-- <Value x=\"1\"/> -->") && text.contains("value=\"3\""));
}

#[test]
fn nothing_replaced_is_the_same_text() {
    for (dialect, text) in [
        (Dialect::Krl, SRC),
        (Dialect::Krl, DAT),
        (Dialect::Rapid, MOD),
        (Dialect::Fanuc, LS),
        (Dialect::UrScript, SCRIPT),
        (Dialect::Inform, JBI),
        (Dialect::Val3, DTX),
    ] {
        let program = read(dialect, text, &[]);
        let none = vec![None; program.points().len()];
        assert_eq!(program.rewritten(&none).unwrap(), text.as_bytes());
        assert!(!program.points().is_empty());
    }
}

#[test]
fn other_files_are_refused() {
    let wrong = |dialect, text: &[u8]| Program::read(text, &[], dialect).unwrap_err().to_string();
    assert!(wrong(Dialect::UrScript, b"\x1f\x8b\x08x").contains(".urp"));
    assert!(wrong(Dialect::Krl, b"D\0E\0").contains("UTF-16"));
    assert!(wrong(Dialect::Fanuc, b"hello").contains("/MN"));
    assert!(wrong(Dialect::Inform, b"hello").contains("/JOB"));
    assert!(wrong(Dialect::Val3, b"<a/>").contains("<Data"));
    assert_eq!(
        wrong(Dialect::Krl, b"A=1\nDECL E6POS X={X 1,\nY 2}\n"),
        "2:14: an aggregate is not closed in its line"
    );
}

/// A group of the parameters of a robot: lines of ten values, gears in the lines of that generation.
fn parameters(lines: usize, [(at, denominators), (next, numerators)]: [(usize, &str); 2]) -> String {
    let line = |k: usize| match k {
        k if k == at => denominators.to_owned(),
        k if k == next => numerators.to_owned(),
        _ => "0,1,2,3,4,5,6,7,8,9".to_owned(),
    };
    let group: Vec<String> = (0..lines).map(line).collect();
    format!("//PARA\r\n///RC1G\r\n{}\r\n///RC2G\r\n1,2\r\n", group.join("\r\n"))
}

#[test]
fn pulses_of_a_controllers_parameters_are_proposed_and_held_against_those_stated() {
    // 4096 · 141/(360 · 1) = 1604.27, …
    let numerators = "141,-120,110,90,80,60,1,1,0,0";
    let older = parameters(120, [(97, "7,7,1,1,1,1,1,1,1,1"), (98, numerators)]);
    let newer = parameters(300, [(109, "1,1,1,1,1,1,1,1"), (110, numerators)]);
    for table in [&older, &newer] {
        let program = read(Dialect::Inform, JBI, &[table]);
        let words = format!("{:?}", program.definitions());
        assert!(words.contains("1604.26"), "{words}");
        assert!(words.contains("1365.33"), "a sign is not stated: {words}");
        let alone = Program::read(table.as_bytes(), &[], Dialect::Inform).unwrap();
        assert!(alone.points().is_empty());
        assert_eq!(Dialect::Inform.role("RC.PRM".as_ref(), table.as_bytes()), Role::Table);
    }
    let other = newer.replace("141", "0");
    let error = Program::read(other.as_bytes(), &[], Dialect::Inform).unwrap_err().to_string();
    assert!(error.contains("of another layout") && error.contains("--pulses"), "{error}");
    // The second robot has a group of its own, which has no gears here.
    let second = JBI.replace("NOP", "///GROUP1 RB2\r\nNOP");
    assert!(!format!("{:?}", read(Dialect::Inform, &second, &[&newer]).definitions()).contains("1604"));
}
