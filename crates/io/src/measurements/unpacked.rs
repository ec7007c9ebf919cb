//! What a workbook unpacks to, before anything of it is kept: bytes, elements and references to cells are counted while the archive is
//! unpacked into nothing. What a file declares of itself is compared with what there is, and never allocated.

use super::dialect::LARGEST;
use std::io::{BufRead, BufReader, Cursor, Read};
use zip::ZipArchive;

/// Longest piece of an XML part between two ends of tags: a cell has 32767 characters at most.
const LONGEST: u64 = 1 << 20;

/// Memory of a shared text beside its characters.
const OF_A_TEXT: u64 = 48;

/// Elements of every other part, at most (styles, relations, names).
const OTHER_ELEMENTS: u64 = 1 << 20;

/// Refuses an archive that takes more memory than a table may.
///
/// # Errors
/// What is too large. What is no archive, or is damaged, is left to the reader.
pub(super) fn bounded(bytes: &[u8]) -> Result<(), String> {
    let Ok(mut archive) = ZipArchive::new(Cursor::new(bytes)) else { return Ok(()) };
    let mut left = LARGEST;
    for k in 0..archive.len() {
        let Ok(part) = archive.by_index(k) else { continue };
        if part.size() > left {
            return Err(too_large());
        }
        let name = part.name().map_or_else(|_| String::new(), |name| name.to_lowercase());
        let xml = name.ends_with(".xml") || name.ends_with(".rels");
        left = match xml {
            true => elements(BufReader::new(part), &name, left)?,
            false => sized(part, left)?,
        };
    }
    Ok(())
}

/// Goes through a part that is no XML.
fn sized(part: impl Read, left: u64) -> Result<u64, String> {
    let unpacked = std::io::copy(&mut part.take(left + 1), &mut std::io::sink()).unwrap_or(0);
    left.checked_sub(unpacked).ok_or_else(too_large)
}

/// Goes through an XML part, tag by tag; what is left of the memory.
fn elements(mut part: impl BufRead, name: &str, mut left: u64) -> Result<u64, String> {
    let sheet = name.contains("worksheets/");
    let strings = name.ends_with("sharedstrings.xml");
    let mut piece = Vec::new();
    let (mut other, mut unpacked, mut texts, mut declared) = (0, 0, 0, None);
    loop {
        piece.clear();
        let read = match part.by_ref().take(LONGEST).read_until(b'>', &mut piece) {
            // What is damaged is left to the reader, which gets no further.
            Ok(0) | Err(_) => break,
            Ok(read) => read as u64,
        };
        if read == LONGEST && piece.last() != Some(&b'>') {
            return Err(format!("has a text of more than {} MiB in `{name}`", LONGEST >> 20));
        }
        let tag = piece.iter().rposition(|&byte| byte == b'<').map_or(&[][..], |at| &piece[at..]);
        let element = !tag.starts_with(b"</") && !tag.is_empty();
        unpacked += read;
        left = left.checked_sub(read).ok_or_else(too_large)?;
        if element && !sheet && !strings {
            other += 1;
            if other > OTHER_ELEMENTS {
                return Err(format!("has more than {OTHER_ELEMENTS} elements in `{name}`"));
            }
        }
        let placed = sheet && matches!(local_name(tag), b"c" | b"row" | b"dimension");
        if placed
            && let Some(wrong) = [&b"r"[..], b"ref"].iter().find_map(|name| misplaced(attribute(tag, name)?))
        {
            return Err(format!("has a cell `{wrong}`; a sheet ends at XFD1048576"));
        }
        if strings {
            texts += u64::from(element && local_name(tag) == b"si");
            if unpacked + OF_A_TEXT * texts > LARGEST {
                return Err(too_large());
            }
            declared = declared.or_else(|| attribute(tag, b"uniqueCount").map(<[u8]>::to_vec));
        }
    }
    if let Some(count) = declared {
        let text = String::from_utf8_lossy(&count).into_owned();
        // `<si/>` is the shortest.
        if text.parse::<u64>().is_ok_and(|count| count > unpacked / 5) {
            return Err(format!("declares {text} shared texts, and has {unpacked} bytes of them"));
        }
    }
    Ok(left)
}

/// The name of a tag without its prefix.
fn local_name(tag: &[u8]) -> &[u8] {
    let name = tag.strip_prefix(b"<").unwrap_or(tag);
    let name = name.split(|byte| byte.is_ascii_whitespace() || matches!(byte, b'/' | b'>')).next();
    name.and_then(|name| name.rsplit(|&byte| byte == b':').next()).unwrap_or(b"")
}

