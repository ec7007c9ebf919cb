//! What carries a pose and is not understood is refused, and every argument is read by its instruction.

use truepose_controllers::{Dialect, Program, Reference, Value};

fn read(dialect: Dialect, text: &str) -> Program {
    Program::read(text.as_bytes(), &[], dialect).expect("a program")
}

/// Lines of the notes that refuse.
fn refused(program: &Program) -> Vec<usize> {
    let mut lines: Vec<usize> =
        program.notes().iter().filter(|note| note.refuses).map(|note| note.line).collect();
    lines.sort_unstable();
    lines
}

fn tools(program: &Program) -> Vec<String> {
    let of = |value: &Value| match value {
        Value::Pose { tool: Reference::Named(name), .. } => name.clone(),
        Value::Pose { tool, .. } => tool.words(),
        Value::Joints(_) => "joints".into(),
    };
    program.points().iter().map(|point| of(&point.value)).collect()
}

const PLACE: &str = "[[700,10,640],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";

fn module(lines: &[String]) -> String {
    let declared = format!(
        "CONST robtarget p1:={PLACE};\nCONST robtarget p2:={PLACE};\nCONST jointtarget e1:=[[0,0,0,0,0,0],[7,9E9,9E9,9E9,9E9,9E9]];\n"
    );
    format!("MODULE M\n{declared}PROC main()\n{}\nENDPROC\nENDMODULE\n", lines.join("\n"))
}

#[test]
fn rapid_arguments_are_those_of_the_instruction() {
    for (instruction, tool, points) in [
        (format!("ArcLStart {PLACE},v100,seam2,weld3,fine,torch\\WObj:=w;"), "TORCH", 1),
        (format!("ArcC {PLACE},{PLACE},v100,seam2,weld3\\Weave:=weave1,z1,torch;"), "TORCH", 2),
        (format!("ArcL\\On,{PLACE},v100,seam2,weld3,weave1,z1,torch;"), "TORCH", 1),
        (format!("SpotJ {PLACE},vmax,gun1,spot10,tgun;"), "TGUN", 1),
        (format!("PaintL {PLACE},v100,z5,bell;"), "BELL", 1),
        (format!("DispL\\On,{PLACE},v100,bead1,z30,nozzle;"), "NOZZLE", 1),
        (format!("CapC {PLACE},{PLACE},v100,cd,wst,z1,head;"), "HEAD", 2),
        (format!("MoveLDO {PLACE},v100,z10,grip,do1,1;"), "GRIP", 1),
        (format!("MoveJSync {PLACE},v100,z10,grip,\"proc1\";"), "GRIP", 1),
        (format!("MoveCGO {PLACE},{PLACE},v100,z10,grip\\WObj:=w,go1\\Value:=3;"), "GRIP", 2),
        (format!("TriggL {PLACE},v100,trig1\\T2:=trig2,z10,grip;"), "GRIP", 1),
        (format!("SearchL\\Stop,di1,sp,{PLACE},v100,probe;"), "PROBE", 1),
        (format!("MoveL\\Conc,{PLACE},v100,z10,grip;"), "GRIP", 1),
    ] {
        let program = read(Dialect::Rapid, &module(std::slice::from_ref(&instruction)));
        assert_eq!(refused(&program), [0; 0], "{instruction} {:?}", program.notes());
        let inline: Vec<String> = tools(&program).into_iter().filter(|name| name == tool).collect();
        assert_eq!(inline.len(), points, "{instruction} {:?}", tools(&program));
    }
}

#[test]
fn rapid_instructions_that_are_not_known_are_refused_where_they_have_a_point() {
    let lines = [
        format!("MoveX {PLACE},v1,fine,tool0;"),
        "ArcWobble p1,v1,s,w,fine,tool0;".into(),
        "pickPart p2\\Fast;".into(),
        "IF a > 1 AND b THEN grab p1; ENDIF".into(),
        format!("MoveL {PLACE}\\Wobble,v1,fine,tool0;"),
        "MoveL Offs(p1,0,0,5),v1,fine,tool0;".into(),
        "TPWrite \"x\"\\Pos:=p1.trans;".into(),
        "WaitDI di1,1;".into(),
        "MoveExtJ e1,vrot10,fine;".into(),
        "MoveL p1,v1;".into(),
    ];
    let program = read(Dialect::Rapid, &module(&lines));
    assert_eq!(refused(&program), [6, 7, 8, 9, 10, 11, 15], "{:?}", program.notes());
    // Joints of the robot in it are not read.
    assert!(program.points().iter().all(|point| point.name != "E1"), "{:?}", tools(&program));
}

