//! Work behind the window: the latest request wins, results come one by one, and each wakes the window.
//!
//! A worker has one thread, so that a dragged slider never piles up threads. A request that is superseded hears of it through
//! [`Control::is_cancelled`]; one that has not begun is dropped unheard.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use breccia_nodes::control::Control;
use breccia_shaders::Gpu;
use eframe::egui;

type Work = Box<dyn FnOnce() + Send>;

/// What the thread is to do next.
enum Slot {
    Nothing,
    Waiting(Work),
    Closed,
}

struct Shared {
    /// The number of the latest request.
    latest: AtomicU64,
    /// The fraction done of it, as bits.
    progress: AtomicU32,
    slot: Mutex<Slot>,
    wake: Condvar,
}

impl Shared {
    fn put(&self, slot: Slot) {
        *self.slot.lock().unwrap_or_else(PoisonError::into_inner) = slot;
        self.wake.notify_one();
    }

    /// Waits for work; `None` once the worker is closed.
    fn take(&self) -> Option<Work> {
        let mut slot = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            match std::mem::replace(&mut *slot, Slot::Nothing) {
                Slot::Waiting(work) => return Some(work),
                Slot::Closed => return None,
                Slot::Nothing => slot = self.wake.wait(slot).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

enum Message<T> {
    Result(T),
    Done(Result<(), String>),
}

/// A request as its work sees it: where results go, and whether they are still wanted.
pub struct Job<T> {
    number: u64,
    shared: Arc<Shared>,
    results: Sender<(u64, Message<T>)>,
    wake: egui::Context,
    gpu: Option<Arc<Gpu>>,
}

impl<T> Job<T> {
    /// Hands a result over.
    pub fn send(&self, result: T) {
        // Nobody listens once the window is closed, and then nothing is lost.
        let _ = self.results.send((self.number, Message::Result(result)));
        self.wake.request_repaint();
    }

    fn superseded(&self) -> bool {
        self.shared.latest.load(Ordering::Relaxed) != self.number
    }
}

impl<T: Send> Control for Job<T> {
    fn is_cancelled(&self) -> bool {
        self.superseded()
    }

    fn progress(&self, fraction: f32) {
        self.shared.progress.store(fraction.to_bits(), Ordering::Relaxed);
    }

    fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_deref()
    }
}

/// A thread that works on the latest of the requests made to it. `K` says what a request is for: the same again changes nothing.
pub struct Worker<K, T> {
    name: &'static str,
    gpu: Option<Arc<Gpu>>,
    shared: Arc<Shared>,
    sender: Sender<(u64, Message<T>)>,
    receiver: Receiver<(u64, Message<T>)>,
    key: Option<K>,
    running: bool,
    error: Option<String>,
    thread: bool,
}

impl<K: PartialEq, T: Send + 'static> Worker<K, T> {
    /// A worker without a thread yet; `gpu` is offered to what it runs.
    pub fn new(name: &'static str, gpu: Option<Arc<Gpu>>) -> Self {
        let (sender, receiver) = channel();
        let shared = Shared {
            latest: AtomicU64::new(0),
            progress: AtomicU32::new(0),
            slot: Mutex::new(Slot::Nothing),
            wake: Condvar::new(),
        };
        let shared = Arc::new(shared);
        Self { name, gpu, shared, sender, receiver, key: None, running: false, error: None, thread: false }
    }

    /// Asks for `work` unless it was the last thing asked for. Returns whether it is new.
    pub fn want(
        &mut self,
        ctx: &egui::Context,
        key: K,
        work: impl FnOnce(&Job<T>) -> Result<(), String> + Send + 'static,
    ) -> bool {
        if self.key.as_ref() == Some(&key) {
            return false;
        }
        self.key = Some(key);
        self.error = None;
        self.running = true;
        let number = self.shared.latest.fetch_add(1, Ordering::Relaxed) + 1;
        self.shared.progress.store(0, Ordering::Relaxed);
        let job = Job {
            number,
            shared: Arc::clone(&self.shared),
            results: self.sender.clone(),
            wake: ctx.clone(),
            gpu: self.gpu.clone(),
        };
        self.shared.put(Slot::Waiting(Box::new(move || run(&job, work))));
        if !self.thread {
            self.thread = true;
            let shared = Arc::clone(&self.shared);
            let body = move || {
                while let Some(work) = shared.take() {
                    work();
                }
            };
            if let Err(error) = std::thread::Builder::new().name(self.name.to_owned()).spawn(body) {
                self.thread = false;
                self.running = false;
                self.error = Some(format!("no thread could be started: {error}"));
            }
        }
        true
    }

    /// The results that came since the last call, of the latest request alone.
    pub fn poll(&mut self) -> Vec<T> {
        self.poll_up_to(usize::MAX)
    }

    /// As [`Worker::poll`], at most so many; the rest waits for the next call.
    pub fn poll_up_to(&mut self, most: usize) -> Vec<T> {
        let latest = self.shared.latest.load(Ordering::Relaxed);
        let mut results = Vec::new();
        while results.len() < most
            && let Ok((number, message)) = self.receiver.try_recv()
        {
            match message {
                _ if number != latest => {}
                Message::Result(result) => results.push(result),
                Message::Done(done) => {
                    self.running = false;
                    self.error = done.err();
                }
            }
        }
        results
    }

    /// Gives the request up. The same may be asked for again.
    pub fn cancel(&mut self) {
        self.key = None;
        self.running = false;
        self.error = None;
        self.shared.latest.fetch_add(1, Ordering::Relaxed);
        self.shared.put(Slot::Nothing);
    }

    /// Gives the request up if it still runs: what nobody sees need not be found.
    pub fn rest(&mut self) {
        if self.running {
            self.cancel();
        }
    }

    /// Whether the latest request still runs.
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// The fraction done of the latest request's present step.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.shared.progress.load(Ordering::Relaxed)).clamp(0.0, 1.0)
    }

