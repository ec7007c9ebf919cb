//! Position registers of FANUC as points of the programs that move there.

use truepose_controllers::{Dialect, Program, Replacement, Value};

const REGISTERS: &str = "[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[2,6] OF Position Reg\n    [1,1] =   'HOME J1 = 3'   Group: 1\n  J1 =     9.998 deg   J2 =   -45.000 deg   J3 =    30.000 deg\n  \
J4 =    24.998 deg   J5 =   -90.000 deg   J6 =      .000 deg\n  EXT1:   700.000 mm\n\n    [1,2] =   '' Uninitialized\n    [1,3] =   'PICK'\n  Group: 1   Config: N U T, 0, 0, 0\n  \
X:   500.000   Y:     0.000   Z:   300.000\n  W:   180.000   P:     0.000   R:    90.000\n    [1,4] =   'MADE'\n  Group: 1   Config: F U T, 0, 0, 0\n  X:   500.000   Y:     0.000   Z:   300.000\n  \
W:   180.000   P:     0.000   R:    90.000\n  EXT1:  ******** mm\n    [1,5] =   'STARS' \n  Group: 1   Config: F U T, 0, 0, 0\n  X: ********   Y:     0.000   Z:   300.000\n  W:   180.000   P:     0.000   \
R:    90.000\n    [2,3] =   'PICK'   Group: 2\n  J1 =    12.000 deg\n[*POSREG*]$MAXPREGNUM  Storage: CMOS  Access: RW  : INTEGER = 6\n";

fn job(lines: &[&str]) -> String {
    let lines: String = lines.iter().enumerate().map(|(k, line)| format!("{:4}:{line} ;\n", k + 1)).collect();
    format!("/PROG  A\n/MN\n{lines}/POS\n/END\n")
}

/// Of each register that a program moves to: frame, tool or joints, external axes, and why it stays.
fn read(texts: &[&str]) -> (Vec<Program>, Vec<String>) {
    let texts: Vec<&[u8]> = texts.iter().map(|text| text.as_bytes()).collect();
    let programs = Program::read_all(&texts, Dialect::Fanuc).expect("programs");
    let registers = programs.last().expect("registers");
    let one = |(point, reached): (&truepose_controllers::Point, bool)| {
        let value = match &point.value {
            Value::Joints(values) => format!("{values:?}"),
            Value::Pose { frame, tool, .. } => format!("{frame:?} {tool:?}"),
        };
        let fixed = point.fixed.clone().unwrap_or_default();
        reached.then(|| format!("{} {value} {:?} {fixed}", point.name, point.external))
    };
    let all = registers.points().iter().zip(registers.reached()).filter_map(one).collect();
    (programs, all)
}

#[test]
fn registers_have_the_frame_and_tool_that_are_selected_where_a_motion_goes_there() {
    let text = job(&[
        "UFRAME_NUM=2",
        "UTOOL_NUM=3",
        "J PR[1:HOME] 10% FINE",
        "L PR[3] 100mm/sec FINE",
        "L PR[2] 5mm/sec FINE",
    ]);
    let (programs, all) = read(&[&text, REGISTERS]);
    assert_eq!(
        all,
        [
            "PR[1] [9.998, -45.0, 30.0, 24.998, -90.0, 0.0] [(\"E1\", 700.0)] ",
            "PR[3] Named(\"UF2\") Named(\"UT3\") [(\"GP2 J1\", 12.0)] "
        ]
    );
    let missing: Vec<_> = programs[0].notes().iter().filter_map(|note| note.missing.clone()).collect();
    assert_eq!(missing, ["PR[2]"]);
    // Nothing changes but its numbers.
    let registers = &programs[1];
    let new = |point: &truepose_controllers::Point| {
        (point.name == "PR[3]").then(|| Replacement {
            numbers: vec![501.2344, -0.5, 300.0, 180.0, 0.25, 90.0],
            turns: Vec::new(),
        })
    };
    let new: Vec<_> = registers.points().iter().map(new).collect();
    let out = String::from_utf8(registers.rewritten(&new).expect("a text")).expect("UTF-8");
    let expected = REGISTERS.replacen(
        "X:   500.000   Y:     0.000   Z:   300.000\n  W:   180.000   P:     0.000   R:    90.000",
        "X:   501.234   Y:    -0.500   Z:   300.000\n  W:   180.000   P:     0.250   R:    90.000",
        1,
    );
    assert_eq!(out, expected);
}

#[test]
fn registers_that_programs_change_or_use_differently_are_not_taken_as_they_stand() {
    let go = "L PR[4] 100mm/sec FINE";
    let of = |lines: &[&str], others: &[&str]| {
        let text = job(lines);
        read(&[&[text.as_str()], others, &[REGISTERS]].concat()).1
    };
    for line in
        ["PR[4]=LPOS", "PR[4,3]=PR[4,3]+10", "PR[R[1]]=LPOS", "L P[1] 5mm/sec FINE Skip,LBL[1],PR[4]=LPOS"]
    {
        let all = of(&["UFRAME_NUM=1", "UTOOL_NUM=1", line, go], &[]);
        assert!(all[0].contains("line 5 gives it another value while the program runs"), "{all:?}");
    }
    let all = of(&["UFRAME_NUM=1", "UTOOL_NUM=1", go, "UFRAME_NUM=2", go], &[]);
    assert!(all[0].contains("it is used with UF1 and with UF2"), "{all:?}");
    let all = of(
        &["UFRAME_NUM=1", "IF R[1]=1,JMP LBL[1]", "UFRAME_NUM=2", "LBL[1]", "UTOOL_NUM=1", go, "UTOOL_NUM=2"],
        &[],
    );
    assert!(all[0].contains("the program jumps, and has several UTOOL_NUMs"), "{all:?}");
    // What a called program selects.
    let init = "/PROG  INIT\n/MN\n   1:  UFRAME_NUM=0 ;\n   2:  UTOOL_NUM=5 ;\n/POS\n/END\n";
    assert_eq!(of(&["CALL INIT", go], &[init]), ["PR[4] Identity Named(\"UT5\") [(\"E1\", NaN)] "]);
    assert!(of(&["CALL INIT", go], &[])[0].contains("INIT is called in line 3, which may change UFRAME_NUM"));
    let all = of(
        &["UFRAME_NUM=1", "UTOOL_NUM=1", "L PR[4] 100mm/sec FINE Offset,PR[3]", "L PR[5] 5mm/sec FINE"],
        &[],
    );
    assert!(
        all[0].contains("displaces it") && all[1].contains("are not understood, or are not set"),
        "{all:?}"
    );
}
