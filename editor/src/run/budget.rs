//! Keeps the memory of the whole program within a budget: results have what the window, the viewport and a computation at work leave.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use breccia_engine::Engine;

/// How often the program's memory is looked at: a synthesis at work takes tens of megabytes more in this time.
const EVERY: Duration = Duration::from_millis(100);

/// The part of the budget that is left free for what is taken between two looks.
const SPARE: u64 = 8;

/// The part of the budget that results have in any case, those in use among them: without any, every small edit would compute all anew.
const LEAST: u64 = 16;

/// Watches over the memory of the program until it is dropped.
pub struct MemoryBudget {
    total: u64,
    resident: Arc<AtomicU64>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl MemoryBudget {
    /// What the results of an engine may take of a budget before anything is known of the rest.
    pub fn at_first(total: u64) -> u64 {
        total / 2
    }

    /// Keeps the program within a number of bytes from now on, as far as results of this engine can give way.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn new(total: u64, engine: Engine) -> std::io::Result<Self> {
        let resident = Arc::new(AtomicU64::new(0));
        let (stop, stopped) = channel();
        let seen = Arc::clone(&resident);
        let thread = std::thread::Builder::new().name("memory".into()).spawn(move || {
            while stopped.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                // Where the system does not tell, results stay at their first share.
                let Some(stats) = memory_stats::memory_stats() else { return };
                let bytes = stats.physical_mem as u64;
                seen.store(bytes, Ordering::Relaxed);
                engine.set_memory(share(total, bytes, engine.memory_usage().1));
            }
        })?;
        Ok(Self { total, resident, stop: Some(stop), thread: Some(thread) })
    }

    /// Bytes that the program takes, and those that it may take. The first is 0 while it is not known.
    pub fn usage(&self) -> [u64; 2] {
        [self.resident.load(Ordering::Relaxed), self.total]
    }
}

impl Drop for MemoryBudget {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

/// The bytes that results may take, where the program takes `resident` and results are `held` of them: what is too much altogether
/// comes off, what is left over comes on top.
fn share(total: u64, resident: u64, held: u64) -> u64 {
    let aim = total - total / SPARE;
    aim.saturating_add(held).saturating_sub(resident).clamp(total / LEAST, aim)
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use breccia_engine::{CancelToken, Document, Graph};
    use proptest::prelude::*;

    use super::*;

    const GIB: u64 = 1 << 30;

    proptest! {
        /// Whatever else takes memory and however much results are, they end where all fits, or at their least.
        #[test]
        fn results_leave_what_others_need(others in 0..3 * GIB, results in 0..3 * GIB, total in 1..4 * GIB) {
            let left = share(total, others + results, results);
            prop_assert!(left >= total / LEAST && left <= total);
            prop_assert!(others + left <= total || left == total / LEAST);
            // Once they fit the share it stays where it is: nothing swings.
            let held = results.min(left);
            prop_assert_eq!(share(total, others + held, held), left);
        }
    }

    #[test]
    fn results_go_while_the_program_takes_too_much_and_come_back_after() {
        let engine = Engine::builder().memory(GIB).build(Arc::new(breccia_nodes::registry())).unwrap();
        let document = Document::parse(
            r#"(format: "breccia-graph", version: 2,
            nodes: {"a": (type: "solid.checker"), "volume": (type: "solid.to_volume", params: {"size": [64, 64, 64]})},
            links: ["a.solid -> volume.solid"])"#,
        )
        .unwrap();
        let graph = Arc::new(Graph::new(&document, &breccia_nodes::registry()).unwrap());
        let run = || drop(engine.run(&graph, &["volume.volume"], &CancelToken::default(), &|_| {}).unwrap());
        run();
        let held = engine.memory_usage().1;
        assert!(held >= 64 * 64 * 64 * 3, "{held}");
        // A process of any kind takes more than a mebibyte.
        let budget = MemoryBudget::new(1 << 20, engine.clone()).unwrap();
        let begun = Instant::now();
        while engine.memory_usage().1 > 1 << 16 && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(EVERY);
        }
        assert!(engine.memory_usage().1 <= 1 << 16, "results stay");
        let [resident, total] = budget.usage();
        assert!(resident > 1 << 20 && total == 1 << 20, "{resident}");
        drop(budget);
        engine.set_memory(GIB);
        run();
        assert_eq!(engine.memory_usage().1, held);
    }
}
