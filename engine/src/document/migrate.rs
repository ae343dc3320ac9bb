//! Brings documents of earlier versions to the current one, tree to tree, one version at a time.

use ron::Value;

use super::{DocumentError, VERSION};

type Migration = fn(&mut ron::value::Map) -> Result<(), String>;

/// `MIGRATIONS[v]` turns version `v` into version `v + 1`.
const MIGRATIONS: [Migration; VERSION as usize] = [links_from_tuples, nothing];

pub(super) fn to_current(tree: Value, version: u32) -> Result<Value, DocumentError> {
    let fail = |message: String| DocumentError::Structure { version, message };
    let Value::Map(mut map) = tree else { return Err(fail("the document is no struct".into())) };
    for migration in MIGRATIONS.iter().skip(version as usize) {
        migration(&mut map).map_err(fail)?;
    }
    map.insert("version", VERSION);
    Ok(Value::Map(map))
}

/// Version 0 wrote a link as `("a", "out", "b", "in")`; version 1 writes `"a.out -> b.in"`.
fn links_from_tuples(map: &mut ron::value::Map) -> Result<(), String> {
    let Some(Value::Seq(links)) = map.get_mut(&Value::String("links".into())) else { return Ok(()) };
    for (i, link) in links.iter_mut().enumerate() {
        let Value::Seq(parts) = &*link else {
            return Err(format!("link {i} is no tuple of four names"));
        };
        let [Value::String(a), Value::String(out), Value::String(b), Value::String(input)] = parts.as_slice()
        else {
            return Err(format!("link {i} is no tuple of four names"));
        };
        *link = Value::String(format!("{a}.{out} -> {b}.{input}"));
    }
    Ok(())
}

/// Version 2 adds groups and inputs that go to sockets.
fn nothing(_: &mut ron::value::Map) -> Result<(), String> {
    Ok(())
}
