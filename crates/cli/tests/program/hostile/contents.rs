//! Each kind of file, spoiled in the same ways.

use super::{files, good, none, program, unsound};

/// A kind of file: its name, and what is run on a spoiled one, which is called `bad` with the same ending. Several commands take turns.
const KINDS: &[(&str, &[&str])] = &[
    (
        "robot.toml",
        &["check --robot bad.toml", "identify --robot bad.toml --data data.csv --folds 0 --out out.json"],
    ),
    (
        "arm.urdf",
        &["check --robot bad.urdf", "export --fit fit.json --format urdf --urdf bad.urdf --out out.urdf"],
    ),
    (
        "data.csv",
        &[
            "identify --robot robot.toml --data bad.csv --folds 0 --out out.json",
            "check --robot robot.toml --data bad.csv",
            "predict --fit fit.json --data bad.csv --out out.csv",
            "identify --robot robot.toml --data bad.csv --stream --folds 0 --out out.json",
            "plan --fit fit.json --at bad.csv --count 2 --pool 8 --out out.csv",
            "compare --robot robot.toml --data bad.csv --solver qr --folds 2",
            "discover --robot robot.toml --data bad.csv --most 0 --flips 99 --out out.json",
        ],
    ),
    (
        "model.toml",
        &[
            "identify --robot robot.toml --data data.csv --folds 0 --model bad.toml --out out.json",
            "check --robot robot.toml --model bad.toml",
        ],
    ),
    (
        "fit.json",
        &[
            "predict --fit bad.json --data data.csv --out out.csv",
            "compensate --fit bad.json --poses poses.csv --out out.csv",
            "plan --fit bad.json --count 2 --pool 8 --out out.csv",
            "plan --fit fit.json --rival bad.json --count 2 --pool 8 --out out.csv",
            "map --fit bad.json --points 2 --out out.csv",
            "export --fit bad.json --format urdf --out out.urdf",
            "export --fit bad.json --format dh --out out.csv",
            "export --fit bad.json --format iso230 --entries 2 --out out.csv",
            "export --fit bad.json --format ros --out out.yaml",
        ],
    ),
    ("poses.csv", &["compensate --fit fit.json --poses bad.csv --out out.csv"]),
    ("plant.toml", &["simulate --plant bad.toml --out out.csv"]),
    ("page/run.json", &["verify page/bad.json"]),
    // The verbs and files of upkeep, acceptance, sessions, landmarks and programs.
    (
        "two.json",
        &[
            "monitor --fit bad.json --session B --data data.csv",
            "transfer --fit bad.json --data data.csv --out out.json",
            "fleet bad.json fit.json fit.json fit.json --out out.json",
            "plan --fit bad.json --session A --for monitor --out out.csv",
            "iso9283 --fit bad.json --session A --data repeats.csv",
            "predict --fit bad.json --data two.csv --out out.csv",
        ],
    ),
    (
        "two.csv",
        &[
            "identify --robot sessions.toml --data bad.csv --folds 0 --out out.json",
            "monitor --fit fit.json --data bad.csv --base",
            "transfer --fit fit.json --data bad.csv --tool --update --out out.json",
            "predict --fit two.json --data bad.csv --out out.csv",
        ],
    ),
    ("sessions.toml", &["identify --robot bad.toml --data two.csv --folds 0 --out out.json"]),
    ("history.json", &["monitor --fit fit.json --data data.csv --history bad.json"]),
    (
        "prior.json",
        &["identify --robot robot.toml --data data.csv --prior bad.json --folds 0 --out out.json"],
    ),
    (
        "repeats.csv",
        &[
            "iso9283 --robot robot.toml --data bad.csv",
            "iso9283 --fit fit.json --data bad.csv --align best-fit",
            "iso9283 --robot robot.toml --data bad.csv --path",
        ],
    ),
    (
        "touched.csv",
        &[
            "identify --robot touched.toml --data bad.csv --folds 0 --out out.json",
            "check --robot touched.toml --data bad.csv",
        ],
    ),
    ("touched.toml", &["identify --robot bad.toml --data touched.csv --folds 0 --out out.json"]),
    (
        "head.toml",
        &[
            "identify --robot robot.toml --data data.csv --folds 0 --certificate bad.toml --report sheet",
            "iso9283 --robot robot.toml --data repeats.csv --certificate bad.toml --report sheet",
        ],
    ),
    (
        "frames.toml",
        &["compensate --fit fit.json --poses poses.csv --frames bad.toml --frame j1fixture --out out.csv"],
    ),
    ("job.src", &["compensate --fit heavy.json --program job.dat --with bad.src --mark --out out.dat"]),
    ("job.dat", &["compensate --fit heavy.json --program bad.dat --with job.src --mark --out out.dat"]),
    ("job.mod", &["compensate --fit heavy.json --program bad.mod --mark --out out.mod"]),
    ("job.ls", &["compensate --fit heavy.json --program bad.ls --mark --out out.ls"]),
    ("job.script", &["compensate --fit heavy.json --program bad.script --mark --out out.script"]),
];

