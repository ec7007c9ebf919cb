//! Programs in every language, written at random with everything that editors and people leave in them; the generator knows where the
//! points' numbers are.

mod data;
mod draw;
mod mutation;

use data::{inform, script, val3};
pub use draw::Draw;
pub use mutation::mutated;

use std::ops::Range;
use truepose_controllers::Dialect;

/// A program, and the byte ranges of the numbers of its points.
pub struct Written {
    pub text: Vec<u8>,
    pub numbers: Vec<Range<usize>>,
    pub points: usize,
}

struct Writer<'d> {
    draw: &'d mut Draw,
    written: Written,
    end: &'static [u8],
}

/// Texts in the code page of Windows and in UTF-8, with what looks like a point in them.
const WORDS: [&[u8]; 8] = [
    b"pick",
    b"Greifer \xf6ffnen",
    "Größe ≈ 5°".as_bytes(),
    b"LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}",
    b"p10:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    b"movel(p[1,2,3,0,0,0])",
    b"P[7]{ GP1: X = 1.000 mm",
    b"\x80uro\x99 \xb0C",
];

impl Writer<'_> {
    fn put(&mut self, bytes: impl AsRef<[u8]>) {
        self.written.text.extend_from_slice(bytes.as_ref());
    }

    fn line(&mut self, bytes: impl AsRef<[u8]>) {
        self.put(bytes);
        let end = self.end;
        self.put(end);
    }

    /// Blanks, sometimes none.
    fn gap(&mut self) {
        let gap = self.draw.of(&["", "", " ", "  ", "\t"]);
        self.put(gap);
    }

    /// A number of a point.
    fn number(&mut self, value: f64) {
        let text = match self.draw.below(9) {
            0 => format!("{value:.0}"),
            1 => format!("{value:.1}"),
            2 => format!("{value:.6}"),
            3 => format!("{value:.4e}"),
            4 if value > 0.0 => format!("+{value:.3}"),
            5 if value.abs() < 1.0 => format!("{value:.3}").replacen("0.", ".", 1),
            6 => format!("{value:.0}."),
            _ => format!("{value:.3}"),
        };
        self.plain(&text);
    }

    fn plain(&mut self, text: &str) {
        let start = self.written.text.len();
        self.put(text);
        self.written.numbers.push(start..start + text.len());
    }

    fn place(&mut self) -> [f64; 3] {
        [0; 3].map(|_| self.draw.within(-2000.0, 2000.0))
    }

    fn angles(&mut self) -> [f64; 3] {
        [self.draw.within(-179.0, 179.0), self.draw.within(-89.0, 89.0), self.draw.within(-179.0, 179.0)]
    }
}

/// A program with about so many points.
pub fn program(dialect: Dialect, points: usize, draw: &mut Draw) -> Written {
    let end: &[u8] = if draw.chance(50) { b"\r\n" } else { b"\n" };
    let written = Written { text: Vec::new(), numbers: Vec::new(), points };
    let mut writer = Writer { draw, written, end };
    match dialect {
        Dialect::Krl => krl(&mut writer, points),
        Dialect::Rapid => rapid(&mut writer, points),
        Dialect::Fanuc => fanuc(&mut writer, points),
        Dialect::UrScript => script(&mut writer, points),
        Dialect::Inform => inform(&mut writer, points),
        Dialect::Val3 => val3(&mut writer, points),
    }
    writer.written
}

fn comment(writer: &mut Writer<'_>, sign: &[u8]) {
    if writer.draw.chance(25) {
        let word = writer.draw.of(&WORDS);
        writer.put(sign);
        writer.put(word);
    }
}

fn krl(writer: &mut Writer<'_>, points: usize) {
    if writer.draw.chance(30) {
        writer.line("&ACCESS RVP");
        writer.line("&REL 7");
    }
    writer.line("DEF job( )");
    writer.line(";FOLD INI;%{PE}");
    writer.line("BAS (#INITMOV,0 )");
    writer.line("$BASE=BASE_DATA[1]");
    writer.line("$TOOL = TOOL_DATA[2]");
    for k in 0..points {
        comment(writer, b";");
        writer.line("");
        let joints = writer.draw.chance(30);
        let kind = match (joints, writer.draw.chance(50)) {
            (true, true) => "E6AXIS",
            (true, false) => "AXIS",
            (false, true) => "E6POS",
            (false, false) => "POS",
        };
        let head = match writer.draw.below(4) {
            0 => format!("DECL {kind} XP{k}={{"),
            1 => format!("decl global {kind} xp{k} = {{{kind}: "),
            2 => writer.draw.of(&["PTP {", "LIN\t{", "slin  {", "PTP{"]).into(),
            _ => format!("XQ[{k}]={{"),
        };
        writer.put(&head);
        let names =
            if joints { ["A1", "A2", "A3", "A4", "A5", "A6"] } else { ["X", "Y", "Z", "A", "B", "C"] };
        let (place, angles) = (writer.place(), writer.angles());
        let values: Vec<f64> = if joints {
            angles.iter().chain(&angles).copied().collect()
        } else {
            place.iter().chain(&angles).copied().collect()
        };
        for (k, (name, value)) in names.iter().zip(values).enumerate() {
            if k > 0 {
                writer.put(",");
                writer.gap();
            }
            writer.put(name);
            let blanks = writer.draw.of(&[" ", " ", "  ", "    "]);
            writer.put(blanks);
            writer.number(value);
            if writer.draw.chance(5) {
                writer.put(" ");
            }
        }
        if !joints && writer.draw.chance(70) {
            let tail = writer.draw.of(&[",S 2,T 35", ", S 'B010', T 'B100011'", ",S 6,T 50,E1 0.0,E2 0.0"]);
            writer.put(tail);
        }
        writer.put("}");
        if writer.draw.chance(20) && head.starts_with(['P', 'L']) {
            writer.put(" C_DIS");
        }
        comment(writer, b" ;");
        writer.line("");
        if writer.draw.chance(20) {
            writer.line("MsgNotify(\"LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\")");
        }
        if writer.draw.chance(20) {
            writer.line("DECL FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE,POINT2[] \" \"}");
        }
    }
    writer.put("END");
}

