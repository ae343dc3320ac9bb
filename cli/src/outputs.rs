//! The files that a run writes: which, in what format, whether they can be, and writing them.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use breccia_engine::{Exporter, Graph, Registry, Sink, Value};

use crate::exit::{Code, Failure, did_you_mean};
use crate::inputs::Assignment;
use crate::interrupt::Interrupt;

/// An output and the file, or folder, that it goes to.
pub struct Target<'a> {
    /// The output's name in the interface, or `node.socket`.
    pub name: String,
    /// Where it goes.
    pub path: PathBuf,
    /// What writes it.
    exporter: &'a Exporter,
}

/// A file that was written.
#[derive(Debug)]
pub struct Written {
    /// The output.
    pub output: String,
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
}

/// Decides what is written where: the outputs that are asked for, in the format that the extension names; or, if
/// there is a folder or nothing is asked for, every output that a file can hold, in the first format of its type.
///
/// # Errors
/// All outputs and formats that do not exist, and files that two outputs would go to.
pub fn plan<'a>(
    graph: &Graph,
    registry: &'a Registry,
    asked: &[Assignment],
    folder: Option<&Path>,
) -> Result<Vec<Target<'a>>, Failure> {
    let mut targets: Vec<Target<'a>> = Vec::new();
    let mut problems = Vec::new();
    for output in asked {
        match explicit(graph, registry, output) {
            Ok(target) => targets.push(target),
            Err(problem) => problems.push(problem),
        }
    }
    if folder.is_some() || asked.is_empty() {
        for output in graph.outputs() {
            let exporter = exporters(registry, output.ty).find(|e| e.extensions.first() != Some(&"/"));
            let Some((exporter, extension)) = exporter.and_then(|e| Some((e, e.extensions.first()?))) else {
                continue;
            };
            if targets.iter().all(|target| target.name != output.name) {
                let path = folder.unwrap_or(Path::new("")).join(format!("{}.{extension}", output.name));
                targets.push(Target { name: output.name.to_owned(), path, exporter });
            }
        }
        if targets.is_empty() && problems.is_empty() {
            problems.push("the graph has no outputs that a file can hold".to_owned());
        }
    }
    let mut seen = BTreeMap::new();
    for target in &targets {
        if let Some(other) = seen.insert(&target.path, &target.name) {
            let (path, name) = (target.path.display(), &target.name);
            problems.push(format!("outputs `{other}` and `{name}` would both go to `{path}`"));
        }
    }
    if problems.is_empty() { Ok(targets) } else { Err(Failure::usage(problems.join("\n"))) }
}

fn exporters<'a>(registry: &'a Registry, ty: &str) -> impl Iterator<Item = &'a Exporter> {
    registry.exporters().iter().filter(move |exporter| exporter.ty == ty)
}

/// The extensions that an output of this type can be written as.
pub fn extensions(registry: &Registry, ty: &str) -> Vec<&'static str> {
    exporters(registry, ty).flat_map(|exporter| exporter.extensions).copied().collect()
}

fn explicit<'a>(graph: &Graph, registry: &'a Registry, output: &Assignment) -> Result<Target<'a>, String> {
    let Assignment { name, value } = output;
    let ty = output_type(graph, name)?;
    let path = Path::new(value);
    let extension = match path.extension() {
        _ if value.is_empty() => return Err(format!("output `{name}`: no file is named")),
        _ if value.ends_with(['/', std::path::MAIN_SEPARATOR]) => "/".to_owned(),
        extension => extension.map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default(),
    };
    match exporters(registry, ty).find(|exporter| exporter.extensions.contains(&extension.as_str())) {
        Some(exporter) => Ok(Target { name: name.clone(), path: path.to_owned(), exporter }),
        None => {
            let known = extensions(registry, ty);
            let expected = match known.as_slice() {
                [] => format!("values of type {ty} cannot be written to files"),
                _ => format!("expected {} for the type {ty}", listed(&known)),
            };
            let found = match extension.as_str() {
                "" => "no extension".to_owned(),
                "/" => "a folder".to_owned(),
                extension => format!("the extension `{extension}`"),
            };
            Err(format!("output `{name}`: found {found} in `{value}`, {expected}"))
        }
    }
}

fn listed(extensions: &[&str]) -> String {
    let names: Vec<_> = extensions.iter().map(|e| if *e == "/" { "a folder (…/)" } else { *e }).collect();
    match names.as_slice() {
        [one] => (*one).to_owned(),
        _ => format!("one of {}", names.join(", ")),
    }
}

