//! The dependency table of ARCHITECTURE.md, read from `cargo metadata`: each crate exists, and no
//! path of normal or build dependencies joins a forbidden pair.

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};

/// Crate, the Struna crates it may name, and what it must never reach by any path.
///
/// "struna-" is left out of names; `*` forbids every Struna crate.
const TABLE: &[(&str, &[&str], &[&str])] = &[
    ("kernel", &[], &["*"]),
    ("settings", &[], &["*"]),
    ("body", &["kernel"], &["gyro", "line", "wire", "estimator"]),
    ("gyro", &["kernel", "settings"], &["body", "line", "wire", "estimator"]),
    ("line", &["kernel"], &["body", "gyro", "wire", "estimator"]),
    ("wire", &["settings"], &["kernel", "body", "gyro", "line", "estimator"]),
    ("sniff", &["wire", "settings"], &["kernel", "body", "gyro", "line", "estimator", "harness"]),
    ("estimator", &["kernel"], &["body", "gyro", "wire", "line", "harness", "settings"]),
    ("fmi-export", &["kernel"], &["estimator", "body", "gyro", "wire", "line"]),
    ("fmi-import", &["kernel"], &["estimator", "body", "gyro", "wire", "line", "fmi-export"]),
    (
        "fmu-library",
        &["estimator", "body", "gyro", "fmi-export", "kernel"],
        &["wire", "line", "harness", "fmi-import", "settings"],
    ),
    (
        "harness",
        &["kernel", "body", "gyro", "wire", "line", "fmi-import"],
        &["estimator", "fmi-export", "fmu-library"],
    ),
];

/// Outside crates that only one Struna crate may name, because they are a border.
const BORDERS: &[(&str, &str)] = &[
    ("fmi", "struna-fmi-import"),
    ("serialport", "struna-line"),
    ("rustix", "struna-line"),
    ("rand_chacha", "struna-kernel"),
    ("rapier3d-f64", "struna-body"),
    ("plotters", "struna"),
    ("clap", "struna"),
];

struct Graph {
    /// Normal and build dependencies of each workspace crate, by name.
    edges: BTreeMap<String, BTreeSet<String>>,
}

impl Graph {
    fn of(metadata: &Metadata) -> Self {
        let mut edges = BTreeMap::new();
        for package in metadata.workspace_packages() {
            let named = package
                .dependencies
                .iter()
                .filter(|dependency| dependency.kind != DependencyKind::Development)
                .map(|dependency| dependency.name.clone());
            edges.insert(package.name.to_string(), named.collect());
        }
        Self { edges }
    }

    fn struna_edges(&self, package: &str) -> BTreeSet<&str> {
        self.edges[package].iter().filter_map(|name| name.strip_prefix("struna-")).collect()
    }

    fn reachable(&self, package: &str) -> BTreeSet<&str> {
        let mut seen = BTreeSet::new();
        let mut open: Vec<&str> = self.struna_edges(package).into_iter().collect();
        while let Some(next) = open.pop() {
            if seen.insert(next) {
                open.extend(self.struna_edges(&format!("struna-{next}")));
            }
        }
        seen
    }
}

fn graph() -> Graph {
    let metadata = MetadataCommand::new().no_deps().exec().expect("cargo metadata runs");
    Graph::of(&metadata)
}

#[test]
fn every_crate_of_the_table_exists_and_no_other() {
    let graph = graph();
    let table: BTreeSet<String> =
        TABLE.iter().map(|(name, ..)| format!("struna-{name}")).chain(["struna".into()]).collect();
    let workspace: BTreeSet<String> = graph.edges.keys().cloned().collect();
    assert_eq!(workspace, table);
}

#[test]
fn crates_name_only_what_the_table_allows() {
    let graph = graph();
    for (name, allowed, _) in TABLE {
        let allowed: BTreeSet<&str> = allowed.iter().copied().collect();
        let named = graph.struna_edges(&format!("struna-{name}"));
        let extra: Vec<_> = named.difference(&allowed).collect();
        assert!(extra.is_empty(), "struna-{name} names {extra:?}, the table allows {allowed:?}");
    }
}

#[test]
fn no_path_joins_a_forbidden_pair() {
    let graph = graph();
    for (name, _, forbidden) in TABLE {
        let reached = graph.reachable(&format!("struna-{name}"));
        for forbidden in *forbidden {
            let found =
                if *forbidden == "*" { !reached.is_empty() } else { reached.contains(forbidden) };
            assert!(!found, "struna-{name} reaches {forbidden} through {reached:?}");
        }
    }
}

#[test]
fn each_border_is_crossed_in_one_crate_only() {
    let graph = graph();
    for (outside, keeper) in BORDERS {
        for (package, named) in &graph.edges {
            let crosses = named.contains(*outside);
            assert!(!crosses || package == keeper, "{package} names {outside}, kept by {keeper}");
        }
        assert!(graph.edges[*keeper].contains(*outside), "{keeper} no longer names {outside}");
    }
}