#[test]
fn krl_statements_that_are_not_understood_are_refused_where_they_have_a_point() {
    let text = "DEF a()\nDECL E6POS XA={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 2}\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nSPLINE\nSPL XA\nENDSPLINE\nLIN XA C_DIS C_ORI\nSCIRC XA, {X 1,Y 2,Z 3,A 4,B 5,C 6}, CA 180\n\
                LIN XA WOBBLE\nGLIDE {X 1,Y 2,Z 3,A 4,B 5,C 6}\nGLIDE XA\nFETCH(XA,5)\nFETCH(5)\nPTP $POS_ACT\nLIN $NULLFRAME\nSLIN_REL {Z 5}\nPTP XA #INITMOV\nEND\n";
    let program = read(Dialect::Krl, text);
    assert_eq!(refused(&program), [10, 11, 12, 13, 17], "{:?}", program.notes());
    let missing =
        program.notes().iter().find(|note| note.missing.is_some()).expect("a position of the controller");
    assert_eq!((missing.line, missing.missing.as_deref()), (16, Some("$NULLFRAME")));
}

#[test]
fn krl_settings_of_a_spline_and_of_a_motion_end_with_it() {
    let place = "{X 1,Y 2,Z 3,A 4,B 5,C 6}";
    let text = format!(
        "DEF a()\n$BASE=$NULLFRAME\n$TOOL=TOOL_DATA[1]\nSPLINE WITH $TOOL=TOOL_DATA[2]\nSPL {place}\nSPL {place} WITH $TOOL=TOOL_DATA[3]\n\
         SPL {place}\nENDSPLINE\nLIN {place}\nSLIN {place} WITH $IPO_MODE=#TCP\nLIN {place}\nEND\n"
    );
    let found = tools(&read(Dialect::Krl, &text));
    let numbers =
        ["TOOL_DATA[2]", "TOOL_DATA[3]", "TOOL_DATA[2]", "TOOL_DATA[1]", "not compensated", "TOOL_DATA[1]"];
    assert_eq!(found, numbers);
}

#[test]
fn krl_frames_that_change_while_the_program_runs_are_not_known() {
    let place = "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n";
    let data = "BASE_DATA[1]={X 1,Y 2,Z 3,A 0,B 0,C 0}\nBASE_DATA[2]={X 5,Y 2,Z 3,A 0,B 0,C 0}\n";
    let text = |more: &str| format!("DEF a()\n$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]\n{more}{place}END\n");
    let read =
        |text: &str| Program::read(text.as_bytes(), &[data.as_bytes()], Dialect::Krl).expect("a program");
    let frame = |program: &Program| match &program.points()[0].value {
        Value::Pose { frame: Reference::Named(name), .. } => match program.definitions().get(name) {
            Ok(Some(_)) => "known".into(),
            Ok(None) => "none".into(),
            Err(words) => words,
        },
        Value::Pose { frame: Reference::Unknown(words), .. } => words.clone(),
        _ => "other".into(),
    };
    assert_eq!(frame(&read(&text(""))), "known");
    assert_eq!(frame(&read(&text("BASE_DATA[2].Z=5\n"))), "known");
    assert_eq!(frame(&read(&text("$BASE.Z=$BASE.Z+10\n"))), "a part of it is set in line 4");
    for change in ["BASE_DATA[1].Z=5\n", "BASE_DATA[1]=CALC(3)\n", "BASE_DATA[I]=F\n"] {
        assert_eq!(
            frame(&read(&text(change))),
            "line 4 changes BASE_DATA[1] while the program runs",
            "{change}"
        );
    }
}

