//! A long piece of work beside the interpreter: on a thread of its own, while the calling thread waits without the interpreter's lock, shows
//! progress, and ends the run at Ctrl-C.

use crate::error::input;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use truepose_workflow::Observer;

/// Interval at which signals are looked for.
const STEP: Duration = Duration::from_millis(40);
/// Stack of the working thread, bytes: as much as Linux gives to a main thread.
const STACK: usize = 8 << 20;

/// An exception that Python code raised where none can be passed on: in the middle of a fit.
#[derive(Debug, Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps the first.
    pub fn keep(&self, error: PyErr) {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        slot.get_or_insert(error);
    }

    /// Whether there is one.
    pub fn any(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Takes it out.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// What the working thread may do besides its work.
pub struct Working {
    cancelled: Arc<AtomicBool>,
    steps: Mutex<Sender<Event>>,
    raised: Vec<Raised>,
}

enum Event {
    Step(String),
    Done,
}

impl Working {
    /// Whether to go on.
    pub fn go_on(&self) -> ControlFlow<()> {
        if self.cancelled.load(Ordering::Relaxed) || self.raised.iter().any(Raised::any) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl Observer for Working {
    fn step(&self, words: &str) -> ControlFlow<()> {
        let _ = self.steps.lock().unwrap_or_else(PoisonError::into_inner).send(Event::Step(words.into()));
        self.go_on()
    }
}

/// Runs `work` on so many threads; 0 for all there are.
///
/// # Errors
/// Those of the work; when there can be no more threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    match threads {
        0 => work(),
        _ => rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(input)?.install(work),
    }
}

/// Runs `work`. `progress` is called with the words of each step. What Python code raised inside wins over what the work returns.
///
/// # Errors
/// Those of the work; `KeyboardInterrupt`, after which the work ends at its next step.
pub fn supervised<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    raised: Vec<Raised>,
    work: impl FnOnce(&Working) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    let done = sender.clone();
    let cancelled = Arc::new(AtomicBool::new(false));
    let working = Working { cancelled: cancelled.clone(), steps: Mutex::new(sender), raised: raised.clone() };
    let worker = std::thread::Builder::new().name("truepose".into()).stack_size(STACK).spawn(move || {
        let result = work(&working);
        let _ = done.send(Event::Done);
        result
    });
    let mut worker = Some(worker.map_err(input)?);
    let receiver = Mutex::new(receiver);
    loop {
        let event = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(STEP));
        let shown = match event {
            Ok(Event::Step(words)) => progress.map_or(Ok(()), |show| show.call1((words,)).map(drop)),
            Ok(Event::Done) | Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => Ok(()),
        };
        if let Err(error) = shown.and_then(|()| py.check_signals()) {
            cancelled.store(true, Ordering::Relaxed);
            return Err(error);
        }
        if worker.as_ref().is_some_and(std::thread::JoinHandle::is_finished) {
            break;
        }
    }
    let joined = worker.take().map(|worker| py.detach(|| worker.join()));
    if let Some(error) = raised.iter().find_map(Raised::take) {
        return Err(error);
    }
    match joined {
        Some(Ok(result)) => result,
        _ => Err(PyRuntimeError::new_err("the computation ended in an internal error; please report it")),
    }
}
