//! A document and its layouts, apart; together they are one file.

use std::collections::BTreeMap;

use breccia_engine::Document;
use ron::Value;

use super::layout::Layout;
use super::level::Address;

/// The entry of the section `editor` that holds the layouts.
const LAYOUTS: &str = "layouts";

/// All that can be edited.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The document; its section `editor` holds only what is not a layout.
    pub document: Document,
    /// The layouts by the address of their graph: `` for the document's own, `outer/inner` for groups.
    pub layouts: BTreeMap<String, Layout>,
}

impl Default for State {
    fn default() -> Self {
        Self::new(Document::default())
    }
}

impl State {
    /// Takes a document apart. Layouts that cannot be read are dropped: nothing that runs hangs on them.
    pub fn new(mut document: Document) -> Self {
        let mut layouts = BTreeMap::new();
        if let Value::Map(map) = &mut document.editor {
            let key = Value::String(LAYOUTS.to_owned());
            if let Some(Value::Map(found)) = map.remove(&key) {
                for (address, layout) in found {
                    if let (Value::String(address), Ok(layout)) = (address, layout.into_rust::<Layout>()) {
                        layouts.insert(address, layout);
                    }
                }
            }
            if map.is_empty() {
                document.editor = Value::Unit;
            }
        }
        Self { document, layouts }
    }

    /// The document with its layouts, as it is written.
    pub fn to_document(&self) -> Document {
        let mut document = self.document.clone();
        let layouts = self
            .layouts
            .iter()
            .filter(|(_, layout)| !layout.is_empty())
            .filter_map(|(address, layout)| {
                let text = ron::to_string(layout).ok()?;
                let value: Value = text.parse().ok()?;
                Some::<(Value, Value)>((Value::String(address.clone()), value))
            })
            .collect::<ron::Map>();
        if !layouts.is_empty() {
            let mut map = match document.editor {
                Value::Map(map) => map,
                _ => ron::Map::new(),
            };
            map.insert(Value::String(LAYOUTS.to_owned()), Value::Map(layouts));
            document.editor = Value::Map(map);
        }
        document
    }

    /// The layout of a graph.
    pub fn layout(&self, at: &Address) -> Option<&Layout> {
        self.layouts.get(&at.text())
    }

    /// The layout of a graph, made if there is none.
    pub fn layout_mut(&mut self, at: &Address) -> &mut Layout {
        self.layouts.entry(at.text()).or_default()
    }
}
