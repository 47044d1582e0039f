//! The figures as tables.

use crate::metadata;
use crate::table::{Column, Table};
use saarcor_paper::figure3::Graph;
use saarcor_paper::fit::{Fits, Relation};
use saarcor_paper::reproduction::{Extent, Reproduction};
use saarcor_paper::table1::SceneRow;
use saarcor_paper::table2::{HotSpot, Shape, Variation};
use saarcor_paper::tables::{MB, Table2Row, VirtualRun, mb};
use saarcor_studies::simulate::TimingRow;
use saarcor_studies::walk::FrameRow;

/// The tables of a section, with their captions.
type Captioned = Vec<(String, Table)>;

/// The tables of the report by sections of the page: metadata, scenes, walks, chip.
pub fn sections(report: &Reproduction) -> [Captioned; 4] {
    let with_cuts = (!report.cuts.is_empty()).then(|| {
        let caption = "Frames after a cut of the camera in the place of hot spots: relations within the rows";
        (caption.to_owned(), cut_table(&report.cuts))
    });
    let table2 = table2_tables(&report.table2)
        .into_iter()
        .chain([(
            "How far the relations A / no VM, B / no VM and Mem B / A are off, by the geometric mean"
                .to_owned(),
            fit_table(&report.fit),
        )])
        .chain(with_cuts)
        .chain([(
            "Table 2's hot spots with other lines, fewer ways and without hash (version A)".to_owned(),
            variation_table(&report.variations),
        )]);
    [
        vec![("Metadata of 16 MB (§3)".to_owned(), metadata::table(&report.metadata))],
        vec![
            ("Table 1: the scenes, ours beside the paper's".to_owned(), table1_beside(&report.table1)),
            ("Bytes a triangle, ours by region of the image".to_owned(), bytes_a_triangle(&report.table1)),
        ],
        vec![(
            format!("Figure 3: extremes and hot spots of the walks ({})", how(report)),
            extremes(&report.figure3),
        )],
        table2.collect(),
    ]
}

/// How the walks were made.
fn how(report: &Reproduction) -> String {
    let (width, height) = report.resolution;
    let frames = if report.extent == Extent::All { "all frames" } else { "some frames" };
    format!("{width} × {height} pixels, {frames}")
}

/// Table 1: ours | the paper's.
fn table1_beside(rows: &[SceneRow]) -> Table {
    let numbers = ["triangles", "paper", "lights", "paper", "geometry MB", "paper", "textures MB", "paper"];
    let mut table = Table::new(std::iter::once(Column::text("scene")).chain(numbers.map(Column::number)));
    for row in rows {
        let textures = |mb: Option<String>| mb.unwrap_or_else(|| "–".to_owned());
        table.row([
            row.scene.clone(),
            row.triangles.to_string(),
            row.paper_triangles.to_string(),
            row.lights.to_string(),
            row.paper_lights.to_string(),
            mb(row.geometry_bytes),
            row.paper_geometry_mb.to_string(),
            textures((row.texture_bytes > 0).then(|| mb(row.texture_bytes))),
            textures(row.paper_textures_mb.map(|mb| mb.to_string())),
        ]);
    }
    table
}

/// Bytes a triangle, ours by region.
fn bytes_a_triangle(rows: &[SceneRow]) -> Table {
    let regions = rows.first().map_or(&[][..], |row| &row.regions).iter().map(|region| region.region);
    let names = regions.chain(["geometry", "paper"]).map(Column::number);
    let mut table = Table::new(std::iter::once(Column::text("scene")).chain(names));
    for row in rows {
        let each = |bytes: f64| format!("{bytes:.1}");
        let paper = (row.paper_geometry_mb << 20) as f64 / row.paper_triangles as f64;
        let ours = row.geometry_bytes as f64 / row.triangles as f64;
        let cells = row.regions.iter().map(|region| region.bytes_a_triangle).chain([ours, paper]);
        table.row(std::iter::once(row.scene.clone()).chain(cells.map(each)));
    }
    table
}