#[test]
fn fanuc_options_are_known_or_refused_in_the_language_of_the_controller() {
    let place = |number: usize, key: &str| {
        format!(
            "P[{number}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\t{key} : 'N U T, 0, 0, 0',\n\tX = 700.000 mm,\tY = 10.000 mm,\tZ = 300.000 mm,\n\tW = 180.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n}};\n"
        )
    };
    let lines = [
        "J P[1] 100% CNT50 ACC80 Wjnt TB .10sec,CALL GRAB_IT(1) ;",
        "L P[1:\"a Offset b\"] max_Geschw. FEIN PTH ;",
        "L P[1] 500mm/sek CNT100 ZEIT VOR   0.00sek,P-SPS ;",
        "L P[1] R[2]mm/sec CNT R[3] Arc Start[1,AR[2]] Skip,LBL[3] ;",
        "L P[1] 100mm/sec FINE Wobble,PR[1] ;",
        "L P[2] 100mm/sec FINE WKZ_Offset,PR[1] ;",
        "L P[3] 100mm/sec FINE RTCP ;",
        "PR[5]=P[1] ;",
        "TOUCH P[1] ;",
        "A[717]=AN ;",
        "S P[1] 100mm/sec FINE ;",
    ];
    let lines: String = lines.iter().enumerate().map(|(k, line)| format!("{:4}:{line}\n", k + 1)).collect();
    let points = [place(1, "KONFIG"), place(2, "CONFIG"), place(3, "CONFIG")].concat();
    let program = read(Dialect::Fanuc, &format!("/PROG A\n/ATTR\n/MN\n{lines}/POS\n{points}/END\n"));
    assert_eq!(refused(&program), [8, 11, 12], "{:?}", program.notes());
    let fixed = |k: usize| program.points()[k].fixed.clone();
    assert_eq!(fixed(0), None);
    assert!(fixed(1).unwrap().contains("WKZ_OFFSET in line 9"), "{:?}", fixed(1));
    assert!(fixed(2).unwrap().contains("RTCP"), "{:?}", fixed(2));
}

#[test]
fn inform_motions_that_are_not_known_are_refused_and_a_shift_ends() {
    let text = "/JOB\n//NAME A\n//POS\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=1,2,3,4,5,6\nC00001=2,3,4,5,6,7\nC00002=3,4,5,6,7,8\n//INST\nNOP\nMOVJ C00000 VJ=10.00 NWAIT\nSFTON P010\n\
                MOVL C00001 V=100.0 CV#(1) PL=0\nSFTOF\nMOVL C00002 V=10.0\nEIMOVL P011 V=10\nSVSPOTMOV C00002 V=10\nMOVL C00002 WOBBLE\nREFP 1 C00000\nEND\n";
    let program = read(Dialect::Inform, text);
    assert_eq!(refused(&program), [17, 18, 19], "{:?}", program.notes());
    let fixed: Vec<bool> = program.points().iter().map(|point| point.fixed.is_some()).collect();
    assert_eq!(fixed, [true, true, false]);
    let jumps = read(Dialect::Inform, &text.replace("NOP", "JUMP *A"));
    assert!(jumps.points().iter().all(|point| point.fixed.is_some()));
}

#[test]
fn a_tool_that_is_set_before_a_thread_holds_behind_it() {
    let text = "def job():\n  set_tcp(p[0,0,0.12,0,0,0])\n  thread watch():\n    while (True):\n      sync()\n    end\n  end\n  run watch()\n  def part():\n    movel(p[0.4,0.1,0.3,0,3,0])\n  end\n\
                movel(p[0.4,0.1,0.3,0,3,0])\n  part()\nend\n";
    let tools = |text: &str| tools(&read(Dialect::UrScript, text));
    assert_eq!(tools(text), ["given in the program", "given in the program"]);
    // A thread, or a routine, that sets another one.
    let other = text.replace("sync()", "set_tcp(p[0,0,0.3,0,0,0])");
    assert_eq!(tools(&other), ["unknown", "unknown"]);
}

