//! Running the binary in a folder of its own, with settings that make a synthesis fast.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use image::{GrayImage, Rgb, RgbImage};

/// A folder for the files of one test, and for its cache.
pub struct Place(tempfile::TempDir);

/// A synthesis that takes milliseconds.
pub const FAST: [&str; 8] = [
    "--set",
    "exemplar.max_size=32",
    "--set",
    "usage.rounds=0",
    "--set",
    "candidates.strips=8",
    "--set",
    "candidates.best=16",
];

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The names of the files and folders, the cache aside.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|n| n != "cache")
            .collect();
        names.sort();
        names
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.path(name), contents).unwrap();
        self.path(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// A picture of soft spots.
    pub fn picture(&self, name: &str, side: u32) -> PathBuf {
        let level = |x: u32, y: u32| ((x * x * 7 + y * y * 11 + x * y * 5) % 251) as u8;
        RgbImage::from_fn(side, side, |x, y| Rgb([level(x, y), level(y, x), 128]))
            .save(self.path(name))
            .unwrap();
        self.path(name)
    }

    pub fn mask(&self, name: &str, side: u32) -> PathBuf {
        GrayImage::from_fn(side, side, |x, y| image::Luma([if (x / 4 + y / 4) % 2 == 0 { 255 } else { 0 }]))
            .save(self.path(name))
            .unwrap();
        self.path(name)
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_breccia"));
        command.args(args).current_dir(self.0.path()).env("XDG_CACHE_HOME", self.path("cache"));
        command
    }

    /// A command that finds no adapter, whatever the machine has.
    pub fn without_adapters(&self, args: &[&str]) -> Command {
        let mut command = self.command(args);
        let nowhere = self.path("nowhere.json");
        command.env("VK_ICD_FILENAMES", &nowhere).env("VK_DRIVER_FILES", nowhere);
        command
    }

    pub fn breccia(&self, args: &[&str]) -> Answer {
        Answer::from(self.command(args).output().unwrap())
    }

    /// `breccia run GRAPH` with fast settings.
    pub fn run(&self, graph: &str, args: &[&str]) -> Answer {
        self.breccia(&[&["run", graph], &FAST[..], args].concat())
    }
}

/// What the binary answered.
#[derive(Debug)]
pub struct Answer {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Answer {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

impl Answer {
    /// Fails unless the binary ended with this code and said all of this on standard error.
    #[track_caller]
    pub fn expect(&self, code: i32, messages: &[&str]) -> &Self {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        for message in messages {
            assert!(self.stderr.contains(message), "`{message}` is missing in:\n{}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// The events of `--json`, of which nothing else may be on standard output.
    pub fn events(&self) -> Vec<serde_json::Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `NAME=PATH`.
pub fn assign(name: &str, path: &Path) -> String {
    format!("{name}={}", text(path))
}