/// The extremes of the graphs.
fn extremes(graphs: &[Graph]) -> Table {
    let numbers = [
        "on-board MB",
        "frames",
        "largest working set MB",
        "in frame",
        "most transferred MB",
        "in frame",
        "most collisions",
        "in frame",
        "transferred MB a frame",
    ];
    let columns = std::iter::once(Column::text("scene")).chain(numbers.map(Column::number));
    let mut table = Table::new(columns.chain(["hot spots", "cuts before"].map(Column::text)));
    for graph in graphs {
        let cells = |peak: Option<&FrameRow>, value: &dyn Fn(&FrameRow) -> String| match peak {
            Some(row) => [value(row), row.frame.to_string()],
            None => ["–".to_owned(), "–".to_owned()],
        };
        let all: u64 = graph.frames.iter().map(|row| row.loaded_bytes).sum();
        let working_set = cells(graph.peak(|row| row.working_set_bytes), &|row| mb(row.working_set_bytes));
        let loaded = cells(graph.peak(|row| row.loaded_bytes), &|row| mb(row.loaded_bytes));
        let collisions = cells(graph.peak(|row| row.collisions), &|row| row.collisions.to_string());
        let first = [graph.name.clone(), mb(graph.memory_bytes), graph.frames.len().to_string()];
        let last = mb(all / graph.frames.len().max(1) as u64);
        let frames = |frames: &mut dyn Iterator<Item = usize>| {
            let frames: Vec<_> = frames.map(|frame| frame.to_string()).collect();
            if frames.is_empty() { "–".to_owned() } else { frames.join(", ") }
        };
        let hot_spots = frames(&mut graph.hot_spots.iter().map(|spot| spot.frame));
        let cuts = frames(&mut graph.cuts.iter().copied());
        let row = first.into_iter().chain(working_set).chain(loaded).chain(collisions);
        table.row(row.chain([last, hot_spots, cuts]));
    }
    table
}

fn in_mb(bytes: u64) -> f64 {
    bytes as f64 / MB as f64
}

/// A ratio for a reader; nothing, where a number is divided by nothing.
fn ratio(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "–".to_owned() }
}

/// Columns that name a row.
fn names() -> impl Iterator<Item = Column> {
    ["scene", "frame", "ours"].map(Column::text).into_iter()
}

fn name(spot: &HotSpot) -> impl Iterator<Item = String> {
    let HotSpot { scene, frame, paper, .. } = spot;
    [paper.scene.clone(), paper.frame.clone(), format!("{scene} {frame}")].into_iter()
}

/// Ours, the paper's, and their ratio.
fn beside(ours: f64, paper: f64, digits: usize) -> [String; 3] {
    [format!("{ours:.digits$}"), format!("{paper:.digits$}"), ratio(ours / paper)]
}

/// Table 2, a table a version, and the relations within the rows.
fn table2_tables(spots: &[HotSpot]) -> Vec<(String, Table)> {
    let figure = |name: &str| [name, "paper", "ratio"].map(Column::number);
    let table = |figures: &[&str]| Table::new(names().chain(figures.iter().flat_map(|name| figure(name))));
    let mut no_vm = Table::new(
        names().chain(figure("fps")).chain(figure("Mem MB")).chain([Column::number("cycles a ray")]),
    );
    let (mut a, mut b) = (table(&["fps", "PCI MB", "Mem MB"]), table(&["fps", "PCI MB", "Mem MB"]));
    for spot in spots {
        let Table2Row { no_vm: paper, version_a, version_b, .. } = &spot.paper;
        let run = &spot.no_vm;
        let cells = beside(run.fps, paper.fps, 1)
            .into_iter()
            .chain(beside(in_mb(run.mem_bytes), paper.mem_mb, 1))
            .chain([format!("{:.1}", run.cycles_a_ray)]);
        no_vm.row(name(spot).chain(cells));
        let with_vm = |table: &mut Table, run: &TimingRow, paper: &VirtualRun| {
            let cells = beside(run.fps, paper.fps, 1)
                .into_iter()
                .chain(beside(in_mb(run.pci_bytes), paper.pci_mb, 2))
                .chain(beside(in_mb(run.mem_bytes), paper.mem_mb, 1));
            table.row(name(spot).chain(cells));
        };
        with_vm(&mut a, &spot.version_a, version_a);
        with_vm(&mut b, &spot.version_b, version_b);
    }
    vec![
        ("Table 2: hot spots without virtual memory".to_owned(), no_vm),
        ("Table 2: version A, metadata on the chip".to_owned(), a),
        ("Table 2: version B, metadata in the on-board memory".to_owned(), b),
        ("Table 2: relations within its rows".to_owned(), shapes(spots)),
    ]
}