/// The value of an attribute in a tag.
fn attribute<'a>(tag: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    let mut from = 0;
    loop {
        let at = from + memchr::memmem::find(&tag[from..], name)?;
        from = at + name.len();
        let before = at.checked_sub(1).map(|k| tag[k]);
        let rest = tag[from..].trim_ascii_start();
        if let (Some(b' ' | b'\t' | b'\n' | b'\r'), Some(rest)) = (before, rest.strip_prefix(b"=")) {
            let rest = rest.trim_ascii_start();
            let quote = *rest.first().filter(|quote| matches!(quote, b'"' | b'\''))?;
            return rest[1..].split(|&byte| byte == quote).next();
        }
    }
}

/// A reference that is beyond any sheet, or back to front; of what is no reference the reader has a message.
fn misplaced(reference: &[u8]) -> Option<String> {
    let places: Vec<Option<(u64, u64)>> = reference.split(|&byte| byte == b':').map(place).collect();
    let beyond =
        |place: &Option<(u64, u64)>| place.is_none_or(|(row, column)| row > 1 << 20 || column > 1 << 14);
    let back = matches!(places[..], [Some(from), Some(to)] if to.0 < from.0 || to.1 < from.1);
    (places.iter().any(beyond) || back).then(|| String::from_utf8_lossy(reference).chars().take(40).collect())
}

/// Row and column from one on, zero for what is left out (`r="7"` of a row).
fn place(reference: &[u8]) -> Option<(u64, u64)> {
    let letters = reference.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let (column, row) = reference.split_at(letters);
    if column.len() > 3 || row.len() > 7 || !row.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let column =
        column.iter().fold(0, |sum, byte| 26 * sum + u64::from(byte.to_ascii_uppercase() - b'A') + 1);
    Some((row.iter().fold(0, |sum, byte| 10 * sum + u64::from(byte - b'0')), column))
}

fn too_large() -> String {
    format!("unpacks to more than {} MiB; save the rows of the measurements alone, as CSV", LARGEST >> 20)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_end_where_sheets_do() {
        for good in ["A1", "XFD1048576", "a7", "7", "A1:XFD1048576", "B2:B2"] {
            assert_eq!(misplaced(good.as_bytes()), None, "{good}");
        }
        for bad in ["XFE1", "A1048577", "AAAA1", "A99999999999", "C3:B4", "C3:D2", "A-1"] {
            assert_eq!(misplaced(bad.as_bytes()).as_deref(), Some(bad));
        }
    }

    #[test]
    fn attributes_are_found_by_their_whole_name() {
        let tag = b"<c xr=\"no\" t='s' r = \"B7\" ref='x'>";
        assert_eq!(attribute(tag, b"r"), Some(&b"B7"[..]));
        assert_eq!(attribute(tag, b"ref"), Some(&b"x"[..]));
        assert_eq!(attribute(tag, b"uniqueCount"), None);
    }

    #[test]
    fn counts_and_elements_are_compared_with_what_there_is() {
        let of = |text: &str| elements(text.as_bytes(), "xl/sharedstrings.xml", LARGEST);
        let small = "<sst uniqueCount=\"2\"><si><t>a</t></si><si/></sst>";
        assert_eq!(of(small).unwrap(), LARGEST - small.len() as u64);
        let many = "<si/>".repeat((LARGEST / OF_A_TEXT) as usize);
        assert_eq!(of(&many).unwrap_err(), too_large());
        let absurd = of("<sst uniqueCount=\"18446744073709551615\"><si/></sst>").unwrap_err();
        assert_eq!(absurd, "declares 18446744073709551615 shared texts, and has 51 bytes of them");
        let long = format!("<sst><si><t>{}</t></si></sst>", "x".repeat(2 << 20));
        assert!(of(&long).unwrap_err().contains("a text of more than 1 MiB"));
        let few = elements("<a/>".repeat(100).as_bytes(), "xl/worksheets/s.xml", 300).unwrap_err();
        assert_eq!(few, too_large());
        assert_eq!(local_name(b"<x:row r=\"1\">"), b"row");
        let many = "<xf/>".repeat(OTHER_ELEMENTS as usize + 1);
        assert!(elements(many.as_bytes(), "xl/styles.xml", LARGEST).unwrap_err().contains("elements"));
    }
}
