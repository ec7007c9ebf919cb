//! In which order the points of a program are reached: motions, routines and their calls.
//!
//! Ways that branch are taken in the order of the text. A routine that no other one calls is a way of its own.

use crate::Program;
use crate::event::Event;
use std::collections::BTreeMap;

/// A stop on the way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stop {
    /// Program and point; none: a place that is not known.
    pub(crate) points: Vec<(usize, usize)>,
    /// Whether the tool comes along a line or an arc.
    pub(crate) linear: bool,
    /// Whether the configuration data of the point is followed.
    pub(crate) followed: bool,
    /// Whether a way begins here.
    pub(crate) first: bool,
}

/// All stops of the files of a program, each read with all others.
pub(crate) fn route(programs: &[Program]) -> Vec<Stop> {
    let mut routines = Routines::default();
    for file in 0..programs.len() {
        routines.file(programs, file);
    }
    let mut walk = Walk { routines: &routines, done: BTreeMap::new(), stops: Vec::new(), control: [true; 2] };
    let called = |k: &usize| !routines.called.contains_key(&routines.all[*k].0);
    let roots = (0..routines.all.len()).filter(called).chain(0..routines.all.len());
    for root in roots {
        if walk.done.contains_key(&root) {
            continue;
        }
        walk.control = [true; 2];
        let from = walk.stops.len();
        walk.routine(root, 0);
        if let Some(first) = walk.stops.get_mut(from) {
            first.first = true;
        }
    }
    walk.stops
}

#[derive(Debug)]
enum Item {
    Stop(Vec<(usize, usize)>, bool),
    Call(String),
    Control(usize, bool),
}

#[derive(Debug, Default)]
struct Routines {
    /// Names and what happens.
    all: Vec<(String, Vec<Item>)>,
    places: BTreeMap<String, usize>,
    called: BTreeMap<String, ()>,
}

impl Routines {
    fn file(&mut self, programs: &[Program], file: usize) {
        // A file is the first of its own program, and one of the others of every other.
        let events = |program: usize| {
            let place = if program == file { 0 } else { file + usize::from(file < program) };
            programs[program].route.get(place).map_or(&[][..], Vec::as_slice)
        };
        let mut open = vec![self.begin(String::new())];
        for (at, event) in events(file).iter().enumerate() {
            let into = open.last().copied().unwrap_or_default();
            match event {
                Event::Begin(name) => open.push(self.begin(name.clone())),
                Event::End => {
                    if open.len() > 1 {
                        open.pop();
                    }
                }
                Event::Call(name) => {
                    if self.all[into].0 != *name {
                        self.called.insert(name.clone(), ());
                    }
                    self.all[into].1.push(Item::Call(name.clone()));
                }
                Event::Control { linear, followed } => {
                    self.all[into].1.push(Item::Control(usize::from(*linear), *followed));
                }
                Event::Visit(own) => {
                    let mut points: Vec<(usize, usize)> = Vec::new();
                    for program in 0..programs.len() {
                        if let Some(Event::Visit(visit)) = events(program).get(at) {
                            points.extend(visit.points.iter().map(|&point| (program, point)));
                        }
                    }
                    self.all[into].1.push(Item::Stop(points, own.linear));
                }
            }
        }
    }

    fn begin(&mut self, name: String) -> usize {
        let at = self.all.len();
        if !name.is_empty() {
            self.places.entry(name.clone()).or_insert(at);
        }
        self.all.push((name, Vec::new()));
        at
    }
}

/// Routines that call each other deeper than this are left.
const DEEPEST: usize = 64;

struct Walk<'r> {
    routines: &'r Routines,
    /// The last stop of each routine that was walked.
    done: BTreeMap<usize, Option<usize>>,
    stops: Vec<Stop>,
    /// Whether configuration data of joint motions and of linear ones is followed.
    control: [bool; 2],
}

impl Walk<'_> {
    fn routine(&mut self, routine: usize, depth: usize) {
        self.done.insert(routine, None);
        let from = self.stops.len();
        for item in &self.routines.all[routine].1 {
            match item {
                Item::Control(which, followed) => self.control[*which] = *followed,
                Item::Stop(points, linear) => {
                    let followed = self.control[usize::from(*linear)];
                    self.stops.push(Stop { points: points.clone(), linear: *linear, followed, first: false });
                }
                Item::Call(name) => {
                    let Some(&called) = self.routines.places.get(name) else { continue };
                    match self.done.get(&called) {
                        // It ends where it ended the first time.
                        Some(last) => {
                            let last = last.and_then(|last| self.stops.get(last)).cloned();
                            self.stops.extend(last.map(|stop| Stop { first: false, ..stop }));
                        }
                        None if depth < DEEPEST => self.routine(called, depth + 1),
                        None => {}
                    }
                }
            }
        }
        if self.stops.len() > from {
            self.done.insert(routine, Some(self.stops.len() - 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dialect;
    use crate::event::Visit;

    fn program(points: usize, route: Vec<Vec<Event>>) -> Program {
        let text = "DEF a()\nEND\n";
        let mut program = Program::read(text.as_bytes(), &[], Dialect::Krl).expect("a program");
        program.route = route;
        assert!(points < 10);
        program
    }

    fn visit(points: &[usize]) -> Event {
        Visit::event(points.to_vec(), true, 1)
    }

    #[test]
    fn routines_are_walked_where_they_are_called() {
        let begin = |name: &str| Event::Begin(name.into());
        let call = |name: &str| Event::Call(name.into());
        let off = Event::Control { linear: true, followed: false };
        let events = vec![
            begin("A"),
            visit(&[0]),
            off,
            call("B"),
            visit(&[1]),
            call("B"),
            Event::End,
            begin("B"),
            visit(&[2]),
            visit(&[3]),
            Event::End,
            begin("C"),
            visit(&[4]),
            call("C"),
            Event::End,
        ];
        let stops = route(&[program(5, vec![events])]);
        let points: Vec<usize> = stops.iter().map(|stop| stop.points[0].1).collect();
        assert_eq!(points, [0, 2, 3, 1, 3, 4]);
        let followed: Vec<bool> = stops.iter().map(|stop| stop.followed).collect();
        assert_eq!(followed, [true, false, false, false, false, true]);
        let first: Vec<usize> = (0..stops.len()).filter(|&k| stops[k].first).collect();
        assert_eq!(first, [0, 5]);
    }

    #[test]
    fn a_point_of_another_file_is_a_stop_on_the_way() {
        // The second file has point 0 of the second program, to which the first file goes.
        let first = program(1, vec![vec![visit(&[0]), visit(&[])], vec![]]);
        let second = program(1, vec![vec![], vec![visit(&[]), visit(&[0])]]);
        let stops = route(&[first, second]);
        let points: Vec<&[(usize, usize)]> = stops.iter().map(|stop| &*stop.points).collect();
        assert_eq!(points, [[(0, 0)], [(1, 0)]]);
    }
}