const OUTPUTS: &[&str] = &[
    "out.json",
    "out.csv",
    "out.urdf",
    "out.yaml",
    "out.dat",
    "out.dat.corrections.csv",
    "out.mod",
    "out.mod.corrections.csv",
    "out.ls",
    "out.ls.corrections.csv",
    "out.script",
    "out.script.corrections.csv",
    "sheet",
];

/// A way to spoil a file.
type Spoil = (&'static str, fn(&str) -> Vec<u8>);

fn number(text: &str, by: &str) -> Vec<u8> {
    // The first number behind the first line, where a value is.
    let from = text.find('\n').map_or(0, |at| at + 1);
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
    let Some(at) = text[from..].find(|c: char| c.is_ascii_digit()).map(|at| from + at) else {
        return by.into();
    };
    let end = text[at..].find(|c| !digits(c)).map_or(text.len(), |length| at + length);
    [&text[..at], by, &text[end..]].concat().into()
}

/// A name that every kind of file has.
fn name(text: &str, by: &str) -> Vec<u8> {
    text.replace("j1", by).replace("\"small\"", &format!("\"{by}\"")).into()
}

fn cut(text: &str, part: usize) -> Vec<u8> {
    text.as_bytes()[..text.len() * part / 8].to_vec()
}

fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
}

fn lines(text: &str, change: impl FnOnce(&mut Vec<&str>)) -> Vec<u8> {
    let mut lines: Vec<&str> = text.lines().collect();
    change(&mut lines);
    (lines.join("\n") + "\n").into()
}

/// Some bytes are others: from a generator of this text and number.
fn noise(text: &str, seed: u64) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    for _ in 0..(1 + seed % 9) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let at = (state >> 8) as usize % bytes.len();
        match state % 3 {
            0 => bytes[at] = (state >> 40) as u8,
            1 => drop(bytes.remove(at)),
            _ => bytes.insert(at, b"\"',;[]{}<>=-\n\0"[(state >> 40) as usize % 14]),
        }
    }
    bytes
}

