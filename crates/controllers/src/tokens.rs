//! Words, numbers and signs of a language whose comments end with the line.

use crate::ControllerError;
use crate::error::syntax;
use crate::number::number_at;
use std::ops::Range;

/// What a language calls a comment and a text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lexis {
    /// The byte at which a comment begins.
    pub(crate) comment: u8,
    /// Bytes around a text.
    pub(crate) quotes: &'static [u8],
    /// A line that begins with this byte is none of the program's.
    pub(crate) header: Option<u8>,
    /// Whether a backslash in front of a quote leaves open what is meant.
    pub(crate) escapes: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Word,
    /// Without its sign.
    Number(f64),
    Text,
    Sign(u8),
    End,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) range: Range<usize>,
    /// From 1.
    pub(crate) line: usize,
}

impl Token {
    pub(crate) fn is(&self, sign: u8) -> bool {
        self.kind == Kind::Sign(sign)
    }
}

/// All tokens; each line ends with one.
///
/// # Errors
/// When a text is not closed in its line.
pub(crate) fn tokens(text: &[u8], lexis: Lexis) -> Result<Vec<Token>, ControllerError> {
    let mark = if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    tokens_from(text, mark, 1, lexis)
}

/// All tokens from an offset on, which is in this line.
pub(crate) fn tokens_from(
    text: &[u8],
    from: usize,
    line: usize,
    lexis: Lexis,
) -> Result<Vec<Token>, ControllerError> {
    let mut found = Vec::new();
    let (mut at, mut line, mut first) = (from, line, true);
    while at < text.len() {
        let byte = text[at];
        let start = at;
        if byte == b'\n' || byte == b'\r' {
            at += 1;
            if byte == b'\r' && text.get(at) == Some(&b'\n') {
                at += 1;
            }
            found.push(Token { kind: Kind::End, range: start..at, line });
            line += 1;
            first = true;
            continue;
        }
        if byte == lexis.comment || (first && lexis.header == Some(byte)) {
            at = end_of_line(text, at);
            continue;
        }
        if byte.is_ascii_whitespace() {
            at += 1;
            continue;
        }
        first = false;
        let kind = if lexis.quotes.contains(&byte) {
            at = closed(text, at, lexis)?;
            Kind::Text
        } else if is_word(byte) && !byte.is_ascii_digit() {
            at += text[at..].iter().take_while(|&&b| is_word(b)).count();
            Kind::Word
        } else if let Some((value, length)) =
            number_at(&text[at..]).filter(|_| byte.is_ascii_digit() || byte == b'.')
        {
            at += length;
            Kind::Number(value)
        } else if byte.is_ascii_digit() {
            // `1a`, `1.2.3`: no number, and no word either.
            at += text[at..].iter().take_while(|&&b| is_word(b) || b == b'.').count();
            Kind::Sign(0)
        } else {
            at += 1;
            Kind::Sign(byte)
        };
        found.push(Token { kind, range: start..at, line });
    }
    found.push(Token { kind: Kind::End, range: text.len()..text.len(), line });
    Ok(found)
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'$'
}

fn end_of_line(text: &[u8], at: usize) -> usize {
    at + text[at..].iter().take_while(|&&byte| byte != b'\n' && byte != b'\r').count()
}

/// Behind the closing quote.
fn closed(text: &[u8], at: usize, lexis: Lexis) -> Result<usize, ControllerError> {
    let inside = &text[at + 1..];
    // No farther than the quote: a line of many texts is looked through once.
    let ends = |&byte: &u8| byte == text[at] || byte == b'\n' || byte == b'\r';
    let Some(length) = inside.iter().position(ends).filter(|&length| inside[length] == text[at]) else {
        return Err(syntax(text, at, "a text is not closed in its line"));
    };
    if lexis.escapes && length > 0 && inside[length - 1] == b'\\' {
        return Err(syntax(
            text,
            at + length,
            "a backslash in front of a quote leaves open where the text ends",
        ));
    }
    Ok(at + length + 2)
}

/// A position in a list of tokens.
#[derive(Debug, Clone)]
pub(crate) struct Cursor<'t> {
    pub(crate) text: &'t [u8],
    pub(crate) tokens: &'t [Token],
    pub(crate) at: usize,
}

impl<'t> Cursor<'t> {
    pub(crate) fn new(text: &'t [u8], tokens: &'t [Token]) -> Self {
        Cursor { text, tokens, at: 0 }
    }

    pub(crate) fn peek(&self) -> Option<&'t Token> {
        self.tokens.get(self.at)
    }

    pub(crate) fn next(&mut self) -> Option<&'t Token> {
        let token = self.tokens.get(self.at);
        self.at += 1;
        token
    }

    pub(crate) fn done(&self) -> bool {
        self.at >= self.tokens.len()
    }

    /// Takes a sign, if it is the next one.
    pub(crate) fn take(&mut self, sign: u8) -> bool {
        let is = self.peek().is_some_and(|token| token.is(sign));
        self.at += usize::from(is);
        is
    }

    /// Takes a word, if one is next: as it stands.
    pub(crate) fn word(&mut self) -> Option<&'t str> {
        let token = self.peek().filter(|token| token.kind == Kind::Word)?;
        self.at += 1;
        Some(self.str_of(token))
    }

    /// The word that is next, without taking it.
    pub(crate) fn peek_word(&self) -> Option<&'t str> {
        self.peek().filter(|token| token.kind == Kind::Word).map(|token| self.str_of(token))
    }

    /// Takes a number with its sign, if one is next: its value and bytes.
    pub(crate) fn number(&mut self) -> Option<(f64, Range<usize>)> {
        let mut ahead = self.clone();
        let first = ahead.peek()?.range.start;
        let minus = ahead.take(b'-');
        let signed = minus || ahead.take(b'+');
        let token = ahead.next()?;
        let Kind::Number(value) = token.kind else { return None };
        // What stands between a sign and its number would be lost.
        if signed && token.range.start != first + 1 {
            return None;
        }
        self.at = ahead.at;
        Some((if minus { -value } else { value }, first..token.range.end))
    }

    /// The text of a token; texts and comments in any encoding are never asked for.
    pub(crate) fn str_of(&self, token: &Token) -> &'t str {
        std::str::from_utf8(&self.text[token.range.clone()]).unwrap_or("")
    }

    /// Skips to behind the bracket that closes the one just taken, or to the end.
    pub(crate) fn skip_closed(&mut self) {
        let mut depth = 1;
        while let Some(token) = self.next() {
            match token.kind {
                Kind::Sign(b'(' | b'[' | b'{') => depth += 1,
                Kind::Sign(b')' | b']' | b'}') => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return;
            }
        }
    }
}