/// The relations, ours and the paper's.
fn shapes(spots: &[HotSpot]) -> Table {
    let relations = ["A / no VM", "B / no VM", "Mem B / A", "(Mem A - no VM) / PCI"];
    let columns = relations.iter().flat_map(|name| [*name, "paper"]).map(Column::number);
    let mut table = Table::new(names().chain(columns));
    for spot in spots {
        let (ours, paper) = (Shape::ours(spot), Shape::printed(&spot.paper));
        let pairs = [
            (ours.speed_a, paper.speed_a),
            (ours.speed_b, paper.speed_b),
            (ours.memory_b, paper.memory_b),
            (ours.filled, paper.filled),
        ];
        table.row(name(spot).chain(pairs.into_iter().flat_map(|(ours, paper)| [ratio(ours), ratio(paper)])));
    }
    table
}

/// The relations of frames after a cut, and what a faster bus gains there.
fn cut_table(spots: &[HotSpot]) -> Table {
    let numbers = ["A / no VM", "paper", "B / no VM", "paper", "PCI MB", "paper", "gain of a faster bus"];
    let mut table = Table::new(names().chain(numbers.map(Column::number)));
    for spot in spots {
        let (ours, paper) = (Shape::ours(spot), Shape::printed(&spot.paper));
        let relations = [ours.speed_a, paper.speed_a, ours.speed_b, paper.speed_b].map(ratio);
        let loaded =
            [in_mb(spot.version_a.pci_bytes), spot.paper.version_a.pci_mb].map(|mb| format!("{mb:.2}"));
        let gain = ratio(spot.version_a_fast_pci.fps / spot.version_a.fps);
        table.row(name(spot).chain(relations).chain(loaded).chain([gain]));
    }
    table
}

/// The fit of the rows.
fn fit_table(fits: &Fits) -> Table {
    let numbers = ["rows", "numbers", "off by", "95 % over families", "95 % over rows", "within 10 %"];
    let columns = std::iter::once(Column::text("scenes")).chain(numbers.map(Column::number));
    let mut table = Table::new(columns.chain([Column::text("off the most")]));
    let of = [("built-in", Some(&fits.built_in)), ("real", fits.real.as_ref()), ("all", Some(&fits.all))];
    for (scenes, fit) in of {
        let Some(fit) = fit else { continue };
        let interval = |[low, high]: [f64; 2]| format!("{low:.1} to {high:.1} %");
        let worst = fit.worst.as_ref().map_or_else(String::new, |worst| {
            let Relation { scene, row, relation, ours, paper } = worst;
            format!("{relation} of {scene} for {row}: {} (paper {})", ratio(*ours), ratio(*paper))
        });
        table.row([
            scenes.to_owned(),
            fit.rows.to_string(),
            fit.numbers.to_string(),
            format!("{:.1} %", fit.error_percent),
            interval(fit.interval),
            interval(fit.interval_by_rows),
            fit.within_10_percent.to_string(),
            worst,
        ]);
    }
    table
}

/// The hot spots on chips that differ from version A in the virtual memory.
fn variation_table(variations: &[Variation]) -> Table {
    let names = ["scene", "line", "ways", "hash"].map(Column::text).into_iter();
    let numbers = ["fps", "loaded MB", "Mem MB", "metadata KB"].map(Column::number);
    let mut table = Table::new(names.chain(numbers));
    for Variation { scene, line_bytes, ways, hashed, metadata_bytes, run } in variations {
        let hash = if *hashed { "yes" } else { "no" };
        table.row([
            format!("{scene} {}", run.frame),
            line_bytes.to_string(),
            ways.to_string(),
            hash.to_owned(),
            format!("{:.1}", run.fps),
            format!("{:.2}", in_mb(run.pci_bytes)),
            format!("{:.2}", in_mb(run.mem_bytes)),
            format!("{:.0}", *metadata_bytes as f64 / 1024.0),
        ]);
    }
    table
}