const SPOILS: &[Spoil] = &[
    ("nothing", |_| Vec::new()),
    ("a line end", |_| b"\n".to_vec()),
    ("blanks", |_| b" \t \n  \n".to_vec()),
    ("a byte order mark alone", |_| b"\xef\xbb\xbf".to_vec()),
    ("a byte order mark", |t| [b"\xef\xbb\xbf", t.as_bytes()].concat()),
    ("UTF-16, little end first", |t| utf16(t, u16::to_le_bytes)),
    ("UTF-16, big end first", |t| utf16(t, u16::to_be_bytes)),
    ("Latin-1", |t| [t.as_bytes(), b"\n# \xe4\xf6\xfc\n"].concat()),
    ("a zero byte", |t| t.replacen('1', "\0", 1).into()),
    ("a zero byte at the end", |t| [t.as_bytes(), b"\0"].concat()),
    ("an eighth", |t| cut(t, 1)),
    ("a quarter", |t| cut(t, 2)),
    ("three eighths", |t| cut(t, 3)),
    ("a half", |t| cut(t, 4)),
    ("five eighths", |t| cut(t, 5)),
    ("three quarters", |t| cut(t, 6)),
    ("seven eighths", |t| cut(t, 7)),
    ("all but the last bytes", |t| t.as_bytes()[..t.len() - 3].to_vec()),
    ("twice", |t| t.repeat(2).into()),
    ("line ends of Windows", |t| t.replace('\n', "\r\n").into()),
    ("line ends of old Macs", |t| t.replace('\n', "\r").into()),
    ("gzip", |t| [b"\x1f\x8b\x08\0", t.as_bytes()].concat()),
    ("zip", |t| [b"PK\x03\x04", t.as_bytes()].concat()),
    ("Parquet", |t| [b"PAR1", t.as_bytes()].concat()),
    ("a web page", |_| b"<!DOCTYPE html><html><body>404</body></html>".to_vec()),
    ("an empty array", |_| b"[]".to_vec()),
    ("an empty object", |_| b"{}".to_vec()),
    ("null", |_| b"null".to_vec()),
    ("a number", |_| b"17".to_vec()),
    ("a word", |_| b"hello".to_vec()),
    ("brackets", |_| "[".repeat(60_000).into()),
    ("braces", |_| "{\"a\":".repeat(60_000).into()),
    ("tables", |_| ("a = ".to_owned() + &"{a=".repeat(60_000)).into()),
    ("elements", |_| "<robot>".repeat(60_000).into()),
    ("an entity bomb", |_| {
        b"<!DOCTYPE r [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]><robot name=\"&b;\"/>".to_vec()
    }),
    ("an endless line", |t| [t.trim_end().as_bytes(), &b"9".repeat(2 << 20)].concat()),
    ("a long cell", |t| number(t, &"9".repeat(100_000))),
    ("NaN", |t| number(t, "NaN")),
    ("nan", |t| number(t, "nan")),
    ("infinity", |t| number(t, "inf")),
    ("minus infinity", |t| number(t, "-Infinity")),
    ("a huge number", |t| number(t, "1e308")),
    ("a number beyond all", |t| number(t, "1e999")),
    ("a tiny number", |t| number(t, "1e-320")),
    ("minus zero", |t| number(t, "-0.0")),
    ("a count beyond all", |t| number(t, "99999999999999999999")),
    ("a negative count", |t| number(t, "-9223372036854775808")),
    ("a hexadecimal number", |t| number(t, "0x7f")),
    ("a decimal comma", |t| number(t, "1,5")),
    ("digits of another script", |t| number(t, "\u{661}\u{662}")),
    ("a text for a number", |t| number(t, "\"one\"")),
    ("nothing for a number", |t| number(t, "")),
    ("no quotes", |t| t.replace('"', "").into()),
    ("another quote", |t| t.replacen('"', "\u{201c}", 1).into()),
    ("an open quote", |t| [t.as_bytes(), b"\""].concat()),
    ("a name with an escape", |t| name(t, "\u{1b}[31mj")),
    ("a name with a bell, escaped", |t| name(t, "j\\u0007")),
    ("a name with a line end, escaped", |t| name(t, "a\\nb")),
    ("a name that turns around", |t| name(t, "\u{202e}1j")),
    ("a name with no width", |t| name(t, "j\u{200b}1")),
    ("a name that is no character", |t| name(t, "j\u{ffff}")),
    ("a name with a line separator", |t| name(t, "j\u{2028}1")),
    ("a name that is a formula", |t| name(t, "=1+1")),
    ("a name that is a path", |t| name(t, "../../etc/passwd")),
    ("a name that is a tag", |t| name(t, "<script>")),
    ("a name that is a picture", |t| name(t, "\u{1f9be}")),
    ("no name", |t| name(t, "")),
    ("a blank name", |t| name(t, " ")),
    ("a long name", |t| name(t, &"j".repeat(5000))),
    ("a name of a column", |t| name(t, "payload")),
    ("a name of a frame", |t| name(t, "tool")),
    ("a name of another", |t| name(t, "j2")),
    ("no first line", |t| lines(t, |all| _ = all.remove(0))),
    ("no last line", |t| lines(t, |all| _ = all.pop())),
    ("backwards", |t| lines(t, |all| all.reverse())),
    ("the last line many times", |t| lines(t, |all| all.extend(vec![all[all.len() - 1]; 2000]))),
    ("the first line many times", |t| lines(t, |all| (0..50).for_each(|_| all.insert(0, all[0])))),
    ("noise 1", |t| noise(t, 1)),
    ("noise 2", |t| noise(t, 2)),
    ("noise 3", |t| noise(t, 3)),
    ("noise 4", |t| noise(t, 4)),
    ("noise 5", |t| noise(t, 5)),
    ("noise 6", |t| noise(t, 6)),
    ("noise 7", |t| noise(t, 7)),
    ("noise 8", |t| noise(t, 8)),
];

#[test]
fn every_kind_of_file_spoiled_in_every_way_is_read_or_refused() {
    let run_kind = |(file, commands): &(&str, &[&str])| {
        let folder = good();
        let text = folder.read(file);
        let bad = match file.rsplit_once('/') {
            Some((above, _)) => format!("{above}/bad.json"),
            None => format!("bad.{}", file.rsplit_once('.').unwrap().1),
        };
        let mut found = Vec::new();
        for (k, (what, spoil)) in SPOILS.iter().enumerate() {
            std::fs::write(folder.file(&bad), spoil(&text)).unwrap();
            let words: Vec<&str> = commands[k % commands.len()].split(' ').collect();
            let before = files(&folder);
            let output = program(&folder, &words).output().unwrap();
            let problem = unsound(&output, OUTPUTS, &before, &folder);
            found.extend(problem.map(|problem| format!("{} with {what}: {problem}", words.join(" "))));
            for name in OUTPUTS {
                let _ = std::fs::remove_file(folder.file(name));
            }
            let _ = std::fs::remove_dir_all(folder.file("sheet"));
        }
        found
    };
    // Each kind has a folder of its own.
    let found = std::thread::scope(|scope| {
        let threads: Vec<_> = KINDS.iter().map(|kind| scope.spawn(|| run_kind(kind))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    none(found, KINDS.len() * SPOILS.len(), 1800);
}
