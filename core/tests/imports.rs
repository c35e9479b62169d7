//! Modules import only from those before them and nothing from outside, and ARCHITECTURE.md names only files that exist.
//!
//! Source: the reading order of `lib.rs`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules by level; `true` where one may import those that stand before it on its own level.
///
/// The others on a level are strangers: a contact law never sees the neighbor list, nor the list a law.
const LEVELS: [(bool, &[&str]); 11] = [
    (
        true,
        &[
            "crew",
            "identity",
            "outcome",
            "parameter",
            "physics",
            "lanes",
            "math",
            "random",
            "study",
        ],
    ),
    (false, &["material", "shape"]),
    (false, &["grains"]),
    (false, &["contact", "neighbor"]),
    (false, &["force", "membrane", "state_file", "wall"]),
    (false, &["scene"]),
    (true, &["observable", "guard"]),
    (false, &["protocol"]),
    (false, &["beam", "memory"]),
    (false, &["bench", "stage"]),
    (false, &["model"]),
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("core stands in the repository")
        .to_owned()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Every Rust file under `folder`.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = vec![];
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Level and place of a module.
fn place(module: &str) -> (usize, usize) {
    let found = LEVELS.iter().enumerate().find_map(|(level, (_, names))| {
        let place = names.iter().position(|name| *name == module)?;
        Some((level, place))
    });
    found.unwrap_or_else(|| panic!("module `{module}` has no level: give it one in this test"))
}

fn may_import(importer: &str, imported: &str) -> bool {
    let (from, to) = (place(importer), place(imported));
    to.0 < from.0 || importer == imported || (to.0 == from.0 && LEVELS[to.0].0 && to.1 < from.1)
}

/// The modules named after `crate::` in the code; comments and unit tests are left out.
fn imports(code: &str) -> BTreeSet<String> {
    let tests = code.find("#[cfg(test)]\nmod tests {");
    let code: String = code[..tests.unwrap_or(code.len())]
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| [line, "\n"])
        .collect();
    let name = |text: &str| -> String {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            // `use crate::{a::…, b}`: every first word between the outer braces.
            Some(list) => {
                let mut depth = 1;
                let mut start = true;
                for (at, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        ',' if depth == 1 => start = true,
                        _ if start && c.is_alphabetic() => {
                            found.insert(name(&list[at..]));
                            start = false;
                        }
                        _ => {}
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
            None => {
                found.insert(name(rest));
            }
        }
    }
    // Constants of the crate itself, such as its physics version.
    found.retain(|name| name.chars().any(char::is_lowercase));
    found
}

#[test]
fn the_reader_of_imports_sees_all_of_them() {
    let code = "use crate::{lanes::{Lane, Row}, math, wall::Walls};\nlet x = crate::stage::run(crate::PHYSICS_VERSION);\n\
                // use crate::memory;\nuse crate::scene::Scene;\n#[cfg(test)]\nmod tests {\n    use crate::bench::Bench;\n}";
    let found: Vec<String> = imports(code).into_iter().collect();
    assert_eq!(found, ["lanes", "math", "scene", "stage", "wall"]);
}

#[test]
fn modules_import_only_from_those_before_them() {
    let source = repository().join("core/src");
    let mut wrong = vec![];
    for file in sources(&source) {
        let inside = file.strip_prefix(&source).expect("under core/src");
        let first = inside.iter().next().expect("a name");
        let module = Path::new(first).file_stem().expect("a name");
        let module = module.to_str().expect("plain text");
        if module == "lib" {
            continue;
        }
        for imported in imports(&read(&file)) {
            if !may_import(module, &imported) {
                wrong.push(format!("{} imports `{imported}`", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_engine_reaches_for_nothing_outside_and_keeps_nothing_global() {
    let forbidden = [
        "std::env",
        "std::fs",
        "std::io",
        "std::net",
        "std::process",
        "std::thread",
        "std::time",
        "thread_local!",
        "static mut ",
        "LazyLock",
        "OnceLock",
    ];
    for file in sources(&repository().join("core/src")) {
        let code = read(&file);
        // A crew is threads that know whose they are, and how long they were at work; no result can depend on it.
        let of_crews = ["std::thread", "std::time", "thread_local!"];
        let crew = file.ends_with("core/src/crew.rs");
        let found: Vec<_> = forbidden
            .iter()
            .filter(|word| code.contains(**word) && !(crew && of_crews.contains(word)))
            .collect();
        assert!(found.is_empty(), "{} names {found:?}", file.display());
    }
}

#[test]
fn the_library_lists_its_modules_in_reading_order() {
    let library = read(&repository().join("core/src/lib.rs"));
    let listed: Vec<&str> = library
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    let expected: Vec<&str> = LEVELS
        .iter()
        .flat_map(|(_, names)| names.iter().copied())
        .collect();
    assert_eq!(listed, expected);
}

/// The texts between backticks that look like paths of this repository, braces written out.
fn paths(text: &str) -> Vec<String> {
    let mut found = vec![];
    for code in text.split('`').skip(1).step_by(2) {
        let plain = |c: char| c.is_alphanumeric() || "._-/{},* ".contains(c);
        let file = [".rs", ".md", ".toml", ".json", ".yml", ".sql"]
            .iter()
            .any(|ending| code.ends_with(ending));
        // Routes begin with a slash, commands and types have other signs in them.
        if !code.starts_with('/') && code.chars().all(plain) && (code.contains('/') || file) {
            // What has a blank outside of braces is a request or a command.
            found.extend(spelled(code).into_iter().filter(|path| !path.contains(' ')));
        }
    }
    found
}

/// `a/{b, c}.rs` as `a/b.rs` and `a/c.rs`.
fn spelled(path: &str) -> Vec<String> {
    let Some((head, rest)) = path.split_once('{') else {
        return vec![path.to_owned()];
    };
    let (list, tail) = rest.split_once('}').expect("a closing brace");
    list.split(',')
        .flat_map(|part| spelled(&format!("{head}{}{tail}", part.trim())))
        .collect()
}

/// A path may start at the root or, in a crate's own paragraph, at that crate's sources.
#[test]
fn every_path_in_the_architecture_exists() {
    let root = repository();
    let missing: Vec<String> = paths(&read(&root.join("ARCHITECTURE.md")))
        .into_iter()
        .filter(|path| {
            // A path with a star stands for the files in its folder.
            let folder = path.split('*').next().unwrap_or(path);
            let crates = ["core/src", "api/src", "server/src", "worker/src", "cli/src"];
            let mut places = crates.iter().map(|source| root.join(source));
            !root.join(folder).exists() && !places.any(|source| source.join(folder).exists())
        })
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn the_reader_of_paths_spells_braces_out() {
    let text = "`core/src/lanes/{portable, avx2}.rs`, `Lane::mul_add`, `/api/v1/sweeps`, `POST /sweeps` and `clippy.toml`";
    let expected = [
        "core/src/lanes/portable.rs",
        "core/src/lanes/avx2.rs",
        "clippy.toml",
    ];
    assert_eq!(paths(text), expected);
}
