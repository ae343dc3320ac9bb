//! Ten thousand things that nobody would do.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use breccia_editor::action::{Action, Joint, Kind, Pin, Selection};
use breccia_editor::command::Command;
use breccia_editor::model::{Address, Alignment, State, text_of};
use breccia_engine::{Document, Group, Link, NodeEntry, ParamKind, ParamValue, Registry};
use eframe::egui::{self, Key, Modifiers, PointerButton, pos2};

use super::window::{Desk, open};

/// How many things are done.
const ACTIONS: usize = 10_000;
/// Documents are not let grow beyond this.
const NODES: usize = 160;

/// Numbers that follow from a seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }

    fn one<'a, T>(&mut self, from: &'a [T]) -> Option<&'a T> {
        let i = self.below(from.len());
        from.get(i)
    }

    fn place(&mut self) -> [i32; 2] {
        [self.below(2000) as i32 - 500, self.below(1200) as i32 - 300]
    }
}

/// The node types.
fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(breccia_nodes::registry)
}

/// The nodes that are looked at.
fn nodes(desk: &mut Desk) -> Vec<(String, NodeEntry)> {
    let at = desk.app().trail().address();
    let level = desk.app().project().state().level(&at);
    level.map_or(Vec::new(), |level| level.nodes.iter().map(|(n, e)| (n.clone(), e.clone())).collect())
}

fn pin(dice: &mut Dice, nodes: &[(String, NodeEntry)]) -> Option<Pin> {
    let (node, entry) = dice.one(nodes)?;
    let ty = registry().node(&entry.ty)?;
    let output = dice.below(2) == 0;
    let sockets: Vec<String> =
        if output { &ty.spec.outputs } else { &ty.spec.inputs }.iter().map(|s| s.name.to_owned()).collect();
    Some(Pin { node: node.clone(), socket: dice.one(&sockets)?.clone(), output })
}

fn value(dice: &mut Dice, kind: &ParamKind) -> ParamValue {
    match kind {
        ParamKind::Bool => ParamValue::Bool(dice.below(2) == 0),
        ParamKind::Int { min, max } => {
            ParamValue::Int((*min).max((*max).min(min.saturating_add(dice.below(300) as i64 - 5))))
        }
        ParamKind::Float { .. } => ParamValue::Float(dice.below(1000) as f64 / 250.0 - 1.0),
        ParamKind::Choice(choices) => {
            ParamValue::Text(dice.one(choices).map_or(String::new(), |c| c.0.to_owned()))
        }
        ParamKind::Ints { .. } => {
            ParamValue::List((0..dice.below(4)).map(|_| ParamValue::Int(dice.below(64) as i64)).collect())
        }
        ParamKind::Floats { .. } => {
            ParamValue::List((0..dice.below(4)).map(|_| ParamValue::Float(dice.below(64) as f64)).collect())
        }
        _ => ParamValue::Text(
            ["", "level", "group", "no/such.png", "builtin:cobbles/color_64.png"][dice.below(5)].to_owned(),
        ),
    }
}

