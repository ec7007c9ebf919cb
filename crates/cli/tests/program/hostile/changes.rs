//! What is done to a good folder, or to the text of a file in it: the words of a step in the table.

use super::sheet;
use crate::folder::Folder;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// A file and what is done to it, or `run` and a command line that has to succeed.
pub type Step = Vec<String>;

/// The files of the corpus.
pub fn corpus() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/spoiled")
}

/// Does a step; `Err` is a mistake in the table.
pub fn apply(folder: &Folder, step: &Step) -> Result<(), String> {
    let words: Vec<&str> = step.iter().map(String::as_str).collect();
    let failed = |error: std::io::Error| format!("{step:?}: {error}");
    let from = |name: &str| match name.strip_prefix("examples/") {
        Some(name) => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name),
        None => folder.file(name),
    };
    match words[..] {
        ["run", line] => {
            let run = folder.run(&line.split(' ').collect::<Vec<_>>());
            if run.code != Some(0) {
                return Err(format!("{line}: {}", run.log));
            }
        }
        [name, "folder"] => std::fs::create_dir(folder.file(name)).map_err(failed)?,
        [name, "closed"] => {
            std::fs::create_dir(folder.file(name)).map_err(failed)?;
            Command::new("chmod").arg("555").arg(folder.file(name)).status().map_err(failed)?;
            if std::fs::write(folder.file(name).join("probe"), "").is_ok() {
                std::fs::remove_file(folder.file(name).join("probe")).map_err(failed)?;
                return Err("SKIPPED: this user may write everywhere".into());
            }
        }
        [name, "link", to] => std::os::unix::fs::symlink(to, folder.file(name)).map_err(failed)?,
        [name, "remove"] => std::fs::remove_file(folder.file(name)).map_err(failed)?,
        [name, "corpus"] => _ = std::fs::copy(corpus().join(name), folder.file(name)).map_err(failed)?,
        [name, "copy", of] => _ = std::fs::copy(from(of), folder.file(name)).map_err(failed)?,
        [name, "pipe"] => _ = Command::new("mkfifo").arg(folder.file(name)).status().map_err(failed)?,
        [name, "pipe", of] => {
            Command::new("mkfifo").arg(folder.file(name)).status().map_err(failed)?;
            let (data, to) = (std::fs::read(folder.file(of)).map_err(failed)?, folder.file(name));
            std::thread::spawn(move || std::fs::OpenOptions::new().write(true).open(to)?.write_all(&data));
        }
        [name, ref how @ ..] => {
            // `file:NAME` is the text of that file.
            let read = |word: &&str| word.strip_prefix("file:").map(|name| folder.read(name));
            let texts: Vec<Option<String>> = how.iter().map(read).collect();
            let how: Vec<&str> = how.iter().zip(&texts).map(|(w, t)| t.as_deref().unwrap_or(w)).collect();
            let old = std::fs::read(folder.file(name)).unwrap_or_default();
            let new = changed(&old, &how).ok_or(format!("{step:?} cannot be done"))?;
            std::fs::write(folder.file(name), new).map_err(failed)?;
        }
        [] => return Err("a step of no words".into()),
    }
    Ok(())
}

