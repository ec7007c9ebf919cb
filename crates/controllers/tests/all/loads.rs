//! Which load is active at a point.

use truepose_controllers::{Carried, Dialect, Program};

/// Name, mass and centre (mm) of the load of each point; the reason where it is open.
fn loads(dialect: Dialect, text: &str, others: &[&str]) -> Vec<String> {
    let others: Vec<&[u8]> = others.iter().map(|text| text.as_bytes()).collect();
    let program = Program::read(text.as_bytes(), &others, dialect).expect("a program");
    let one = |carried: &Carried| match carried {
        Carried::Mass { name, mass, com } => {
            let [x, y, z] = [com.x, com.y, com.z].map(|v| (1e6 * v).round() / 1e3);
            format!("{name} {mass} {x} {y} {z}")
        }
        Carried::Open(words) => words.clone(),
    };
    program.points().iter().map(|point| one(&point.carried)).collect()
}

#[test]
fn rapid_has_the_tools_load_and_what_is_gripped() {
    let place = "[[700,10,640],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let head = "MODULE M\nPERS tooldata grip:=[TRUE,[[0,0,300],[0,1,0,0]],[20,[0,0,100],[1,0,0,0],0,0,0]];\n\
                PERS loaddata part:=[10,[0,30,-40],[1,0,0,0],0,0,0];\nPERS loaddata both:=[33,[1,2,3],[1,0,0,0],0,0,0];\n";
    let run = |lines: &[&str]| {
        let lines: Vec<String> = lines.iter().map(|line| line.replace('@', place)).collect();
        loads(Dialect::Rapid, &format!("{head}PROC main()\n{}\nENDPROC\nENDMODULE\n", lines.join("\n")), &[])
    };
    let go = "MoveL @,v1,fine,grip;";
    assert_eq!(
        run(&[go, "MoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,grip;"]),
        ["GRIP 20 0 0 100"; 2]
    );
    assert_eq!(run(&["MoveL @,v1,fine,grip\\TLoad:=both;"]), ["BOTH 33 1 2 3"]);
    assert_eq!(run(&["MoveL @,v1,fine,tool0;"]), ["tool0 0 0 0 0"]);
    assert_eq!(run(&["MoveL @,v1,fine,other;"]), ["the load of OTHER has no value in the files given"]);
    // The part's centre is in the tool's frame, which is turned about x.
    let open = "whether a load of GripLoad is active is not clear";
    let both = "GRIP and PART 30 0 -10 180";
    assert_eq!(
        run(&["GripLoad load0;", go, "GripLoad part;", "SetDO a,1;", go, "GripLoad load0;", go]),
        ["GRIP 20 0 0 100", both, "GRIP 20 0 0 100"]
    );
    assert_eq!(run(&[go, "GripLoad part;", go, "Grab;", go]), [open, both, open]);
    assert_eq!(
        run(&["GripLoad load0;", "IF a THEN", "GripLoad part;", go, "ELSE", go, "ENDIF", go]),
        [
            both,
            "GRIP 20 0 0 100",
            "it is set in a branch or a loop, and the program may come here without it"
        ]
    );
    assert_eq!(
        run(&["GripLoad load0;", "IF a THEN", "IF b THEN", "x:=1;", "ENDIF", "GripLoad part;", "ENDIF", go]),
        ["it is set in a branch or a loop, and the program may come here without it"]
    );
}

#[test]
fn krl_has_the_load_of_the_tools_number() {
    let config = "DEFDAT $CONFIG\nDECL LOAD LOAD_DATA[16]\nLOAD_DATA[1]={M 12.0,CM {X 10.0,Y 0.0,Z 80.0,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}\n\
                  LOAD_DATA[2]={M -1.0,CM {X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}\nENDDAT\n";
    let text = "DEF a()\nDECL FDAT FP1={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}\nPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nBAS(#TOOL,1)\n\
                PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nBAS(#TOOL,2)\nPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nBAS(#TOOL,3)\n\
                PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\n$LOAD={M 5.0,CM {X 0.0,Y 7.0,Z 0.0},J {X 0.0,Y 0.0,Z 0.0}}\n\
                PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nFDAT_ACT=FP1\nPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nFETCH(1)\n\
                SPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6} WITH $LOAD=SLOAD(FP1)\nPTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nEND\n";
    assert_eq!(
        loads(Dialect::Krl, text, &[config]),
        [
            "$LOAD is not set before",
            "LOAD_DATA[1] 12 10 0 80",
            "LOAD_DATA[2] is the largest load (M is negative)",
            "the load of LOAD_DATA[3] has no value in the files given",
            "$LOAD in line 10 5 0 7 0",
            "LOAD_DATA[1] 12 10 0 80",
            "LOAD_DATA[1] 12 10 0 80",
            "FETCH is called before, which may change it"
        ]
    );
}