fn action(dice: &mut Dice, desk: &mut Desk, types: &[String]) -> Option<Action> {
    let nodes = nodes(desk);
    let names: Vec<String> = nodes.iter().map(|(name, _)| name.clone()).collect();
    let at = desk.app().trail().address();
    let links: Vec<String> =
        desk.app().project().state().level(&at).map_or(Vec::new(), |level| level.links.to_vec());
    let some = |dice: &mut Dice| -> BTreeSet<String> {
        (0..dice.below(6)).filter_map(|_| dice.one(&names).cloned()).collect()
    };
    if nodes.len() > NODES {
        let ctx = desk.harness.ctx.clone();
        let many = names.iter().take(NODES / 2).cloned().collect();
        desk.app().act(Action::Select(Selection { nodes: many, ..Selection::default() }), &ctx);
        return Some(Action::Command(Command::Delete));
    }
    Some(match dice.below(24) {
        0..=2 => {
            let kind = Kind::Type(dice.one(types)?.clone());
            let joint = match dice.below(4) {
                0 => pin(dice, &nodes).map(Joint::Pin),
                1 => dice.one(&links).cloned().map(Joint::Link),
                _ => None,
            };
            Action::Add { kind, at: dice.place(), joint }
        }
        3 | 4 => Action::Connect(pin(dice, &nodes)?, pin(dice, &nodes)?),
        5 => Action::Reconnect {
            link: dice.one(&links)?.clone(),
            from: pin(dice, &nodes)?,
            to: pin(dice, &nodes)?,
        },
        6 => Action::Disconnect(vec![dice.one(&links)?.clone()]),
        7 | 8 => Action::Select(Selection {
            nodes: some(dice),
            links: dice.one(&links).into_iter().cloned().collect(),
            frames: [dice.below(4) as u32].into(),
        }),
        9 => Action::Move(dice.place()),
        10 => Action::EndDrag,
        11 => Action::Bend(dice.one(&links)?.clone(), (0..dice.below(3)).map(|_| dice.place()).collect()),
        12 | 13 => {
            let (node, entry) = dice.one(&nodes)?.clone();
            let params = &registry().node(&entry.ty)?.spec.params;
            let param = dice.one(params)?;
            let value = value(dice, &param.kind);
            let value = (dice.below(5) > 0).then_some(value);
            Action::Set { node, param: param.name.to_owned(), value, dragging: dice.below(2) == 0 }
        }
        14 => {
            let (node, entry) = dice.one(&nodes)?.clone();
            let param = dice.one(&registry().node(&entry.ty)?.spec.params)?.name.to_owned();
            match dice.below(3) {
                0 => Action::Expose { node, param },
                1 => Action::Unexpose { node, param },
                _ => {
                    let exposed: Vec<String> =
                        desk.app().project().state().document.interface.params.keys().cloned().collect();
                    Action::LinkParam { node, param, to: dice.one(&exposed)?.clone() }
                }
            }
        }
        15 => Action::Rename(
            dice.one(&names)?.clone(),
            ["a", "b c", "", "bake", "ä", "x.y"][dice.below(6)].to_owned(),
        ),
        16 => Action::Output(pin(dice, &nodes)?),
        17 => Action::Align(
            [Alignment::Left, Alignment::Right, Alignment::Top, Alignment::Bottom][dice.below(4)],
        ),
        18 => Action::SizeFrame(dice.below(4) as u32, dice.place()),
        19 => {
            if dice.below(2) == 0 {
                Action::Enter(dice.one(&names)?.clone())
            } else {
                Action::Leave(dice.below(3))
            }
        }
        20 => Action::DropOnLink { node: dice.one(&names)?.clone(), link: dice.one(&links)?.clone() },
        _ => {
            // What would leave the document, or the program.
            let leaves = [
                Command::Gallery,
                Command::Quit,
                Command::New,
                Command::Open,
                Command::Reload,
                Command::Save,
                Command::SaveAs,
                Command::ImportBundle,
                Command::ExportBundle,
                Command::ExportOutput,
                Command::Live,
                Command::Run,
                Command::SaveGroup,
                Command::Larger,
                Command::Smaller,
            ];
            let commands: Vec<Command> =
                Command::ALL.iter().copied().filter(|c| !leaves.contains(c)).collect();
            Action::Command(*dice.one(&commands)?)
        }
    })
}

/// Something that hands and mice do.
fn event(dice: &mut Dice, desk: &mut Desk) {
    // Below the menus and buttons, which lead away from the document.
    let at = pos2(dice.below(1280) as f32, 60.0 + dice.below(630) as f32);
    let harness = &mut desk.harness;
    match dice.below(6) {
        0 => harness.hover_at(at),
        1 => harness.drag_at(at),
        2 => harness.drop_at(at),
        3 => {
            let keys = [
                Key::Tab,
                Key::Escape,
                Key::Enter,
                Key::ArrowDown,
                Key::Backspace,
                Key::V,
                Key::L,
                Key::M,
                Key::G,
                Key::F1,
            ];
            let modifiers =
                [Modifiers::NONE, Modifiers::COMMAND, Modifiers::SHIFT, Modifiers::ALT][dice.below(4)];
            // Files are not to be opened.
            harness.key_press_modifiers(modifiers, keys[dice.below(keys.len())]);
        }
        4 => harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: egui::vec2(0.0, dice.below(200) as f32 - 100.0),
            modifiers: Modifiers::NONE,
            phase: egui::TouchPhase::Move,
        }),
        _ => {
            for pressed in [true, false] {
                let button =
                    [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle][dice.below(3)];
                harness.event(egui::Event::PointerButton {
                    pos: at,
                    button,
                    pressed,
                    modifiers: Modifiers::NONE,
                });
            }
        }
    }
}

