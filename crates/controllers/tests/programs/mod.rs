//! Programs in every language, written at random with everything that editors and people leave in them; the generator knows where the
//! points' numbers are.

use std::ops::Range;
use truepose_controllers::Dialect;

/// A small generator of random numbers (Knuth's MMIX constants).
pub struct Draw(u64);

impl Draw {
    pub fn new(seed: u64) -> Draw {
        let mut draw = Draw(seed ^ 0x9e37_79b9_7f4a_7c15);
        draw.next();
        draw
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let x = self.0 ^ (self.0 >> 29);
        x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 16
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    pub fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn within(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * (self.next() % 1_000_000) as f64 / 1e6
    }
}

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
        let names = if joints { ["A1", "A2", "A3", "A4", "A5", "A6"] } else { ["X", "Y", "Z", "A", "B", "C"] };
        let (place, angles) = (writer.place(), writer.angles());
        let values: Vec<f64> = if joints { angles.iter().chain(&angles).copied().collect() } else { place.iter().chain(&angles).copied().collect() };
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
        let (kind, storage) =
            (if joints { "jointtarget" } else { "robtarget" }, writer.draw.of(&["CONST", "LOCAL PERS", "var", "TASK PERS"]));
        let colon = writer.draw.of(&[":=", " := ", ":=  "]);
        writer.put(format!("  {storage} {kind} p{k}{colon}["));
        let place = writer.place();
        let angles = writer.angles();
        writer.put("[");
        let first: Vec<f64> = if joints { angles.iter().chain(&angles).copied().collect() } else { place.to_vec() };
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
        let names = if joints { ["J1", "J2", "J3", "J4", "J5", "J6"] } else { ["X", "Y", "Z", "W", "P", "R"] };
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

fn script(writer: &mut Writer<'_>, points: usize) {
    writer.line("def job():");
    writer.line("  set_tcp(p[0,0,0.1,0,0,0])");
    for k in 0..points {
        let joints = writer.draw.chance(30);
        let values: Vec<f64> = (0..6).map(|_| writer.draw.within(-1.5, 1.5)).collect();
        let named = writer.draw.chance(40);
        let verb = writer.draw.of(&["movej", "movel", "movep"]);
        match (named, joints) {
            (true, true) => writer.put(format!("  global q_{k} = [")),
            (true, false) => writer.put(format!("  w_{k}=p[")),
            (false, true) => writer.put("  movej(["),
            (false, false) => writer.put(format!("  {verb}(p[")),
        }
        for (k, value) in values.iter().enumerate() {
            if k > 0 {
                writer.put(",");
                writer.gap();
                if writer.draw.chance(5) {
                    comment(writer, b"#");
                    writer.line("");
                }
            }
            writer.number(*value);
        }
        writer.put("]");
        if named {
            comment(writer, b" #");
            writer.line("");
            writer.put(format!("  {verb}({}_{k}", if joints { "q" } else { "w" }));
        }
        writer.put(", a=1.2, v=0.25)");
        comment(writer, b" # ");
        writer.line("");
        if writer.draw.chance(20) {
            writer.line("  textmsg(\"movel(p[1,2,3,0,0,0])\")");
        }
    }
    writer.put("end");
}

fn inform(writer: &mut Writer<'_>, points: usize) {
    writer.line("/JOB");
    writer.line("//NAME JOB");
    writer.line("//POS");
    writer.line(format!("///NPOS {points},0,0,0,0,0"));
    writer.line("///TOOL 0");
    let mut pulses = None;
    for k in 0..points {
        let now = writer.draw.chance(40);
        if pulses != Some(now) {
            for line in if now {
                ["///POSTYPE PULSE", "///PULSE", ""]
            } else {
                ["///POSTYPE BASE", "///RECTAN", "///RCONF 0,0,0,0,0,0,0,0"]
            } {
                if !line.is_empty() {
                    writer.line(line);
                }
            }
            pulses = Some(now);
        }
        writer.put(format!("C{k:05}="));
        let (place, angles) = (writer.place(), writer.angles());
        for part in 0..6 {
            let value = if part < 3 { place[part] } else { angles[part - 3] };
            let text = if now {
                format!("{:.0}", 100.0 * value)
            } else {
                format!("{value:.decimals$}", decimals = if part < 3 { 3 } else { 4 })
            };
            if part > 0 {
                writer.put(",");
            }
            writer.plain(&text);
        }
        writer.line("");
    }
    writer.line("//INST");
    writer.line("///DATE 2024/01/01 10:00");
    writer.line("NOP");
    for k in 0..points {
        if writer.draw.chance(20) {
            let word = writer.draw.of(&WORDS);
            writer.put("'");
            writer.line(word);
        }
        writer.line(format!("MOVL C{k:05} V=93.0"));
    }
    writer.put("END");
}

fn val3(writer: &mut Writer<'_>, points: usize) {
    writer.line("<?xml version=\"1.0\" encoding=\"utf-8\" ?>");
    writer.line("<Database xmlns=\"http://www.staubli.com/robotics/VAL3/Data/2\">");
    writer.line("  <Datas>");
    for k in 0..points {
        let joints = writer.draw.chance(30);
        let kind = if joints { "jointRx" } else { "pointRx" };
        writer.line(format!("    <Data name=\"p{k}\" access=\"private\" xsi:type=\"array\" type=\"{kind}\" size=\"1\">"));
        let names = if joints { ["j1", "j2", "j3", "j4", "j5", "j6"] } else { ["x", "y", "z", "rx", "ry", "rz"] };
        let (place, angles) = (writer.place(), writer.angles());
        writer.put("      <Value key=\"0\"");
        for (k, name) in names.iter().enumerate() {
            let value = if k < 3 && !joints { place[k] } else { angles[k % 3] };
            writer.put(format!(" {name}=\""));
            writer.number(value);
            writer.put("\"");
        }
        if !joints {
            writer.put(" shoulder=\"lefty\" elbow=\"epositive\" wrist=\"wpositive\" fatherId=\"world[0]\"");
        }
        writer.line(" />");
        if writer.draw.chance(30) {
            writer.line("      <!-- <Value key=\"1\" x=\"5\" -- /> -->");
        }
        writer.line("    </Data>");
    }
    writer.line("  </Datas>");
    writer.put("</Database>");
}

/// A few changes of a text at random places.
pub fn mutated(text: &[u8], draw: &mut Draw) -> Vec<u8> {
    const BYTES: &[u8] = b"{}[]()\"';!#,.:=-+0159eExXPpC \n\r\t\\\x00\xff<>/*";
    let mut text = text.to_vec();
    for _ in 0..1 + draw.below(4) {
        if text.is_empty() {
            break;
        }
        let at = draw.below(text.len());
        let length = 1 + draw.below(12);
        let end = (at + length).min(text.len());
        match draw.below(6) {
            0 => text[at] = draw.of(BYTES),
            1 => text.insert(at, draw.of(BYTES)),
            2 => drop(text.drain(at..end)),
            3 => {
                let piece = text[at..end].to_vec();
                let to = draw.below(text.len());
                text.splice(to..to, piece);
            }
            4 => text.truncate(at.max(1)),
            _ => text[at] = (draw.below(256)) as u8,
        }
    }
    text
}
