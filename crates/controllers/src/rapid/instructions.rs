//! The instructions that move the robot, with the arguments that they have without a name.

/// What an argument is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Argument {
    /// A destination.
    Point,
    /// A destination of external axes alone: the robot's joints in it are not read.
    External,
    /// A point that gets a value.
    Result,
    /// A tool.
    Tool,
    Other,
}

/// The arguments of an instruction in their order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Signature {
    /// P: destination, E: external axes, R: result, T: tool.
    letters: &'static str,
    /// Behind the letters, whatever is between: the last argument is the tool.
    tool_last: bool,
    pub(super) linear: bool,
    /// Options that the language has for it; empty: of a process, which do not move points.
    options: &'static [&'static str],
}

const MOVE: &[&str] = &["CONC", "ID", "V", "T", "Z", "INPOS", "WOBJ", "TLOAD", "CORR", "NOEOFFS", "USEEOFFS"];
const TRIGG: &[&str] = &[
    "CONC",
    "ID",
    "V",
    "T",
    "Z",
    "INPOS",
    "WOBJ",
    "TLOAD",
    "CORR",
    "NOEOFFS",
    "T1",
    "T2",
    "T3",
    "T4",
    "T5",
    "T6",
    "T7",
    "T8",
    "TRIGGDATA1",
    "TRIGGDATA2",
    "TRIGGDATA3",
    "TRIGGARRAY",
    "TIME",
    "MECHUNIT",
];
const SEARCH: &[&str] = &[
    "STOP",
    "PSTOP",
    "SSTOP",
    "SUP",
    "FLANKS",
    "POSFLANK",
    "NEGFLANK",
    "HIGHLEVEL",
    "LOWLEVEL",
    "ID",
    "V",
    "T",
    "WOBJ",
    "TLOAD",
    "CORR",
    "CALCULATETCP",
    "PERSBOOL",
    "CONC",
    "INPOS",
    "USEEOFFS",
];

/// Families of processes: their first argument is the destination (of circular ones the first two), the last one the tool.
const PROCESSES: [&str; 14] = [
    "ARC", "SPOT", "PAINT", "DISP", "CAP", "GLUE", "LASER", "CUT", "CONTACT", "NUT", "STUD", "FCPRESS",
    "SEAL", "WELD",
];

/// The signature of an instruction that moves (in capitals).
pub(super) fn signature(word: &str) -> Option<Signature> {
    let of = |letters, options, linear| Some(Signature { letters, tool_last: false, linear, options });
    match word {
        "MOVEJ" | "MOVEJDO" | "MOVEJAO" | "MOVEJGO" | "MOVEJSYNC" => of("P..T", MOVE_WITH_SIGNAL, false),
        "MOVEL" | "MOVELDO" | "MOVELAO" | "MOVELGO" | "MOVELSYNC" => of("P..T", MOVE_WITH_SIGNAL, true),
        "MOVEC" | "MOVECDO" | "MOVECAO" | "MOVECGO" | "MOVECSYNC" => of("PP..T", MOVE_WITH_SIGNAL, true),
        "MOVEABSJ" => of("P..T", MOVE, false),
        "MOVEEXTJ" => of("E..", MOVE, false),
        "TRIGGJ" => of("P...T", TRIGG, false),
        "TRIGGL" => of("P...T", TRIGG, true),
        "TRIGGC" => of("PP...T", TRIGG, true),
        "TRIGGABSJ" => of("P...T", TRIGG, false),
        "TRIGGJIOS" => of("P..T", TRIGG, false),
        "TRIGGLIOS" => of("P..T", TRIGG, true),
        "SEARCHL" => of(".RP.T", SEARCH, true),
        "SEARCHC" => of(".RPP.T", SEARCH, true),
        "SEARCHEXTJ" => of(".RE.", SEARCH, false),
        "EGMMOVEL" => of(".P..T", &[], true),
        "EGMMOVEC" => of(".PP..T", &[], true),
        _ => process(word),
    }
}

const MOVE_WITH_SIGNAL: &[&str] =
    &["CONC", "ID", "V", "T", "Z", "INPOS", "WOBJ", "TLOAD", "CORR", "VALUE", "DVALUE"];