    /// Why the latest request failed.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// What was asked for last.
    pub fn key(&self) -> Option<&K> {
        self.key.as_ref()
    }
}

impl<K, T> Drop for Worker<K, T> {
    fn drop(&mut self) {
        self.shared.latest.fetch_add(1, Ordering::Relaxed);
        self.shared.put(Slot::Closed);
    }
}

fn run<T: Send>(job: &Job<T>, work: impl FnOnce(&Job<T>) -> Result<(), String>) {
    if job.superseded() {
        return;
    }
    let done = catch_unwind(AssertUnwindSafe(|| work(job)))
        .unwrap_or_else(|_| Err("the computation stopped unexpectedly".to_owned()));
    let _ = job.results.send((job.number, Message::Done(done)));
    job.wake.request_repaint();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polls until the latest request has ended.
    fn finish(worker: &mut Worker<u32, u32>) -> Vec<u32> {
        let mut all = Vec::new();
        while worker.is_running() {
            all.extend(worker.poll());
            std::thread::yield_now();
        }
        all
    }

    #[test]
    fn a_superseded_request_is_cancelled_and_its_results_are_dropped() {
        let ctx = egui::Context::default();
        let mut worker = Worker::new("test", None);
        let (begun, begins) = channel();
        let (ended, ends) = channel();
        assert!(worker.want(&ctx, 1, move |job| {
            let _ = begun.send(());
            while !job.is_cancelled() {
                std::thread::yield_now();
            }
            job.send(1);
            let _ = ended.send(());
            Ok(())
        }));
        begins.recv().unwrap();
        assert!(worker.want(&ctx, 2, |job| {
            job.send(2);
            Ok(())
        }));
        ends.recv().unwrap();
        assert_eq!(finish(&mut worker), [2]);
    }

    #[test]
    fn the_same_request_again_changes_nothing() {
        let ctx = egui::Context::default();
        let mut worker = Worker::new("test", None);
        assert!(worker.want(&ctx, 7, |job| {
            job.send(70);
            Ok(())
        }));
        assert!(!worker.want(&ctx, 7, |_| Err("never run".to_owned())));
        assert_eq!(finish(&mut worker), [70]);
        assert_eq!(worker.error(), None);
    }

    #[test]
    fn errors_and_panics_are_told() {
        let ctx = egui::Context::default();
        let mut worker = Worker::<u32, u32>::new("test", None);
        worker.want(&ctx, 1, |_| Err("no such map".to_owned()));
        finish(&mut worker);
        assert_eq!(worker.error(), Some("no such map"));
        worker.want(&ctx, 2, |_| std::panic::panic_any("deliberate"));
        finish(&mut worker);
        assert_eq!(worker.error(), Some("the computation stopped unexpectedly"));
        worker.want(&ctx, 3, |_| Ok(()));
        finish(&mut worker);
        assert_eq!(worker.error(), None);
    }
}