#[test]
fn script_functions_that_are_not_known_are_refused_where_they_have_a_place() {
    let text = "def job():\n  w = p[0.4,0.1,0.3,0,3,0]\n  servol(w, 0, 0, 0.1)\n  speedl([0,0,0.1,0,0,0], 0.5, 1)\n  mc_add_linear(p[0.4,0.1,0.3,0,3,0], 0.1, 1, 0)\n  glide(w)\n  textmsg(\"at \", w)\n\
                if (a): movel(w)\n  end\n  track_conveyor_linear(p[1,0,0,0,0,0], 5)\n  set_digital_out(1, True)\n  set_payload(2.5, [0,0,0.05])\nend\n";
    let program = read(Dialect::UrScript, text);
    assert_eq!(refused(&program), [5, 6, 8, 10], "{:?}", program.notes());
}

#[test]
fn frames_and_tools_of_a_controller_are_read_from_its_files() {
    let point = |n: usize| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : {n}, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = 1.000 mm,\tY = 2.000 mm,\tZ = 3.000 mm,\n\tW = 0.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n}};\n"
        )
    };
    let job = format!("/PROG A\n/ATTR\n/MN\n1:L P[1] 5mm/sec FINE ;\n/POS\n{}/END\n", point(1));
    let variables = "[*SYSTEM*]$MCR  Storage: CMOS  Access: RW  : MCR_T\n[*SYSTEM*]$MNUFRAME  Storage: CMOS  Access: RW  : ARRAY[1,10] OF POSITION\n     [1,1] =   Group: 1   Config: N D B, 0, 0, 0\n\
                     \x20 X:   500.000   Y:    -1.500   Z:     0.000\n  W:     0.000   P:     0.000   R:    90.000\n     [1,2] =   Group: 1   Config: N D B, 0, 0, 0\n  X: ******** Y: ******** Z: ********\n\
                     [*SYSTEM*]$MNUTOOL  Storage: CMOS  Access: RW  : ARRAY[1,10] OF POSITION\n     [1,2] =   Group: 1   Config: N D B, 0, 0, 0\n  X:     0.000   Y:     0.000   Z:   210.000\n  W:     0.000   P:     0.000   R:     0.000\n";
    let all = Program::read_all(&[job.as_bytes(), variables.as_bytes()], Dialect::Fanuc).expect("programs");
    let of = |name: &str| all[0].definitions().get(name).expect("usable").map(|pose| pose.translation * 1e3);
    assert_eq!(of("UF1").map(|place| [place.x, place.y]), Some([500.0, -1.5]));
    assert!(of("UT2").is_some_and(|place| (place.z - 210.0).abs() < 1e-9));
    assert_eq!(of("UF2"), None);
    assert!(all[1].points().is_empty());

    let base = "MOC:CFG_1.0:5:0::\n#\nROBOT:\n\n      -name \"ROB_1\" -use_joint_1 \"rob1_1\" \\\n      -base_frame_pos_x 0.5 -base_frame_orient_u0 0\\\n      -base_frame_orient_u3 1\n#\nSINGLE:\n      -name \"T\" -base_frame_pos_x 9\n";
    let all =
        Program::read_all(&[module(&[]).as_bytes(), base.as_bytes()], Dialect::Rapid).expect("programs");
    let root = all[0].definitions().get("$ROBROOT").expect("usable").expect("a base");
    assert!((root.translation.x - 0.5).abs() < 1e-12 && (root.rotation[(0, 0)] + 1.0).abs() < 1e-12);
    let two = base.replace("#\nSINGLE", "      -name \"ROB_2\"\n#\nSINGLE");
    let all = Program::read_all(&[module(&[]).as_bytes(), two.as_bytes()], Dialect::Rapid).expect("programs");
    assert!(all[0].definitions().get("$ROBROOT").unwrap_err().contains("several robots"));
    let track = base.replace("#\nSINGLE", "      -base_frame_coordinated \"T\"\n#\nSINGLE");
    let all =
        Program::read_all(&[module(&[]).as_bytes(), track.as_bytes()], Dialect::Rapid).expect("programs");
    assert_eq!(all[0].definitions().get("$ROBROOT"), Ok(None));

    let job = "/JOB\n//NAME A\n//POS\n///TOOL 3\n///POSTYPE USER\n///USER 2\n///RECTAN\nC00000=1,2,3,0,0,0\n//INST\nMOVL C00000 V=5.0\nEND\n";
    let user = "//UFRAME 2\r\n///NAME TABLE\r\n///TOOL 0\r\n////BUSER 700.000,10.000,0.000,0.0000,0.0000,90.0000\r\n";
    let tool = "//TOOL 0\n///NAME \n0.000,0.000,0.000,0.00,0.00,0.00\n//TOOL 3\n///NAME GUN\n0.000,0.000,155.000,0.00,0.00,0.00\n2.0\n0.0,0.0,80.0\n";
    let all = Program::read_all(&[job.as_bytes(), user.as_bytes(), tool.as_bytes()], Dialect::Inform)
        .expect("jobs");
    let of = |name: &str| all[0].definitions().get(name).expect("usable").map(|pose| pose.translation * 1e3);
    assert!(of("USER 2").is_some_and(|place| (place.x - 700.0).abs() < 1e-9));
    assert!(of("TOOL 3").is_some_and(|place| (place.z - 155.0).abs() < 1e-9));
}

