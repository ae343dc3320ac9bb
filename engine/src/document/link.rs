//! Links as text: `node.socket -> node.socket`.

use std::fmt;

/// A link from an output to an input.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link {
    /// The node it starts at.
    pub from_node: String,
    /// Its output socket.
    pub from_socket: String,
    /// The node it ends at.
    pub to_node: String,
    /// Its input socket.
    pub to_socket: String,
}

impl Link {
    /// Reads `a.out -> b.in`; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let (from, to) = text.split_once("->")?;
        let (from_node, from_socket) = split_path(from.trim())?;
        let (to_node, to_socket) = split_path(to.trim())?;
        Some(Self {
            from_node: from_node.to_owned(),
            from_socket: from_socket.to_owned(),
            to_node: to_node.to_owned(),
            to_socket: to_socket.to_owned(),
        })
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{} -> {}.{}", self.from_node, self.from_socket, self.to_node, self.to_socket)
    }
}

/// Splits `node.name` into its two names.
pub(crate) fn split_path(path: &str) -> Option<(&str, &str)> {
    let (node, name) = path.split_once('.')?;
    (is_path(node) && is_name(name)).then_some((node, name))
}

/// Whether a text can be the way to a node: a name, or names of groups and zones before it, such as `zone[3]/node`.
fn is_path(path: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '/' | '[' | ']' | '=');
    !path.is_empty() && path.chars().all(plain)
}

/// Whether a text can name a node, socket or parameter.
pub(crate) fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-'))
}

/// Brings links into canonical form: evenly spaced, sorted by where they end. The order of links into
/// the same socket means something and stays.
pub(super) fn sort(links: &mut [String]) {
    for link in links.iter_mut() {
        if let Some(parsed) = Link::parse(link) {
            *link = parsed.to_string();
        }
    }
    links.sort_by_cached_key(|link| match Link::parse(link) {
        Some(parsed) => (false, parsed.to_node, parsed.to_socket),
        None => (true, String::new(), String::new()),
    });
}
