//! What runs: after every change that matters, only what is looked at.

use std::sync::Arc;

use breccia_engine::Graph;
use eframe::egui::{ColorImage, Context, TextureOptions};

use super::App;
use crate::model::{Address, Level, shape_of};
use crate::run::{Item, Lane, Update, check, draft};
use crate::view::Subject;

impl App {
    /// Looks the document over again.
    pub(super) fn recheck(&mut self) {
        let document = &self.project.state().document;
        self.checked = check(document, &self.registry, self.project.folder(), &*self.files);
        self.checked_for = self.project.content();
        self.problems.clear();
        for problem in &self.checked.problems {
            if let Some(node) = &problem.node {
                self.problems.entry(crate::run::general(node)).or_default().push(problem.to_string());
            }
        }
        if let Some(graph) = &self.checked.graph {
            self.board.keep(&graph.nodes().map(|(name, _)| crate::run::general(name)).collect());
        }
        self.board.stale();
        self.results.values_mut().for_each(|subject| subject.stale = true);
        self.due = true;
        if self.watched.as_ref().is_none_or(|output| !self.can_run(output) && !self.is_kept(output)) {
            self.choose_watched();
        }
    }

    /// Whether the last result of an output is still worth looking at: its node is there, if off or wired in a way that cannot run.
    fn is_kept(&self, output: &str) -> bool {
        let Some((path, socket)) = output.rsplit_once('.').filter(|_| self.results.contains_key(output))
        else {
            return false;
        };
        let node = crate::run::general(path);
        // Of a zone that has fewer iterations now another one is looked at.
        let runs = |graph: &Arc<Graph>| graph.nodes().any(|(name, _)| crate::run::general(name) == node);
        !self.checked.graph.as_ref().is_some_and(runs) && self.gives(&node, socket)
    }

    /// Whether the document has this output, whatever becomes of it.
    fn gives(&self, node: &str, socket: &str) -> bool {
        let (document, registry) = (&self.checked.included, &self.registry);
        let (mut at, mut parts) = (Address::default(), node.split('/').peekable());
        while let Some(part) = parts.next() {
            let Some(entry) = Level::of(document, &at).and_then(|level| level.nodes.get(part)) else {
                return false;
            };
            let shape = shape_of(document, registry, &at, part, entry);
            if parts.peek().is_none() {
                return shape.output(socket).is_some();
            }
            let Some(inner) = shape.group else { return false };
            at = inner;
        }
        false
    }

    /// Whether a graph that can run has this output of a node.
    pub(super) fn can_run(&self, output: &str) -> bool {
        let Some((graph, (node, socket))) = self.checked.graph.as_ref().zip(output.rsplit_once('.')) else {
            return false;
        };
        graph
            .nodes()
            .any(|(name, spec)| name == node && spec.outputs.iter().any(|output| output.name == socket))
    }

    /// The outputs that the viewport needs: what is looked at, and what goes with it.
    fn wanted(&self) -> Vec<String> {
        let watched = self.watched.iter().filter(|output| self.can_run(output)).cloned();
        let mut wanted: Vec<String> = watched.chain(self.companions().into_all()).collect();
        wanted.dedup();
        wanted
    }

    /// Starts computing if something changed.
    pub(super) fn run_if_due(&mut self, ctx: &Context) {
        // A drag that is over is computed in full.
        if self.drafted && !self.dragging {
            self.due = true;
        }
        if !self.due || !self.live {
            return;
        }
        self.due = false;
        self.ask(Vec::new(), ctx);
    }

    /// Computes all outputs of the graph.
    pub(super) fn run_all(&mut self, ctx: &Context) {
        let outputs = match &self.checked.graph {
            Some(graph) => graph.outputs().map(|output| output.name.to_owned()).collect(),
            None => Vec::new(),
        };
        if outputs.is_empty() {
            self.say("The graph has no outputs that could be computed");
        }
        self.due = false;
        self.ran_all = !outputs.is_empty();
        self.ask(outputs, ctx);
    }

    /// Asks for what is looked at, for `more` outputs, and for small pictures.
    fn ask(&mut self, more: Vec<String>, ctx: &Context) {
        let Some(graph) = self.checked.graph.clone() else {
            self.stop();
            return;
        };
        self.drafted = self.dragging;
        self.asked = Arc::clone(&self.checked.bakes);
        let graph = if self.dragging {
            Arc::new(draft(&graph, self.full.as_deref()))
        } else {
            self.full = Some(Arc::clone(&graph));
            graph
        };
        let mut items = Vec::new();
        // A mesh is shown before the solid in it is there, which may take longer where the mesh was found on disk.
        let inside = self.companions().inside;
        let (inside, wanted) = self.wanted().into_iter().partition(|output| Some(output) == inside.as_ref());
        for outputs in [wanted, inside, more] {
            if !outputs.is_empty() {
                items.push(Item { graph: Arc::clone(&graph), outputs });
            }
        }
        self.board.begin();
        self.busy = [!items.is_empty(), false];
        self.ask_lane(Lane::Main, items);
        let pictures = if self.dragging { Vec::new() } else { self.wanted_pictures() };
        self.busy[1] = !pictures.is_empty();
        let pictures =
            pictures.into_iter().map(|output| Item { graph: Arc::clone(&graph), outputs: vec![output] });
        self.ask_lane(Lane::Pictures, pictures.collect());
        ctx.request_repaint();
    }