fn fanuc(head: &str, lines: &str, points: std::ops::Range<usize>) -> String {
    let place = |n: usize| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : {n}, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = 1.000 mm,\tY = 2.000 mm,\tZ = 3.000 mm,\n\tW = 0.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n}};\n"
        )
    };
    format!("/PROG A\n/ATTR\n{head}/MN\n{lines}/POS\n{}/END\n", points.map(place).collect::<String>())
}

#[test]
fn fanuc_statements_have_their_motions_whatever_their_numbers() {
    let lines = ":L P[1] 5mm/sec FINE ;\n:L P[2] 5mm/sec FINE ;\n: Arc Start[1] ;\n  3:L @P[3] 5mm/sec FINE Skip,LBL[1],PR[5]=LPOS ;\nL P[4] 5mm/sec FINE ;\n  4:L PAL_1[BTM] 5mm/sec FINE ;\n  5:A[717]=AN ;\n  6:J P[5] 5% FINE WEG VOR 0.0mm,P-SPS ;\n";
    let program = read(Dialect::Fanuc, &fanuc("", lines, 1..6));
    let reached: Vec<usize> = program.motions().map(|(line, _)| line).collect();
    assert_eq!(reached, [4, 5, 7, 8, 9, 11]);
    assert_eq!(refused(&program), [9], "{:?}", program.notes());
    assert!(program.reached().iter().all(|reached| *reached));
}

#[test]
fn fanuc_positions_that_something_displaces_are_fixed() {
    let fixed = |head: &str, lines: &str| {
        let program = read(Dialect::Fanuc, &fanuc(head, lines, 1..4));
        program.points().iter().map(|point| point.fixed.is_some()).collect::<Vec<_>>()
    };
    let lines = "1:L P[1] 5mm/sec FINE ;\n2:  Touch Offset PR[9] ;\n3:L P[2] 5mm/sec FINE ;\n4:  Touch Offset End ;\n5:L P[3] 5mm/sec FINE ;\n";
    assert_eq!(fixed("", lines), [false, true, false]);
    assert_eq!(fixed("LINE_TRACK_SCHEDULE_NUMBER\t: 1;\n", lines), [true; 3]);
    assert_eq!(fixed("LINE_TRACK_SCHEDULE_NUMBER\t: 0;\n", lines), [false, true, false]);
    // A frame that the program, or one that is given with it, sets.
    let sets = |line: &str| fanuc("", &format!("1:  {line} ;\n2:L P[1] 5mm/sec FINE ;\n"), 1..2);
    let frames = "[*SYSTEM*]$MNUFRAME  Storage: CMOS  Access: RW  : ARRAY[1,10] OF POSITION\n [1,1] =   Group: 1\n X: 5.0 Y: 0.0 Z: 0.0\n W: 0.0 P: 0.0 R: 0.0\n";
    let of = |text: &str, others: &[&str]| {
        let others: Vec<&[u8]> = others.iter().map(|other| other.as_bytes()).collect();
        Program::read(text.as_bytes(), &others, Dialect::Fanuc)
            .expect("a program")
            .definitions()
            .get("UF1")
            .map(|pose| pose.is_some())
    };
    assert_eq!(of(&sets("UFRAME[2]=PR[3]"), &[frames]), Ok(true));
    for line in ["UFRAME[1]=PR[3]", "UFRAME[R[2]]=PR[3]", "$MNUFRAME[1,1]=PR[3]"] {
        let words = "line 4 changes UF1 while the program runs".to_owned();
        assert_eq!(of(&sets(line), &[frames]), Err(words.clone()), "{line}");
        assert_eq!(of(&sets("CALL SUB"), &[frames, &sets(line)]), Err(words), "{line}");
    }
}