/// What is asked of the nodes and links of one graph, by its name.
type Check<'a> = &'a dyn Fn(&BTreeMap<String, NodeEntry>, &[String], &str);

/// What must hold of every document.
fn check(state: &State) {
    let graph = |nodes: &BTreeMap<String, NodeEntry>, links: &[String], at: &str| {
        let mut seen = BTreeSet::new();
        for text in links {
            let link = Link::parse(text).unwrap_or_else(|| panic!("{at}: no link: {text}"));
            assert!(
                nodes.contains_key(&link.from_node) && nodes.contains_key(&link.to_node),
                "{at}: a link from or to nowhere: {text}"
            );
            assert_ne!(link.from_node, link.to_node, "{at}: a node that waits for itself");
            assert!(seen.insert(text.clone()), "{at}: a link twice: {text}");
        }
        assert!(acyclic(nodes, links), "{at}: nodes that wait for each other");
    };
    fn groups(found: &BTreeMap<String, Group>, check: Check<'_>) {
        for (name, group) in found {
            check(&group.nodes, &group.links, name);
            groups(&group.groups, check);
        }
    }
    let document = &state.document;
    graph(&document.nodes, &document.links, "the graph");
    groups(&document.groups, &graph);
    let there = |node: &str| document.nodes.contains_key(node);
    for (name, output) in &document.interface.outputs {
        assert!(there(&output.node), "output {name} of nowhere");
    }
    for (name, param) in &document.interface.params {
        assert!(
            param.targets.iter().all(|t| t.split_once('.').is_some_and(|(node, _)| there(node))),
            "parameter {name} of nowhere"
        );
    }
    if let Some(layout) = state.layout(&Address::default()) {
        assert!(layout.nodes.keys().all(|node| there(node)), "a place of nothing");
        assert!(layout.bends.keys().all(|link| document.links.contains(link)), "bends of nothing");
    }
    let text = text_of(state);
    let read = Document::parse(&text)
        .unwrap_or_else(|error| panic!("what is written cannot be read: {error}\n{text}"));
    assert_eq!(text_of(&State::new(read)), text);
}

fn acyclic(nodes: &BTreeMap<String, NodeEntry>, links: &[String]) -> bool {
    let mut links: Vec<Link> = links.iter().filter_map(|link| Link::parse(link)).collect();
    let mut left: BTreeSet<&String> = nodes.keys().collect();
    loop {
        let waiting: BTreeSet<String> = links.iter().map(|link| link.to_node.clone()).collect();
        let free: Vec<&String> = left.iter().copied().filter(|node| !waiting.contains(*node)).collect();
        if free.is_empty() {
            return left.is_empty();
        }
        left.retain(|node| !free.contains(node));
        links.retain(|link| left.contains(&link.from_node));
    }
}

#[test]
fn ten_thousand_random_actions_break_nothing_and_are_undone_byte_for_byte() {
    let mut desk = open(Some("hybrid_mesh"), false);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Command(Command::Live), &ctx);
    desk.app().act(Action::Command(Command::Stop), &ctx);
    desk.frames(2);
    let first = text_of(desk.app().project().state());
    let types: Vec<String> = registry().nodes().map(|ty| ty.spec.id.to_owned()).collect();
    // Another seed does other things.
    let seed = std::env::var("BRECCIA_MONKEY_SEED").ok().and_then(|seed| seed.parse().ok());
    let mut dice = Dice(seed.unwrap_or(1));
    let mut done = 0;
    while done < ACTIONS {
        if dice.below(8) == 0 {
            event(&mut dice, &mut desk);
            desk.harness.step();
            done += 1;
        } else if let Some(action) = action(&mut dice, &mut desk, &types) {
            desk.app().act(action, &ctx);
            done += 1;
        }
        if done % 250 == 0 {
            check(desk.app().project().state());
        }
    }
    desk.harness.step();
    check(desk.app().project().state());
    let last = text_of(desk.app().project().state());
    let mut steps = 0;
    while desk.app().project().history().undoable().is_some() {
        desk.app().act(Action::Command(Command::Undo), &ctx);
        steps += 1;
    }
    assert_eq!(text_of(desk.app().project().state()), first, "undone byte for byte");
    for _ in 0..steps {
        desk.app().act(Action::Command(Command::Redo), &ctx);
    }
    assert_eq!(text_of(desk.app().project().state()), last, "done again byte for byte");
    eprintln!("{ACTIONS} actions, {steps} steps of history");
}