    fn ask_lane(&mut self, lane: Lane, items: Vec<Item>) {
        if let Err(error) = self.runner.ask(lane, items) {
            self.busy[usize::from(lane == Lane::Pictures)] = false;
            self.say(format!("nothing can be computed: the system gives no thread ({error})"));
        }
    }

    /// The outputs whose small pictures are shown, from left to right.
    fn wanted_pictures(&self) -> Vec<String> {
        let Some(layout) = self.project.state().layout(&self.address()) else { return Vec::new() };
        let mut found: Vec<_> =
            layout.nodes.iter().filter(|(_, place)| place.picture && !place.collapsed).collect();
        found.sort_by_key(|(name, place)| (place.at[0], (*name).clone()));
        let output = |name: &String| {
            let socket = &self.shapes.get(name)?.outputs.first()?.name;
            self.in_run(name, socket)
        };
        found.into_iter().filter_map(|(name, _)| output(name)).filter(|output| self.can_run(output)).collect()
    }

    /// Stops computing.
    pub(super) fn stop(&mut self) {
        self.ask_lane(Lane::Main, Vec::new());
        self.ask_lane(Lane::Pictures, Vec::new());
        self.busy = [false; 2];
        self.board.end();
    }

    /// Takes in what happened in runs.
    pub(super) fn take_news(&mut self, ctx: &Context) {
        for (lane, update) in self.runner.news() {
            match update {
                Update::Event(event) => self.board.note(&event),
                Update::Value(label, value) => {
                    // A draft is no last word.
                    let fit = self.asked.fit(&label);
                    self.results.insert(label.clone(), Subject { label, value, stale: self.drafted, fit });
                }
                Update::Picture(output, picture) => {
                    let Some((node, _)) = output.rsplit_once('.') else { continue };
                    let node = crate::run::general(node);
                    match picture {
                        Some(picture) => {
                            let image = ColorImage::from_rgba_unmultiplied(picture.size, &picture.rgba);
                            let texture = ctx.load_texture(&node, image, TextureOptions::LINEAR);
                            self.pictures.insert(node, texture);
                        }
                        None => {
                            self.pictures.remove(&node);
                        }
                    }
                }
                Update::Refused(reason) => self.say(reason),
                Update::Ended(_) => {
                    self.busy[usize::from(lane == Lane::Pictures)] = false;
                    if self.busy == [false; 2] {
                        self.board.end();
                        self.forget_results();
                        if std::mem::take(&mut self.ran_all) {
                            self.say("All outputs are computed; look at one to see or export it");
                        }
                    }
                }
            }
        }
    }

    /// Lets go of results that nobody looks at any more.
    fn forget_results(&mut self) {
        let needed = self.wanted();
        let watched = self.watched.as_ref();
        self.results.retain(|label, _| needed.contains(label) || Some(label) == watched);
    }

    /// The name of an output of the graph looked at in a run; of a zone, the last iteration.
    pub(super) fn in_run(&self, node: &str, socket: &str) -> Option<String> {
        if self.trail.0.is_empty() {
            return Some(format!("{node}.{socket}"));
        }
        let path = format!("{}{node}", self.trail.prefix());
        let graph = self.checked.graph.as_ref()?;
        // Of levels the finest is number 0, of other zones the last iteration has the highest number.
        let levels = self.zone_types();
        let rank = |name: &str| {
            let numbers: Vec<i64> = name.split('/').map(number).collect();
            numbers
                .iter()
                .zip(levels.iter().chain(std::iter::repeat(&false)))
                .map(|(n, fine)| if *fine { -n } else { *n })
                .collect::<Vec<_>>()
        };
        let matching = graph.nodes().map(|(name, _)| name).filter(|name| crate::run::general(name) == path);
        matching.max_by_key(|name| rank(name)).map(|name| format!("{name}.{socket}"))
    }

    /// Which of the nodes that were entered run a group for every level.
    fn zone_types(&self) -> Vec<bool> {
        let mut at = Address::default();
        let ty = |crumb: &crate::model::Crumb| {
            let level = Level::of(&self.checked.included, &at)?;
            let is_levels = level.nodes.get(&crumb.node)?.ty == "flow.levels";
            at = crumb.address.clone();
            Some(is_levels)
        };
        self.trail.0.iter().map_while(ty).collect()
    }
}

/// The number of an iteration in `zone[3]`.
fn number(part: &str) -> i64 {
    part.split_once('[').and_then(|(_, rest)| rest.trim_end_matches(']').parse().ok()).unwrap_or(0)
}