fn output_type(graph: &Graph, name: &str) -> Result<&'static str, String> {
    if let Some(output) = graph.outputs().find(|output| output.name == name) {
        return Ok(output.ty);
    }
    let socket = name.split_once('.').and_then(|(node, socket)| {
        let (_, spec) = graph.nodes().find(|(other, _)| *other == node)?;
        spec.outputs.iter().find(|output| output.name == socket)
    });
    socket.map(|socket| socket.ty).ok_or_else(|| {
        let known: Vec<_> = graph.outputs().map(|output| output.name).collect();
        let hint = did_you_mean(name, known.iter().copied());
        format!("output `{name}`: found no such output, expected one of {}{hint}", known.join(", "))
    })
}

/// Makes sure before anything is computed that the files can be written.
///
/// # Errors
/// Names all files that cannot.
pub fn check(targets: &[Target<'_>]) -> Result<(), Failure> {
    let problems: Vec<_> = targets
        .iter()
        .filter_map(|target| {
            let error = writable(&target.path).err()?;
            Some(format!("output `{}`: cannot write `{}`: {error}", target.name, target.path.display()))
        })
        .collect();
    if problems.is_empty() { Ok(()) } else { Err(Failure::new(Code::Output, problems.join("\n"))) }
}

/// Whether a file, or a folder if the path ends in a slash, can be written there.
///
/// # Errors
/// Why not.
pub fn writable(path: &Path) -> io::Result<()> {
    let wants_folder = path.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]);
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() != wants_folder => {
            let expected = if wants_folder { "it is a file, expected a folder" } else { "it is a folder" };
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, expected));
        }
        _ => {}
    }
    // The nearest folder that exists is where the missing ones, or the file, would be made.
    let mut folder = parent_of(path);
    while !folder.exists() {
        folder = parent_of(&folder);
    }
    tempfile::Builder::new().prefix(".breccia-").tempfile_in(&folder).map(|_| ())
}

fn parent_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Writes the values that are there. All files get their names at the end, together: until then they are in
/// hidden folders beside their targets, which vanish if anything goes wrong.
///
/// # Errors
/// If a file cannot be written, or the user stops.
pub fn write(
    targets: &[Target<'_>],
    values: &BTreeMap<String, Value>,
    interrupt: &Interrupt,
) -> Result<Vec<Written>, Failure> {
    let failed = |target: &Target<'_>, error: io::Error| {
        let (name, path) = (&target.name, target.path.display());
        Failure::new(Code::Output, format!("output `{name}`: cannot write `{path}`: {error}"))
    };
    let mut staged = Vec::new();
    for target in targets {
        let Some(value) = values.get(&target.name) else { continue };
        interrupt.check()?;
        staged.push((target, stage(target, value, interrupt).map_err(|error| failed(target, error))?));
    }
    interrupt.check()?;
    interrupt.publish(|| {
        let mut written = Vec::new();
        for (target, stage) in staged {
            for (file, path) in stage.files {
                let bytes = std::fs::metadata(&file).map_or(0, |metadata| metadata.len());
                std::fs::create_dir_all(parent_of(&path))
                    .and_then(|()| std::fs::rename(&file, &path))
                    .map_err(|error| failed(target, error))?;
                written.push(Written { output: target.name.clone(), path, bytes });
            }
        }
        Ok(written)
    })
}

/// Files that are written but do not have their names yet.
struct Stage {
    /// Each with its final name.
    files: Vec<(PathBuf, PathBuf)>,
    /// Where they are; removed when this goes.
    _folder: tempfile::TempDir,
}

fn stage(target: &Target<'_>, value: &Value, interrupt: &Interrupt) -> io::Result<Stage> {
    let parent = parent_of(&target.path);
    std::fs::create_dir_all(&parent)?;
    let folder = interrupt.stage(&parent)?;
    let name = target.path.file_name().unwrap_or_default();
    let mut inside = folder.path().join(name).into_os_string();
    if target.path.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]) {
        inside.push("/");
    }
    let mut sink = Sink::new(Path::new(&inside))?;
    (target.exporter.write)(value, &mut sink)?;
    let files = sink.commit()?.into_iter().map(|file| {
        let path = file.strip_prefix(folder.path()).map_or_else(|_| target.path.clone(), Path::to_owned);
        (file, if parent == Path::new(".") { path } else { parent.join(path) })
    });
    Ok(Stage { files: files.collect(), _folder: folder })
}