/// The bytes of a file after a change; none where the change is unknown, or changes nothing.
pub fn changed(old: &[u8], how: &[&str]) -> Option<Vec<u8>> {
    let text = &*String::from_utf8_lossy(old);
    let count = |word: &str| word.parse::<usize>().ok();
    let lines = |change: &dyn Fn(&mut Vec<&str>)| {
        let mut lines: Vec<&str> = text.lines().collect();
        change(&mut lines);
        (lines.join("\n") + "\n").into_bytes()
    };
    Some(match *how {
        ["write", new] => new.into(),
        ["before", new] => [&raw(new), old].concat(),
        ["after", new] => [old, &raw(new)].concat(),
        // Many times, with a number in the place of `{k}`.
        ["count", times, new] => {
            let all = (0..count(times)?).map(|k| new.replace("{k}", &k.to_string()));
            [old, all.collect::<String>().as_bytes()].concat()
        }
        ["twice"] => old.repeat(2),
        ["nothing but", times, new] => new.repeat(count(times)?).into(),
        ["nothing but", times, new, first] => (first.to_owned() + &new.repeat(count(times)?)).into(),
        ["padded", times, new] => (text.trim_end().to_owned() + &new.repeat(count(times)?)).into(),
        ["trim"] => text.trim_end().into(),
        ["replace", from, to] if text.matches(from).count() == 1 => text.replace(from, to).into(),
        ["first", from, to] if text.contains(from) => text.replacen(from, to, 1).into(),
        ["every", from, to] if text.contains(from) => text.replace(from, to).into(),
        // Where it is there at all: one change for many kinds of files.
        ["any", from, to] => text.replace(from, to).into(),
        ["any first", from, to] => text.replacen(from, to, 1).into(),
        ["exchange", a, b] if text.contains(a) => text.replace(a, "\0").replace(b, a).replace('\0', b).into(),
        ["until", mark] => text[..text.find(mark)?].into(),
        ["through", mark] => text[..text.find(mark)? + mark.len()].into(),
        ["json", pointer, value] => {
            let mut all: serde_json::Value = serde_json::from_str(text).ok()?;
            *all.pointer_mut(pointer)? = serde_json::from_str(value).ok()?;
            all.to_string().into()
        }
        ["eighths", part] => old[..old.len() * count(part)? / 8].into(),
        ["shorter", bytes] => old[..old.len() - count(bytes)?].into(),
        ["UTF-16", end] => {
            let bytes = |unit: u16| if end == "le" { unit.to_le_bytes() } else { unit.to_be_bytes() };
            std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
        }
        ["number", by] => number(text, by),
        ["number", digit, times] => number(text, &digit.repeat(count(times)?)),
        ["name", by] => name(text, by),
        ["name", letter, times] => name(text, &letter.repeat(count(times)?)),
        ["lines", "without the first"] => lines(&|all| _ = all.remove(0)),
        ["lines", "without the last"] => lines(&|all| _ = all.pop()),
        ["lines", "backwards"] => lines(&|all| all.reverse()),
        ["last line", times] => {
            let times = count(times)?;
            lines(&|all| all.extend(vec![all[all.len() - 1]; times]))
        }
        ["first line", times] => {
            let times = count(times)?;
            lines(&|all| (0..times).for_each(|_| all.insert(0, all[0])))
        }
        ["noise", seed] => noise(old, seed.parse().ok()?),
        _ => sheet::changed(text, how)?.into(),
    })
}

/// Bytes that are no text are written `hex:1f8b`.
fn raw(text: &str) -> Vec<u8> {
    match text.strip_prefix("hex:") {
        Some(hex) => {
            (0..hex.len() / 2).filter_map(|k| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).ok()).collect()
        }
        None => text.into(),
    }
}

/// With another first number behind the first line, where a value is.
fn number(text: &str, by: &str) -> Vec<u8> {
    let from = text.find('\n').map_or(0, |at| at + 1);
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
    let Some(at) = text[from..].find(|c: char| c.is_ascii_digit()).map(|at| from + at) else {
        return by.into();
    };
    let end = text[at..].find(|c| !digits(c)).map_or(text.len(), |length| at + length);
    [&text[..at], by, &text[end..]].concat().into()
}

/// With another name in the place of one that every kind of file has.
fn name(text: &str, by: &str) -> Vec<u8> {
    text.replace("j1", by).replace("\"small\"", &format!("\"{by}\"")).into()
}

/// Some bytes are others: from a generator of this text and number.
fn noise(old: &[u8], seed: u64) -> Vec<u8> {
    let mut bytes = old.to_vec();
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
