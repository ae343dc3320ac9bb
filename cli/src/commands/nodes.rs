//! `breccia nodes`.

use breccia_engine::{Registry, describe, markdown, plain};

use crate::exit::{Code, Failure, did_you_mean};

/// List the node types, or describe one: its sockets and parameters.
#[derive(clap::Args)]
pub struct Nodes {
    /// The node type to describe
    id: Option<String>,

    /// Print JSON
    #[arg(long, conflicts_with = "markdown")]
    json: bool,

    /// Print Markdown; without ID the whole reference
    #[arg(long)]
    markdown: bool,
}

impl Nodes {
    /// Prints the list, the description or the reference.
    pub fn run(&self) -> Result<(), Failure> {
        let registry = breccia_nodes::registry();
        let text = match &self.id {
            None if self.json => {
                json(&registry.nodes().map(|node| describe(&node.spec)).collect::<Vec<_>>())?
            }
            None if self.markdown => reference(&registry),
            None => list(&registry),
            Some(id) => {
                let node = registry.node(id).ok_or_else(|| {
                    let hint = did_you_mean(id, registry.nodes().map(|node| node.spec.id));
                    Failure::usage(format!(
                        "found no node type `{id}`, expected one that `breccia nodes` lists{hint}"
                    ))
                })?;
                if self.json {
                    json(&describe(&node.spec))?
                } else if self.markdown {
                    markdown(&node.spec)
                } else {
                    plain(&node.spec)
                }
            }
        };
        super::answer(&text)
    }
}

fn json(value: &impl serde::Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value);
    text.map(|text| text + "\n").map_err(|error| Failure::new(Code::Output, error.to_string()))
}

fn list(registry: &Registry) -> String {
    let width = registry.nodes().map(|node| node.spec.id.len()).max().unwrap_or(0);
    let line = |node: &breccia_engine::NodeSpec| format!("{:width$}  {}\n", node.id, node.summary);
    let nodes: String = registry.nodes().map(|node| line(&node.spec)).collect();
    nodes + "\n`breccia nodes ID` describes one.\n"
}

/// The reference of all node types, socket types and file formats.
fn reference(registry: &Registry) -> String {
    let mut out = String::from(
        "# Node reference\n\nWritten by `breccia nodes --markdown` from what the nodes say of themselves; not to be \
         edited by hand.\n",
    );
    out.push_str("\n| Node | |\n|---|---|\n");
    for node in registry.nodes() {
        let anchor: String = node.spec.id.chars().filter(|c| *c != '.').collect();
        out.push_str(&format!("| [`{}`](#{anchor}) | {} |\n", node.spec.id, node.spec.summary));
    }
    for node in registry.nodes() {
        out.push('\n');
        out.push_str(&markdown(&node.spec));
    }
    out.push_str("\n## Socket types\n\n| Type | |\n|---|---|\n");
    for ty in registry.types() {
        out.push_str(&format!("| {} | {} |\n", ty.name, ty.docs));
    }
    out.push_str("\n## File formats of outputs\n\n| Type | Extension | |\n|---|---|---|\n");
    for exporter in registry.exporters() {
        let names: Vec<_> = exporter
            .extensions
            .iter()
            .map(|e| if *e == "/" { "folder (a final `/`)".to_owned() } else { format!("`.{e}`") })
            .collect();
        out.push_str(&format!("| {} | {} | {} |\n", exporter.ty, names.join(", "), exporter.docs));
    }
    out
}
