//! What has been found, one line a cell in `docs/stability/found.jsonl`: the numbers behind the table, and what a map that was
//! interrupted goes on from.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use granary_core::identity::canonical_json;
use granary_core::physics;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::Found;
use super::cells::Cell;

/// Where the map lies.
pub(super) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/stability")
}

#[derive(Serialize, Deserialize)]
struct Line {
    factor: String,
    value: String,
    beam: bool,
    changes: Map<String, Value>,
    /// Version of the physics it was found with.
    physics: u32,
    found: Found,
}

impl Line {
    fn of(cell: &Cell, found: &Found) -> Self {
        Self {
            factor: cell.factor.to_owned(),
            value: cell.value.clone(),
            beam: cell.beam,
            changes: cell.changes.clone(),
            physics: current(cell.beam),
            found: found.clone(),
        }
    }
}

fn current(beam: bool) -> u32 {
    if beam { physics::BEAM } else { physics::RECALL }
}

/// What a cell is known by, in whichever order its changes are written.
fn name(beam: bool, changes: &Map<String, Value>) -> String {
    let sorted: BTreeMap<_, _> = changes.iter().collect();
    canonical_json(&(beam, sorted))
}

/// Cells that have been looked at with this physics. A line that is deleted is looked at again.
pub(super) struct Kept {
    found: BTreeMap<String, Found>,
    file: Mutex<fs::File>,
}

impl Kept {
    pub(super) fn open() -> Self {
        fs::create_dir_all(folder()).expect("a folder to write to");
        let path = folder().join("found.jsonl");
        let text = fs::read_to_string(&path).unwrap_or_default();
        let lines = text
            .lines()
            .filter_map(|line| serde_json::from_str::<Line>(line).ok());
        let found = lines
            .filter(|line| line.physics == current(line.beam))
            .map(|line| (name(line.beam, &line.changes), line.found))
            .collect();
        let file = fs::OpenOptions::new().append(true).create(true).open(path);
        Self {
            found,
            file: Mutex::new(file.expect("a file to write to")),
        }
    }

    /// Whether a cell has been looked at.
    pub(super) fn knows(&self, cell: &Cell) -> bool {
        self.found.contains_key(&name(cell.beam, &cell.changes))
    }

    /// What was found, or `look`.
    pub(super) fn or(&self, cell: &Cell, look: fn(&Map<String, Value>) -> Found) -> Found {
        let name = name(cell.beam, &cell.changes);
        self.found.get(&name).cloned().unwrap_or_else(|| {
            let found = look(&cell.changes);
            let line = canonical_json(&Line::of(cell, &found));
            let mut file = self.file.lock().expect("no one panics with it");
            writeln!(file, "{line}").expect("a file to write to");
            found
        })
    }
}

/// Leaves only these cells, in order.
pub(super) fn rewrite(cells: &[Cell], found: &[Found]) {
    let lines = cells.iter().zip(found);
    let text: String = lines
        .map(|(cell, found)| canonical_json(&Line::of(cell, found)) + "\n")
        .collect();
    fs::write(folder().join("found.jsonl"), text).expect("a file to write to");
}
