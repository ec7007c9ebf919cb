//! Changes of a text at random places.

use super::Draw;

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