#[test]
fn krl_frames_without_names_are_those_of_their_first_lines() {
    let place = "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n";
    let text = format!(
        "DEF a()\n$BASE={{FRAME: X 5,Y 0,Z 0,A 0,B 0,C 0}}\n$TOOL={{X 0,Y 0,Z 9,A 0,B 0,C 0}}\n{place}$BASE={{X 7,Y 0,Z 0,A 0,B 0,C 0}}\n{place}\
         $BASE={{X 5.0,Y 0,Z 0,A 0,B 0,C 0}}\n{place}$TOOL={{Z 9}}\n{place}END\n"
    );
    let program = read(Dialect::Krl, &text);
    let frame = |value: &Value| match value {
        Value::Pose { frame: Reference::Named(name), .. } => name.clone(),
        _ => "other".into(),
    };
    let frames: Vec<String> = program.points().iter().map(|point| frame(&point.value)).collect();
    let [a, b] = ["$BASE in line 2", "$BASE in line 5"];
    assert_eq!(frames, [a, b, a, a]);
    let tool = "$TOOL in line 3";
    assert_eq!(tools(&program), [tool, tool, tool, "unknown"]);
    assert!(
        (program.definitions().get(b).expect("usable").expect("a value").translation.x - 7e-3).abs() < 1e-12
    );
}

#[test]
fn krl_statements_that_move_nothing_are_passed_over() {
    let text =
        "DEF a()\nDECL E6POS XA={X 1,Y 2,Z 3,A 4,B 5,C 6}\nBOOL XA\nWAIT FOR XA\nRETURN XA\nHOLD XA\nEND\n";
    assert_eq!(refused(&read(Dialect::Krl, text)), [6]);
}

#[test]
fn inform_bases_and_stations_are_external_axes_and_frames_may_be_set() {
    let job = |kind: &str, lines: &str| {
        let text = format!(
            "/JOB\n//NAME A\n//POS\n///TOOL 3\n///POSTYPE {kind}\n///USER 2\n///RECTAN\nC00000=1,2,3,0,0,0\nC00001=1,2,3,0,0,0\nBC00000=1500.5\nBC00001=0.000\nEC00001=5,90.000\n//INST\nNOP\n{lines}END\n"
        );
        read(Dialect::Inform, &text)
    };
    let program = job("USER", "MOVL C00000 BC00000 V=5.0\nMOVL C00001 BC00001 EC00001 V=5.0\n");
    assert_eq!(refused(&program), [0; 0], "{:?}", program.notes());
    assert_eq!(program.points()[0].external, [("BC1".to_owned(), 1500.5)]);
    let names: Vec<&str> = program.points()[1].external.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["BC1", "EC1", "EC2"]);
    let pulses = job("PULSE", "MOVL C00000 BC00000 V=5.0\nMOVL C00000 BC00001 V=5.0\n");
    assert_eq!(pulses.points()[0].external, [("BC1 in pulses".to_owned(), 1500.5)]);
    assert!(pulses.points()[0].fixed.is_some() && pulses.points()[1].fixed.is_none());
    let two = job("USER", "MOVL C00000 V=5.0  +MOVJ EC00001 VJ=1.0\nMOVL C00000 V=5.0 +MOVL C00001 V=5.0\n");
    assert_eq!(refused(&two), [0; 0], "{:?}", two.notes());
    assert_eq!(two.points()[0].external.len(), 2);
    assert!(two.points()[1].fixed.as_deref().is_some_and(|words| words.contains("another robot")));
    let sets = job("USER", "MFRAME UF#(2) C00000 C00001 C00001\nSETTOOL TL#(3) P000\n");
    for (name, line) in [("USER 2", 15), ("TOOL 3", 16)] {
        let words = format!("line {line} changes {name} while the job runs");
        assert_eq!(sets.definitions().get(name), Err(words));
    }
}
