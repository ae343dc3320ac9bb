//! Exporters write a value to files; a [`Sink`] makes sure that all of them appear, or none.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use crate::value::Value;

/// Writes values of one socket type in one file format.
#[derive(Clone, Copy)]
pub struct Exporter {
    /// The socket type it takes.
    pub ty: &'static str,
    /// Extensions in lower case and without the dot; `"/"` stands for a folder (a path that ends in a slash).
    pub extensions: &'static [&'static str],
    /// What the files hold, in one line.
    pub docs: &'static str,
    /// Writes the value. The error says what went wrong with the value or the file.
    pub write: fn(&Value, &mut Sink) -> io::Result<()>,
}

/// Where an exporter writes: files with temporary names beside their final ones, renamed together by
/// [`Sink::commit`] and removed if the sink is dropped before.
pub struct Sink {
    target: PathBuf,
    written: Vec<(tempfile::TempPath, PathBuf)>,
    folder: Option<tempfile::TempDir>,
}

impl Sink {
    /// A sink for a file, or for a folder if `target` ends in a slash.
    ///
    /// # Errors
    /// If the folder that is to hold the target cannot be made.
    pub fn new(target: &Path) -> io::Result<Self> {
        let is_folder = target.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]);
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        std::fs::create_dir_all(&parent)?;
        let folder = if is_folder { Some(tempfile::tempdir_in(&parent)?) } else { None };
        Ok(Self { target: target.to_owned(), written: Vec::new(), folder })
    }

    /// The path that was asked for.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// The target's extension in lower case, or `""`.
    pub fn extension(&self) -> String {
        self.target.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
    }

    /// The target's name without folder and extension.
    pub fn stem(&self) -> String {
        self.target.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Opens the target itself for writing.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn main(&mut self) -> io::Result<BufWriter<File>> {
        let path = self.target.clone();
        self.open(path)
    }

    /// Opens a file beside the target, or inside the target if that is a folder.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn file(&mut self, name: &str) -> io::Result<BufWriter<File>> {
        if let Some(folder) = &self.folder {
            return Ok(BufWriter::new(File::create(folder.path().join(name))?));
        }
        let path = self.target.with_file_name(name);
        self.open(path)
    }

    fn open(&mut self, path: PathBuf) -> io::Result<BufWriter<File>> {
        let parent = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".breccia-");
        // Temporary files are private, outputs are not: the umask decides, as for any new file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let (file, temporary) = builder.tempfile_in(parent)?.into_parts();
        self.written.push((temporary, path));
        Ok(BufWriter::new(file))
    }

    /// Gives every file its final name and returns those names.
    ///
    /// # Errors
    /// If a file cannot be renamed; files renamed before it stay.
    pub fn commit(mut self) -> io::Result<Vec<PathBuf>> {
        let mut names = Vec::new();
        if let Some(folder) = self.folder.take() {
            std::fs::create_dir_all(&self.target)?;
            let mut entries = std::fs::read_dir(folder.path())?.collect::<io::Result<Vec<_>>>()?;
            entries.sort_by_key(std::fs::DirEntry::file_name);
            for entry in entries {
                let path = self.target.join(entry.file_name());
                std::fs::rename(entry.path(), &path)?;
                names.push(path);
            }
        }
        for (temporary, path) in self.written.drain(..) {
            temporary.persist(&path).map_err(|error| error.error)?;
            names.push(path);
        }
        Ok(names)
    }
}