/// `ArcLStart`, `ArcAdaptC`, `ArcMoveAbsJ`, `SpotMJ`: family, words of it, then the kind of motion.
fn process(word: &str) -> Option<Signature> {
    let family = PROCESSES.iter().find(|family| word.starts_with(**family))?;
    let mut rest = &word[family.len()..];
    for ending in ["START", "END", "ON", "OFF"] {
        rest = rest.strip_suffix(ending).unwrap_or(rest);
    }
    let rest = rest.trim_end_matches(|c: char| c.is_ascii_digit());
    let process = |letters, linear| Some(Signature { letters, tool_last: true, linear, options: &[] });
    let known = |words: &[&str]| words.contains(&rest);
    if known(&["MOVEEXTJ"]) {
        return Some(Signature { letters: "E..", tool_last: false, linear: false, options: &[] });
    }
    if known(&["L", "ML", "ADAPTL", "CALCL", "TRACKL", "MOVEL", "1L", "2L", "REFL"]) {
        return process("P", true);
    }
    if known(&["J", "MJ", "MOVEJ", "MOVEABSJ"]) {
        return process("P", false);
    }
    if known(&["C", "ADAPTC", "CALCC", "TRACKC", "MOVEC"]) {
        return process("PP", true);
    }
    // `ArcCalcLStart` has lost its end above; `ArcAdaptLStart` as well.
    None
}

impl Signature {
    /// Argument `place` of `count`.
    pub(super) fn argument(&self, place: usize, count: usize) -> Argument {
        if self.tool_last && place + 1 == count && place > 0 {
            return Argument::Tool;
        }
        match self.letters.as_bytes().get(place) {
            Some(b'P') => Argument::Point,
            Some(b'E') => Argument::External,
            Some(b'R') => Argument::Result,
            Some(b'T') => Argument::Tool,
            _ => Argument::Other,
        }
    }

    /// Least arguments that it has.
    pub(super) fn least(&self) -> usize {
        self.letters.len()
    }

    /// Whether the language has an option for it.
    pub(super) fn has(&self, option: &str) -> bool {
        self.options.is_empty() || self.options.contains(&option)
    }
}

/// Words that are no instructions and have no arguments.
pub(super) const KEYWORDS: [&str; 55] = [
    "CONST",
    "PERS",
    "VAR",
    "MODULE",
    "ENDMODULE",
    "LOCAL",
    "TASK",
    "PROC",
    "ENDPROC",
    "FUNC",
    "ENDFUNC",
    "TRAP",
    "ENDTRAP",
    "RECORD",
    "ENDRECORD",
    "ALIAS",
    "IF",
    "THEN",
    "ELSEIF",
    "ELSE",
    "ENDIF",
    "FOR",
    "FROM",
    "TO",
    "STEP",
    "DO",
    "ENDFOR",
    "WHILE",
    "ENDWHILE",
    "TEST",
    "CASE",
    "DEFAULT",
    "ENDTEST",
    "RETURN",
    "RAISE",
    "RETRY",
    "TRYNEXT",
    "GOTO",
    "CONNECT",
    "WITH",
    "ERROR",
    "UNDO",
    "ENDUNDO",
    "BACKWARD",
    "ENDBACKWARD",
    "NOT",
    "AND",
    "OR",
    "XOR",
    "DIV",
    "MOD",
    "INOUT",
    "SWITCH",
    "ROBTARGET",
    "JOINTTARGET",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_instruction_has_its_own_arguments() {
        let kinds = |word: &str, count: usize| {
            let signature = signature(word).unwrap_or_else(|| panic!("{word}"));
            (0..count).map(|k| signature.argument(k, count)).collect::<Vec<_>>()
        };
        use Argument::{External, Other, Point, Result, Tool};
        assert_eq!(kinds("MOVELDO", 6), [Point, Other, Other, Tool, Other, Other]);
        assert_eq!(kinds("TRIGGC", 6), [Point, Point, Other, Other, Other, Tool]);
        assert_eq!(kinds("SEARCHL", 5), [Other, Result, Point, Other, Tool]);
        assert_eq!(kinds("MOVEEXTJ", 3), [External, Other, Other]);
        assert_eq!(kinds("ARCLSTART", 6), [Point, Other, Other, Other, Other, Tool]);
        assert_eq!(kinds("ARCC", 7), [Point, Point, Other, Other, Other, Other, Tool]);
        assert_eq!(kinds("SPOTJ", 5), [Point, Other, Other, Other, Tool]);
        for word in [
            "ARCL",
            "ARCLEND",
            "ARCL1",
            "ARCCEND",
            "ARCMOVEABSJ",
            "ARCADAPTLSTART",
            "ARCCALCC",
            "SPOTML",
            "PAINTL",
            "DISPC",
            "CAPL",
        ] {
            assert!(signature(word).is_some(), "{word}");
        }
        for word in ["MOVEWOBJ", "SEARCHX", "ARCKILL", "ARCREFRESH", "CAPREFRESH", "TRIGGIO", "SPOTDATA"] {
            assert!(signature(word).is_none(), "{word}");
        }
    }
}