#[test]
fn fanuc_has_the_payload_schedule() {
    let point = |n: usize| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\n\tJ1= 0.0 deg,\tJ2= 0.0 deg,\tJ3= 0.0 deg,\n\tJ4= 0.0 deg,\tJ5= 0.0 deg,\tJ6= 0.0 deg\n}};\n"
        )
    };
    let job = |lines: &[&str]| {
        let lines: String =
            lines.iter().enumerate().map(|(k, line)| format!("{:4}:{line} ;\n", k + 1)).collect();
        format!("/PROG A\n/ATTR\n/MN\n{lines}/POS\n{}{}{}/END\n", point(1), point(2), point(3))
    };
    let field = |n: usize, part: &str, value: f64| {
        format!("     Field: $PLST_GRP1[{n}].$PAYLOAD{part} Access: RW: REAL = {value:e}\n")
    };
    let mut variables = String::from(
        "[*SYSTEM*]$PLST_GRP1  Storage: CMOS  Access: RW  : ARRAY[10] OF PLST_GRP_T\n     Field: $PLST_GRP1[1].$COMMENT Access: RW: STRING[16] = ''\n",
    );
    for (n, mass) in [(1, 148.0), (2, -9999.0)] {
        variables += &(field(n, "", mass)
            + &field(n, "_X", 1.5)
            + &field(n, "_Y", 0.0)
            + &field(n, "_Z", 20.0)
            + &field(n, "_IX", 3.0));
    }
    let run = |lines: &[&str]| loads(Dialect::Fanuc, &job(lines), &[&variables]);
    let go = |n: usize| format!("J P[{n}] 10% FINE");
    let [one, two, three] = [go(1), go(2), go(3)];
    assert_eq!(
        run(&[&one, "PAYLOAD[1]", &two, "PAYLOAD[2]", &three]),
        ["no PAYLOAD is before it", "PAYLOAD[1] 148 15 0 200", "PAYLOAD[2] is not set"]
    );
    assert_eq!(
        run(&["PAYLOAD[1]", &one, &two, "PAYLOAD[3]", &two, &three])[1..],
        ["it is used with several PAYLOADs", "the load of PAYLOAD[3] has no value in the files given"]
    );
    let jumps = run(&["PAYLOAD[1]", &one, "IF R[1]=1,JMP LBL[1]", "PAYLOAD[3]", "LBL[1]", &two, &three]);
    assert_eq!(jumps, ["the program jumps, and has several PAYLOADs"; 3]);
    assert_eq!(run(&["PAYLOAD[1]", &one, "JMP LBL[1]", &two, &three]), ["PAYLOAD[1] 148 15 0 200"; 3]);
}

#[test]
fn scripts_and_jobs_have_their_loads() {
    let text = "def job():\n  movej([0,1,1,0,1,0])\n  set_payload(2.5, [0, 0.01, 0.05])\n  movej([0,1,1,0,1,0])\n  def part():\n    movej([0,1,1,0,1,0])\n  end\n\
                set_target_payload(4, [0,0,0], [0,0,0,0,0,0])\n  part()\n  movej([0,1,1,0,1,0])\n  set_payload(m)\n  movej([0,1,1,0,1,0])\nend\n";
    assert_eq!(
        loads(Dialect::UrScript, text, &[]),
        [
            "set_payload is not called before",
            "set_payload in line 3 2.5 0 10 50",
            "a routine may be called with another load",
            "set_target_payload in line 8 4 0 0 0",
            "set_payload in line 11 has not a mass and a centre of gravity that are numbers"
        ]
    );
    let job = "/JOB\n//NAME A\n//POS\n///TOOL 3\n///POSTYPE PULSE\n///PULSE\nC00000=1,2,3,4,5,6\n///TOOL 0\nC00001=1,2,3,4,5,6\n//INST\nMOVJ C00000 VJ=5.0\nMOVJ C00001 VJ=5.0\nEND\n";
    let zero =
        "//TOOL 0\n///NAME \n0.000,0.000,0.000,0.00,0.00,0.00\n0.000,0.000,0.000\n0.000\n0.000,0.000,0.000\n";
    for weight in ["0.000,5.000,80.000\n2.500\n0.1,0.1,0.1\n", "2.500\n0.000,5.000,80.000\n0.1,0.1,0.1\n"] {
        let tool = format!("{zero}//TOOL 3\n///NAME GUN\n0.000,0.000,155.000,0.00,0.00,0.00\n{weight}");
        assert_eq!(
            loads(Dialect::Inform, job, &[&tool]),
            ["TOOL 3 2.5 0 5 80", "the load of TOOL 0 has no value in the files given"]
        );
    }
    assert_eq!(loads(Dialect::Inform, job, &[])[0], "the load of TOOL 3 has no value in the files given");
}

