//! Motions.

use super::aggregate::Aggregate;
use super::candidate::{Candidate, candidate};
use super::file::{Motion, Reader, name};
use crate::ControllerError;
use crate::flow::{FRAME, Head, LOAD, Step, TOOL};
use crate::tokens::{Cursor, Kind};

/// Words that may stand behind a destination, besides `C_DIS` and the like.
const BEHIND: [&str; 2] = ["CA", "INITMOV"];

impl<'t> Reader<'t> {
    /// `LIN XP1 C_DIS`, `CIRC {…}, {…}`, `SPTP XP1 WITH $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO)`.
    pub(super) fn motion(&mut self, at: &mut Cursor<'t>, relative: bool) -> Result<(), ControllerError> {
        let verb = at.word().unwrap_or("").to_ascii_uppercase();
        let with = at.tokens.iter().position(|token| {
            token.kind == Kind::Word && self.text[token.range.clone()].eq_ignore_ascii_case(b"WITH")
        });
        // Settings behind WITH are of this motion alone.
        let before = with.map(|_| (self.flow.save(), self.mode.save()));
        if let Some(with) = with {
            self.with(&mut Cursor { at: with + 1, ..at.clone() })?;
        }
        let used = self.flow.motion();
        self.mode.motion();
        if let Some((flow, mode)) = before {
            self.flow.leave(flow);
            self.mode.leave(mode);
        }
        let places = if verb.contains("CIRC") { 2 } else { 1 };
        for place in 0..places {
            if place > 0 && !at.take(b',') {
                break;
            }
            self.destination(at, &verb, relative, used, place + 1 < places)?;
        }
        Ok(())
    }

    /// `SPLINE WITH $TOOL=…`: settings of all motions to its end.
    pub(super) fn spline(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        self.outside = Some([self.flow.save(), self.mode.save()]);
        while let Some(token) = at.next() {
            if self.text[token.range.clone()].eq_ignore_ascii_case(b"WITH") {
                return self.with(at);
            }
        }
        Ok(())
    }

    /// A spline ends.
    pub(super) fn ends(&mut self) {
        if let Some([flow, mode]) = self.outside.take() {
            self.flow.leave(flow);
            self.mode.leave(mode);
        }
    }

    fn destination(
        &mut self,
        at: &mut Cursor<'t>,
        verb: &str,
        relative: bool,
        used: usize,
        on_the_way: bool,
    ) -> Result<(), ControllerError> {
        let Some(token) = at.peek() else { return Ok(()) };
        let (line, start) = (token.line, token.range.start);
        let mut motion = Motion {
            head: Head { line, shown: verb.into(), linear: !verb.contains("PTP"), odd: None },
            name: None,
            computed: relative,
            used,
            inline: false,
        };
        if at.take(b'{') {
            let aggregate = Aggregate::read(at, line)?;
            motion.inline = true;
            if at.peek().is_some_and(|token| token.is(b':')) {
                motion.computed = true;
            } else if !relative {
                let named = format!("{verb} in line {line}");
                let found = candidate(self.text, &named, &aggregate, false, true);
                let found = found.map(|c| if on_the_way { c.on_the_way(self.text, &aggregate) } else { c });
                self.file.candidates.extend(found.map(|c| Candidate { inline: Some(used), ..c }));
            }
        } else {
            motion.name = name(at);
            // `XP1 : F`, `f(XP1)`, `XP1.X`.
            let more = [b':', b'(', b'.'].iter().any(|&sign| at.peek().is_some_and(|token| token.is(sign)));
            motion.computed |= more;
        }
        while let Some(token) = at.peek().filter(|token| !matches!(token.kind, Kind::End | Kind::Sign(b',')))
        {
            at.at += 1;
            match token.kind {
                Kind::Sign(b'(' | b'{' | b'[') => at.skip_closed(),
                Kind::Word => {
                    let word = at.str_of(token).to_ascii_uppercase();
                    if word == "WITH" {
                        at.at = at.tokens.len() - 1;
                    } else if !(word.starts_with("C_") || BEHIND.contains(&word.as_str()) || motion.computed)
                    {
                        motion.head.odd = Some(format!("`{word}` behind its point is not understood"));
                    }
                }
                _ => {}
            }
        }
        let end = at.tokens[..at.at.min(at.tokens.len())].last().map_or(start, |token| token.range.end);
        motion.head.shown =
            format!("{verb} {}", String::from_utf8_lossy(&self.text[start..end.max(start)]).trim());
        self.file.steps.push(Step::Motion(self.file.motions.len()));
        self.file.motions.push(motion);
        Ok(())
    }

    fn with(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        while let Some(token) = at.next() {
            let which = match &self.text[token.range.clone()] {
                word if word.eq_ignore_ascii_case(b"$BASE") => FRAME,
                word if word.eq_ignore_ascii_case(b"$TOOL") => TOOL,
                word if word.eq_ignore_ascii_case(b"$LOAD") => LOAD,
                word if word.eq_ignore_ascii_case(b"$IPO_MODE") => {
                    at.take(b'=');
                    self.mode(at);
                    continue;
                }
                _ => continue,
            };
            if at.take(b'=') {
                let to = self.reference(at, which)?;
                self.flow.set(which, to);
            }
        }
        Ok(())
    }
}