fn rapid(writer: &mut Writer<'_>, points: usize) {
    writer.line("MODULE Job(SYSMODULE)");
    writer.line("  PERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];");
    for k in 0..points {
        let joints = writer.draw.chance(30);
        let (kind, storage) = (
            if joints { "jointtarget" } else { "robtarget" },
            writer.draw.of(&["CONST", "LOCAL PERS", "var", "TASK PERS"]),
        );
        let colon = writer.draw.of(&[":=", " := ", ":=  "]);
        writer.put(format!("  {storage} {kind} p{k}{colon}["));
        let place = writer.place();
        let angles = writer.angles();
        writer.put("[");
        let first: Vec<f64> =
            if joints { angles.iter().chain(&angles).copied().collect() } else { place.to_vec() };
        list(writer, &first);
        writer.put("],");
        split(writer, b"!");
        if !joints {
            writer.put("[");
            let half = angles[0].to_radians() / 2.0;
            let quaternion = [half.cos(), 0.0, half.sin(), 0.0];
            for (k, value) in quaternion.iter().enumerate() {
                let text = format!("{value:.9}");
                writer.put(if k > 0 { "," } else { "" });
                writer.plain(&text);
            }
            writer.put("],[");
            let config = [0; 4].map(|k| k + writer.draw.below(4) as i64 - 2);
            writer.put(format!("{},{},{},{}],", config[0], config[1], config[2], 0));
            split(writer, b"!");
        }
        writer.put("[9E+09,9E9,9E+9,9E9,9e9,9E9]]");
        split(writer, b"!");
        writer.line(";");
        if writer.draw.chance(30) {
            comment(writer, b"! ");
            writer.line("");
        }
    }
    writer.line("  PROC main()");
    writer.line("    TPWrite \"p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\";");
    for k in 0..points {
        writer.line(format!("    MoveL p{k},v100,z1,t1;"));
    }
    writer.line("  ENDPROC");
    writer.put("ENDMODULE");
}

fn list(writer: &mut Writer<'_>, values: &[f64]) {
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            writer.gap();
            writer.put(",");
            writer.gap();
        }
        writer.number(*value);
    }
}

/// A line's end inside of a statement, with a comment sometimes.
fn split(writer: &mut Writer<'_>, sign: &[u8]) {
    if writer.draw.chance(20) {
        comment(writer, sign);
        writer.line("");
        writer.put("      ");
    }
}

fn fanuc(writer: &mut Writer<'_>, points: usize) {
    writer.line("/PROG  JOB");
    writer.line("/ATTR");
    writer.line("COMMENT\t\t= \"P[1]{\";");
    writer.line("/MN");
    for k in 0..points {
        writer.line(format!("{:4}:L P[{}] 100mm/sec FINE    ;", k + 1, k + 1));
    }
    writer.line(format!("{:4}:  !L P[99] 100mm/sec ;", points + 1));
    writer.line("/POS");
    for k in 0..points {
        let joints = writer.draw.chance(30);
        let name = if writer.draw.chance(30) { ":\"GP1: X = 5 }\"" } else { "" };
        writer.line(format!("P[{}{name}]{{", k + 1));
        writer.line("   GP1:");
        let (place, angles) = (writer.place(), writer.angles());
        if joints {
            writer.line("\tUF : 0, UT : 1,\t");
        } else {
            let config = writer.draw.of(&["N U T, 0, 0, 0", "F D B, 0, 0, -1", "NUT,0,0,0"]);
            writer.line(format!("\tUF : 1, UT : 2,\t\tCONFIG : '{config}',"));
        }
        let names =
            if joints { ["J1", "J2", "J3", "J4", "J5", "J6"] } else { ["X", "Y", "Z", "W", "P", "R"] };
        for (k, name) in names.iter().enumerate() {
            let value = if k < 3 && !joints { place[k] } else { angles[k % 3] };
            let mut text = format!("{value:.3}");
            if value.abs() < 1.0 {
                text = text.replacen("0.", ".", 1);
            }
            let unit = if k < 3 && !joints { " mm" } else { "deg" };
            writer.put(format!("\t{name} = {}", " ".repeat(9usize.saturating_sub(text.len()))));
            writer.plain(&text);
            writer.put(format!(" {unit}"));
            writer.put(if k < 5 { "," } else { "" });
            if k == 2 || k == 5 {
                writer.line("");
            }
        }
        writer.line("};");
    }
    writer.put("/END");
}
