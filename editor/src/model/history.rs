//! Undo and redo of everything, by name.

use super::diff::Diff;
use super::state::State;

/// Most steps that are kept; the oldest go first.
const MAX_STEPS: usize = 50_000;

struct Step {
    name: String,
    diff: Diff,
    /// Steps with the same key that follow each other are one: a drag is one step.
    merge: Option<String>,
}

/// What was done, and what was undone.
#[derive(Default)]
pub struct History {
    steps: Vec<Step>,
    /// How many of the steps are done; the others are undone.
    done: usize,
    /// The number of steps done when the document was last saved, if it can be reached.
    saved: Option<usize>,
}

impl History {
    /// A history that begins with a saved document.
    pub fn new() -> Self {
        Self { saved: Some(0), ..Self::default() }
    }

    /// Notes a change from one state to another. Returns whether anything changed.
    pub fn record(&mut self, name: &str, merge: Option<&str>, before: &State, after: &State) -> bool {
        let diff = Diff::between(before, after);
        if diff.is_empty() {
            return false;
        }
        if self.saved.is_some_and(|saved| saved > self.done) {
            self.saved = None;
        }
        self.steps.truncate(self.done);
        let merges = |step: &Step| merge.is_some() && step.merge.as_deref() == merge;
        if let Some(last) = self.steps.last_mut().filter(|step| merges(step) && self.saved != Some(self.done))
        {
            last.diff = last.diff.then(&diff, after);
            if last.diff.is_empty() {
                self.steps.pop();
                self.done -= 1;
            }
            return true;
        }
        self.steps.push(Step { name: name.to_owned(), diff, merge: merge.map(str::to_owned) });
        self.done += 1;
        if self.steps.len() > MAX_STEPS {
            self.steps.remove(0);
            self.done -= 1;
            self.saved = self.saved.and_then(|saved| saved.checked_sub(1));
        }
        true
    }

    /// Ends a drag: what follows is a step of its own.
    pub fn seal(&mut self) {
        if let Some(last) = self.done.checked_sub(1).and_then(|i| self.steps.get_mut(i)) {
            last.merge = None;
        }
    }

    /// Undoes the last step and returns its name.
    pub fn undo(&mut self, state: &mut State) -> Option<&str> {
        let step = self.steps.get(self.done.checked_sub(1)?)?;
        step.diff.apply(state, false);
        self.done -= 1;
        Some(&step.name)
    }

    /// Does the step again that was undone last, and returns its name.
    pub fn redo(&mut self, state: &mut State) -> Option<&str> {
        let step = self.steps.get(self.done)?;
        step.diff.apply(state, true);
        self.done += 1;
        Some(&step.name)
    }

    /// Changes the names of files in all states that the steps lead through, of which `state` is the present one: where each step leads to
    /// is what it led to before, changed. Names and places of the steps stay. Most steps, such as moves, have to do with no file and
    /// cost no more than undoing them.
    pub fn rewrite_files(&mut self, state: &State, change: impl Fn(&mut State)) {
        let changed = |state: &State| {
            let mut state = state.clone();
            change(&mut state);
            state
        };
        let (done, undone) = self.steps.split_at_mut(self.done);
        // From the present outwards: these are the states that undo and redo come by, with what is no step of its own.
        let (mut at, mut new) = (state.clone(), changed(state));
        for step in done.iter_mut().rev() {
            step.diff.apply(&mut at, false);
            if !step.diff.may_name_files() {
                step.diff.apply(&mut new, false);
                continue;
            }
            let before = changed(&at);
            step.diff = Diff::between(&before, &new);
            new = before;
        }
        let (mut at, mut new) = (state.clone(), changed(state));
        for step in undone {
            step.diff.apply(&mut at, true);
            if !step.diff.may_name_files() {
                step.diff.apply(&mut new, true);
                continue;
            }
            let after = changed(&at);
            step.diff = Diff::between(&new, &after);
            new = after;
        }
    }

    /// The name of the step that would be undone.
    pub fn undoable(&self) -> Option<&str> {
        Some(&self.steps.get(self.done.checked_sub(1)?)?.name)
    }

    /// The name of the step that would be done again.
    pub fn redoable(&self) -> Option<&str> {
        Some(&self.steps.get(self.done)?.name)
    }

    /// Whether the state is the one that was saved.
    pub fn is_saved(&self) -> bool {
        self.saved == Some(self.done)
    }

    /// Notes that the state is saved now.
    pub fn saved(&mut self) {
        self.seal();
        self.saved = Some(self.done);
    }

    /// Forgets that the state was ever saved: it came from somewhere that cannot be written.
    pub fn unsaved(&mut self) {
        self.saved = None;
    }
}