#[test]
fn rapid_loads_are_those_of_the_controllers_mode() {
    let place = "[[700,10,640],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let text = format!(
        "MODULE M\nPERS tooldata grip:=[TRUE,[[0,0,300],[0,1,0,0]],[20,[0,0,100],[1,0,0,0],0,0,0]];\nPERS loaddata part:=[10,[0,30,-40],[1,0,0,0],0,0,0];\n\
         PROC main()\nGripLoad part;\nMoveL {place},v1,fine,grip;\nMoveL {place},v1,fine,grip\\TLoad:=part;\nENDPROC\nENDMODULE\n"
    );
    let system = |misc: &str| {
        format!(
            "SYS:CFG_1.0:6:0::\n#\nSYS_MISC:\n\n      -Name \"NoOfRetry\" -Value 4\n\n{misc}#\nCAB_TASKS:\n      -Name \"ModalPayLoadMode\"\n"
        )
    };
    let of = |misc: &str| loads(Dialect::Rapid, &text, &[&system(misc)]);
    assert_eq!(of(""), ["GRIP and PART 30 0 -10 180", "PART and PART 20 0 0 150"]);
    let modal = "      -Name \"ModalPayLoadMode\" -Value 1\n";
    assert_eq!(of(modal), ["GRIP and PART 30 0 -10 180"; 2]);
    assert_eq!(of("      -Name \"ModalPayLoadMode\"\n"), ["GRIP 20 0 0 100", "PART 10 0 30 -40"]);
    let wrist = format!("{modal}      -Name \"PayloadsInWristCoords\"\\\n      -Value 1\n");
    assert_eq!(of(&wrist), ["GRIP and PART 30 0 10 53.333"; 2]);
    let other = Program::read(b"EIO:CFG_1.0:6:0::\n", &[], Dialect::Rapid).expect_err("of inputs");
    assert!(other.to_string().contains("topic EIO, which has no frames, tools or loads"), "{other}");
}

#[test]
fn fanuc_payloads_are_changed_by_the_programs_that_are_called() {
    let places: String =
        (1..=5).map(|n| format!("P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\n\tJ1= 0.000 deg\n}};\n")).collect();
    let job = |lines: &str| format!("/PROG  A\n/MN\n{lines}/POS\n{places}/END\n");
    let table = "Field: $PLST_GRP1[1].$PAYLOAD Access: RW: REAL = 8.0\nField: $PLST_GRP1[1].$PAYLOAD_X Access: RW: REAL = 0\n\
                 Field: $PLST_GRP1[1].$PAYLOAD_Y Access: RW: REAL = 0\nField: $PLST_GRP1[1].$PAYLOAD_Z Access: RW: REAL = 5.0\n";
    let other = |name: &str, lines: &str| format!("/PROG  {name}\n/MN\n{lines}/POS\n/END\n");
    let text = job(
        "1:  PAYLOAD[GP1:1] ;\n2:  PAYLOAD[GP2:3] ;\n3:J P[1] 5% FINE ;\n4:  CALL DOOR ;\n5:J P[2] 5% FINE TB .10sec,CALL GRIP ;\n6:J P[3] 5% FINE ;\n7:  PAYLOAD[1] ;\n8:  CALL FAR(1) ;\n9:J P[4] 5% FINE ;\n10:  TRAGLST[1] ;\n11:  WENN E[1]=AN,AUFRUF DOOR ;\n12:J P[5] 5% FEIN ;\n",
    );
    let others = [
        table.to_owned(),
        other("DOOR", "1:  CALL WAIT_IT ;\n"),
        other("WAIT_IT", "1:  WAIT 1.00(sec) ;\n"),
        other("GRIP", "1:  CALL PAY ;\n"),
        other("PAY", "1:  PAYLOAD[2] ;\n"),
    ];
    let others: Vec<&str> = others.iter().map(String::as_str).collect();
    let found = loads(Dialect::Fanuc, &text.replace("WENN", "CASE"), &others);
    let known = "PAYLOAD[1] 8 0 0 50";
    assert_eq!(
        found,
        [
            known,
            known,
            "the load of PAYLOAD[2] has no value in the files given",
            "FAR is called in line 10, which may change PAYLOAD (--with the program that is called)",
            known
        ]
    );
    let jumps = loads(Dialect::Fanuc, &text, &others);
    assert!(jumps.iter().all(|load| load.contains("the program jumps")), "{jumps:?}");
}
