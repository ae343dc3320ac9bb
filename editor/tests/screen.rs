//! The real window on a screen that nobody sees (Xvfb), driven by keys (xdotool): starting, editing, saving, and coming back
//! after a crash.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(90);

/// A process that ends with the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

struct Screen {
    display: String,
    _server: Process,
}

fn there(program: &str) -> bool {
    let found = Command::new(program).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok()
}

impl Screen {
    /// A screen; `None` where the programs for it are not there, which fails where tests must have one.
    fn open() -> Option<Self> {
        if !there("Xvfb") || !there("xdotool") {
            let required = std::env::var_os("BRECCIA_REQUIRE_SCREEN").is_some();
            assert!(!required, "Xvfb or xdotool is missing; scripts/setup installs them");
            eprintln!("skipped: the test of the window wants Xvfb and xdotool");
            return None;
        }
        let mut server = Command::new("Xvfb")
            // Between two editors there is nobody; the screen stays all the same.
            .args(["-displayfd", "1", "-noreset", "-screen", "0", "1280x720x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let output = server.stdout.take().expect("its output");
        BufReader::new(output).read_line(&mut number).expect("a number of a display");
        Some(Self { display: format!(":{}", number.trim()), _server: Process(server) })
    }

    fn editor(&self, home: &Path, graph: &Path) -> Process {
        let editor = Command::new(env!("CARGO_BIN_EXE_breccia-editor"))
            .arg("--cache-dir")
            .arg(home.join("cache"))
            .arg(graph)
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_STATE_HOME", home.join("state"))
            .env("XDG_DATA_HOME", home.join("data"))
            .stderr(Stdio::null())
            .spawn()
            .expect("the editor starts");
        Process(editor)
    }

    fn tool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool runs");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// The window whose title holds a text, once there is one.
    fn window(&self, title: &str) -> String {
        let begun = Instant::now();
        loop {
            let found = self.tool(&["search", "--name", title]);
            if let Some(window) = found.lines().next() {
                return window.to_owned();
            }
            let titles = self.tool(&["search", "--name", "Breccia", "getwindowname", "%@"]);
            assert!(begun.elapsed() < PATIENCE, "no window is called {title}, but {titles}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn keys(&self, window: &str, keys: &[&str]) {
        // There is no window manager that would do it, and a window that is not drawn yet takes no keys.
        let begun = Instant::now();
        while self.tool(&["getwindowfocus"]) != window {
            assert!(begun.elapsed() < PATIENCE, "the window takes no keys");
            self.tool(&["windowfocus", window]);
            std::thread::sleep(Duration::from_millis(100));
        }
        std::thread::sleep(Duration::from_millis(500));
        for key in keys {
            self.tool(&["key", key]);
            std::thread::sleep(Duration::from_millis(300));
        }
    }
}

fn copies(home: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(home.join("state/breccia/recovery"));
    let paths = entries
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect::<Vec<_>>())
        .unwrap_or_default();
    paths.into_iter().filter(|path| path.extension().is_some_and(|e| e == "ron")).collect()
}

#[test]
fn a_graph_is_edited_saved_and_recovered_after_a_crash() {
    let Some(screen) = Screen::open() else { return };
    let home = tempfile::tempdir().expect("a folder");
    let graph = home.path().join("plain.ron");
    let text =
        r#"(format: "breccia-graph", version: 2, nodes: {"checker": (type: "solid.checker")}, links: [])"#;
    std::fs::write(&graph, text).expect("a file");

    let mut editor = screen.editor(home.path(), &graph);
    let window = screen.window("^plain.ron - Breccia$");
    screen.keys(&window, &["ctrl+a", "ctrl+d"]);
    let window = screen.window("^[*] plain.ron - Breccia$");
    screen.keys(&window, &["ctrl+s"]);
    let window = screen.window("^plain.ron - Breccia$");
    let saved = std::fs::read_to_string(&graph).expect("a saved graph");
    assert!(saved.contains("checker_2"), "{saved}");

    screen.keys(&window, &["ctrl+a", "ctrl+d"]);
    screen.window("^[*] plain.ron - Breccia$");
    let begun = Instant::now();
    while copies(home.path()).is_empty() {
        assert!(begun.elapsed() < PATIENCE, "no copy is kept of what is not saved");
        std::thread::sleep(Duration::from_millis(100));
    }
    editor.0.kill().expect("a crash");
    editor.0.wait().expect("its end");
    let kept = copies(home.path())
        .iter()
        .map(|path| std::fs::read_to_string(path).expect("a copy"))
        .collect::<String>();
    assert!(kept.contains("checker_4"), "what was not saved is kept: {kept}");
    assert_eq!(std::fs::read_to_string(&graph).expect("the file"), saved, "the file is as it was saved");

    // The next start offers it, and an orderly end leaves nothing of its own behind.
    let _again = screen.editor(home.path(), &graph);
    screen.window("^plain.ron - Breccia$");
    assert_eq!(copies(home.path()).len(), 1);
}
