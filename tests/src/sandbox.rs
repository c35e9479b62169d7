//! A directory of its own for each test, and commands that run in it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::process::Process;

/// The binary under test, built from the present sources with the profile of the tests.
///
/// # Panics
/// If it cannot be built.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        let mut build = Command::new(env!("CARGO"));
        build.args([
            "build",
            "--quiet",
            "--package",
            "granary",
            "--bin",
            "granary",
        ]);
        if !cfg!(debug_assertions) {
            build.arg("--release");
        }
        let built = build.current_dir(env!("CARGO_MANIFEST_DIR")).status();
        assert!(built.expect("cargo starts").success(), "granary builds");
        let tests = std::env::current_exe().expect("a test has a path");
        let profile = tests.ancestors().nth(2).expect("…/profile/deps/test");
        profile.join("granary")
    })
}

/// How a command ended.
#[derive(Debug)]
pub struct Finished {
    /// Its exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// What machines read.
    pub stdout: String,
    /// What people read.
    pub stderr: String,
}

impl Finished {
    /// Standard output as JSON.
    ///
    /// # Panics
    /// If it is not JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error} in {self:#?}"))
    }

    /// This, if its exit code is `code`.
    ///
    /// # Panics
    /// If it is another.
    #[must_use]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }
}

/// A directory for one test.
#[derive(Debug)]
pub struct Sandbox {
    directory: TempDir,
}

impl Default for Sandbox {
    fn default() -> Self {
        Self::new()
    }
}

impl Sandbox {
    /// An empty directory.
    ///
    /// # Panics
    /// If there is no room for temporary files.
    #[must_use]
    pub fn new() -> Self {
        Self {
            directory: TempDir::new().expect("a temporary directory"),
        }
    }

    /// The path of `name` in it.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Writes a file.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }

    /// `granary` with these arguments, ready to start here, deaf to this machine's settings.
    #[must_use]
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(binary());
        command
            .args(arguments)
            .current_dir(self.directory.path())
            .stdin(Stdio::null());
        for (name, _) in std::env::vars().filter(|(name, _)| name.starts_with("GRANARY_")) {
            command.env_remove(name);
        }
        command
    }

    /// Runs a command to its end.
    ///
    /// # Panics
    /// If it does not start.
    #[must_use]
    pub fn run(&self, arguments: &[&str]) -> Finished {
        let output = self.command(arguments).output().expect("granary starts");
        Finished {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Starts a command that runs until it is stopped.
    #[must_use]
    pub fn start(&self, arguments: &[&str]) -> Process {
        Process::start(self.command(arguments))
    }

    /// Starts a server on a free port, with `arguments` besides; and its address.
    ///
    /// # Panics
    /// If it does not come up.
    #[must_use]
    pub fn serve(&self, arguments: &[&str]) -> (Process, String) {
        let mut all = vec!["serve"];
        if !arguments.contains(&"--listen") {
            all.extend(["--listen", "127.0.0.1:0"]);
        }
        all.extend(arguments);
        let mut server = self.start(&all);
        let line = server.line_with("serves at");
        let address = line.split_whitespace().last().expect("an address");
        (server, address.to_owned())
    }
}

/// A sweep of `grains` grains, done in a moment: `waveforms` as TOML, packs with the seeds of `seeds`.
#[must_use]
pub fn tiny(grains: u32, seeds: &str, waveforms: &str) -> String {
    format!(
        "name = \"tiny\"
model = \"memory\"
[fixed]
grains = {grains}
[numerics]
ramp = 150.0
second_cycle = false
[preparation]
gas_time = 50.0
preparation_cycles = 1
preparation_ramp = 255.0
rest_kinetic_energy = 1e-4
[[grid]]
packing_seed = {seeds}
waveform = {waveforms}
"
    )
}
