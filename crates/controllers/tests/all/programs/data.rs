//! Programs in URScript and INFORM, and data of VAL3.

use super::{WORDS, Writer, comment};

pub(super) fn script(writer: &mut Writer<'_>, points: usize) {
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

pub(super) fn inform(writer: &mut Writer<'_>, points: usize) {
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

pub(super) fn val3(writer: &mut Writer<'_>, points: usize) {
    writer.line("<?xml version=\"1.0\" encoding=\"utf-8\" ?>");
    writer.line("<Database xmlns=\"http://www.staubli.com/robotics/VAL3/Data/2\">");
    writer.line("  <Datas>");
    for k in 0..points {
        let joints = writer.draw.chance(30);
        let kind = if joints { "jointRx" } else { "pointRx" };
        writer.line(format!(
            "    <Data name=\"p{k}\" access=\"private\" xsi:type=\"array\" type=\"{kind}\" size=\"1\">"
        ));
        let names =
            if joints { ["j1", "j2", "j3", "j4", "j5", "j6"] } else { ["x", "y", "z", "rx", "ry", "rz"] };
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
