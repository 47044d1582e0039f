//! The figures as tables.

use crate::metadata;
use crate::table::{Column, Table};
use saarcor_model::time::Version;
use saarcor_paper::alternatives::{FAST_BUS, is_of_lines};
use saarcor_paper::claims::Claim;
use saarcor_paper::figure3::Graph;
use saarcor_paper::figure3::MemoryRow;
use saarcor_paper::fit::{Fits, Relation};
use saarcor_paper::reproduction::Reproduction;
use saarcor_paper::table1::SceneRow;
use saarcor_paper::table2::{Alternative, HotSpot, Shape};
use saarcor_paper::tables::{MB, VirtualRun, in_mb, mb};
use saarcor_studies::simulate::TimingRow;
use saarcor_studies::walk::FrameRow;

/// The tables of a section, with their captions.
type Captioned = Vec<(String, Table)>;

/// The tables of the report by sections of the page: metadata, scenes, walks, chip.
pub fn sections(report: &Reproduction) -> [Captioned; 4] {
    let captioned = |caption: &str, table: Table| (caption.to_owned(), table);
    let metadata = (!report.metadata.is_empty())
        .then(|| captioned("Metadata of 16 MB (§3)", metadata::table(&report.metadata)));
    let scenes = [
        captioned("Table 1: the scenes, ours beside the paper's", table1_beside(&report.table1)),
        captioned("Bytes a triangle, ours by region of the image", bytes_a_triangle(&report.table1)),
    ];
    let memories = (!report.memories.is_empty()).then(|| {
        let caption = "The walk with other sizes of on-board memory, without first-level caches: what the first frame loads, which \
                       finds the memory empty, and what the others load";
        captioned(caption, memory_table(&report.memories))
    });
    let extremes = (
        format!("Figure 3: extremes and hot spots of the walks ({})", how(report)),
        extremes(&report.figure3),
    );
    let fit = report.fit.as_ref().map(|fit| {
        let caption =
            "How far the relations A / no VM, B / no VM and (where the paper's version A moves 0.6 MB or more) Mem B / A are off, by \
             the geometric mean";
        captioned(caption, fit_table(fit))
    });
    let with_cuts = (!report.cuts.is_empty()).then(|| {
        let caption = "Frames after a cut of the camera in the place of hot spots: relations within the rows";
        captioned(caption, cut_table(&report.cuts))
    });
    let of_lines = captioned(
        "Hot spots with other lines, fewer ways and without hash (versions A and B)",
        line_table(&report.table2),
    );
    // A scene of the user's stands in no row of the paper.
    let printed = |(caption, table): (String, Table)| match report.scene {
        None => (caption, table),
        Some(_) => (caption, table.without_blank_columns()),
    };
    let chip = table2_tables(&report.table2).into_iter().chain(fit).chain(with_cuts).map(printed);
    [
        metadata.into_iter().collect(),
        if report.scene.is_none() { scenes.into() } else { Vec::new() },
        memories.into_iter().chain([extremes]).collect(),
        chip.chain(traffic_tables(&report.table2)).chain([of_lines]).collect(),
    ]
}

/// The claims: the paper's figure, ours, the verdict, and what it hangs on.
pub fn claims(claims: &[Claim]) -> Table {
    let mut table = Table::new(["claim", "section", "paper", "ours", "verdict", "cause"].map(Column::text));
    for Claim { id, section, paper, ours, verdict, cause, .. } in claims {
        let cause = cause.as_ref().map_or_else(|| "–".to_owned(), ToString::to_string);
        table.row([
            (*id).to_owned(),
            (*section).to_owned(),
            paper.clone(),
            ours.clone(),
            verdict.to_string(),
            cause,
        ]);
    }
    table
}

/// The classes of bytes, as they are shown, and their names in JSON.
pub const CLASSES: [(&str, &str); 8] = [
    ("nodes", "nodes"),
    ("lists", "lists"),
    ("triangles", "triangles"),
    ("shading", "shading"),
    ("textures", "textures"),
    ("fills", "fills"),
    ("metadata read", "metadata_read"),
    ("written back", "metadata_write_back"),
];

/// Where the bytes go, a table a version, and what the units and caches do.
fn traffic_tables(spots: &[HotSpot]) -> Captioned {
    let versions = [("none", "no virtual memory"), ("a", "version A"), ("b", "version B")];
    let mut tables: Captioned = Vec::new();
    for (version, name) in versions {
        let columns = CLASSES.map(|(class, _)| class).into_iter().chain(["Mem"]).map(Column::number);
        let memory = ["requests a clock", "part of the peak", "rows opened a request"].map(Column::number);
        let mut table = Table::new([Column::text("row")].into_iter().chain(columns).chain(memory));
        for spot in spots {
            let Some(traffic) = spot.traffic.get(version) else { continue };
            let run = match version {
                "none" => &spot.no_vm,
                "a" => &spot.version_a,
                _ => &spot.version_b,
            };
            let classes = CLASSES.map(|(_, class)| mb(traffic.mem.get(class).copied().unwrap_or(0)));
            let opened = traffic.rows_opened as f64 / traffic.requests.max(1) as f64;
            let memory = [traffic.requests_a_clock, run.mem_use, opened].map(|number| format!("{number:.2}"));
            let cells = classes.into_iter().chain([mb(run.mem_bytes)]).chain(memory);
            table.row([spot.name()].into_iter().chain(cells));
        }
        tables.push((format!("Where the bytes of the on-board memory go, MB a frame: {name}"), table));
    }
    tables.push(("What version A loads from the host, MB a frame".to_owned(), loaded_table(spots)));
    tables.push((
        "Work a ray, and hit rates of the first-level caches, without virtual memory".to_owned(),
        work_table(spots),
    ));
    tables
}

fn loaded_table(spots: &[HotSpot]) -> Table {
    let regions = &CLASSES[..5];
    let columns = regions.iter().map(|(class, _)| *class).chain(["PCI"]).map(Column::number);
    let mut table = Table::new([Column::text("row")].into_iter().chain(columns));
    for spot in spots {
        let Some(traffic) = spot.traffic.get("a") else { continue };
        let cells = regions.iter().map(|(_, class)| mb(traffic.pci.get(class).copied().unwrap_or(0)));
        table.row([spot.name()].into_iter().chain(cells).chain([mb(spot.version_a.pci_bytes)]));
    }
    table
}

fn work_table(spots: &[HotSpot]) -> Table {
    let numbers = [
        "nodes a ray",
        "triangles a ray",
        "hits: nodes",
        "lists",
        "triangles",
        "paper",
        "shading",
        "intersection waits for memory",
    ];
    let mut table = Table::new([Column::text("row")].into_iter().chain(numbers.map(Column::number)));
    for spot in spots {
        let run = &spot.no_vm;
        let a_ray = |unit: &str| run.units[unit].rays as f64 / run.rays.max(1) as f64;
        let rate = |unit: &str| format!("{:.1} %", 100.0 * run.hit_rate(unit));
        // The one hit rate that the paper prints (§4).
        let is_printed = spot.paper.as_ref().is_some_and(|paper| paper.frame == "1625");
        table.row([
            spot.name(),
            format!("{:.1}", a_ray("traversal")),
            format!("{:.1}", a_ray("intersection")),
            rate("traversal"),
            rate("list"),
            rate("intersection"),
            if is_printed { "13 %".to_owned() } else { "–".to_owned() },
            rate("shading"),
            format!("{:.1} %", 100.0 * run.units["intersection"].waits_for("memory")),
        ]);
    }
    table
}

/// The walk with other sizes of on-board memory.
fn memory_table(rows: &[MemoryRow]) -> Table {
    let numbers = [
        "on-board MB",
        "frames",
        "working set fits",
        "loaded MB: first frame",
        "others, a frame",
        "most",
        "collisions a frame",
        "frames a second that the bus allows",
    ];
    let mut table = Table::new(numbers.map(Column::number));
    let none = || "–".to_owned();
    for row in rows {
        table.row([
            mb(row.memory_bytes),
            row.frames.to_string(),
            row.frames_that_fit.to_string(),
            mb(row.first_loaded_bytes),
            row.loaded_bytes_a_frame.map_or_else(none, |bytes| format!("{:.2}", bytes / MB as f64)),
            row.most_loaded_bytes.map_or_else(none, mb),
            row.collisions_a_frame.map_or_else(none, |collisions| format!("{collisions:.0}")),
            match (row.bus_fps, row.loaded_bytes_a_frame) {
                (Some(fps), _) => format!("{fps:.0}"),
                (None, Some(_)) => "any".to_owned(),
                (None, None) => none(),
            },
        ]);
    }
    table
}

/// Whether a walk leaves frames out.
pub fn skips_frames(report: &Reproduction) -> bool {
    report.figure3.iter().any(|graph| graph.step > 1)
}

/// How the walks were made.
fn how(report: &Reproduction) -> String {
    let (width, height) = report.resolution;
    let frames = if skips_frames(report) { "some frames" } else { "all frames" };
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

/// A ratio for a reader; nothing, where a number is divided by nothing.
fn ratio(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "–".to_owned() }
}

/// Columns that name a row.
fn names() -> impl Iterator<Item = Column> {
    ["scene", "frame", "ours"].map(Column::text).into_iter()
}

fn name(spot: &HotSpot) -> impl Iterator<Item = String> {
    let none = || "–".to_owned();
    let (scene, frame) = spot
        .paper
        .as_ref()
        .map_or_else(|| (none(), none()), |paper| (paper.scene.clone(), paper.frame.clone()));
    [scene, frame, spot.name()].into_iter()
}

/// Ours, the paper's if it has any, and their ratio.
fn beside(ours: f64, paper: Option<f64>, digits: usize) -> [String; 3] {
    let none = || "–".to_owned();
    let printed = paper.map_or_else(none, |paper| format!("{paper:.digits$}"));
    [format!("{ours:.digits$}"), printed, paper.map_or_else(none, |paper| ratio(ours / paper))]
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
        let paper = spot.paper.as_ref();
        let run = &spot.no_vm;
        let cells = beside(run.fps, paper.map(|paper| paper.no_vm.fps), 1)
            .into_iter()
            .chain(beside(in_mb(run.mem_bytes), paper.map(|paper| paper.no_vm.mem_mb), 1))
            .chain([format!("{:.1}", run.cycles_a_ray)]);
        no_vm.row(name(spot).chain(cells));
        let with_vm = |table: &mut Table, run: &TimingRow, paper: Option<VirtualRun>| {
            let cells = beside(run.fps, paper.map(|paper| paper.fps), 1)
                .into_iter()
                .chain(beside(in_mb(run.pci_bytes), paper.map(|paper| paper.pci_mb), 2))
                .chain(beside(in_mb(run.mem_bytes), paper.map(|paper| paper.mem_mb), 1));
            table.row(name(spot).chain(cells));
        };
        with_vm(&mut a, &spot.version_a, paper.map(|paper| paper.version_a));
        with_vm(&mut b, &spot.version_b, paper.map(|paper| paper.version_b));
    }
    vec![
        ("Table 2: hot spots without virtual memory".to_owned(), no_vm),
        ("Table 2: version A, metadata on the chip".to_owned(), a),
        ("Table 2: version B, metadata in the on-board memory".to_owned(), b),
        ("Table 2: relations within its rows".to_owned(), shapes(spots)),
    ]
}

/// Numbers of the paper's row; without one there are none.
fn printed<const N: usize>(spot: &HotSpot, numbers: impl Fn(Shape) -> [String; N]) -> [String; N] {
    let none = || std::array::from_fn(|_| "–".to_owned());
    spot.paper.as_ref().map_or_else(none, |paper| numbers(Shape::printed(paper)))
}

/// The relations, ours and the paper's.
fn shapes(spots: &[HotSpot]) -> Table {
    let relations = ["A / no VM", "B / no VM", "Mem B / A", "(Mem A - no VM) / PCI"];
    let columns = relations.iter().flat_map(|name| [*name, "paper"]).map(Column::number);
    let mut table = Table::new(names().chain(columns));
    for spot in spots {
        let numbers = |shape: Shape| [shape.speed_a, shape.speed_b, shape.memory_b, shape.filled].map(ratio);
        let (ours, paper) = (numbers(Shape::ours(spot)), printed(spot, numbers));
        table.row(name(spot).chain(ours.into_iter().zip(paper).flat_map(|(ours, paper)| [ours, paper])));
    }
    table
}

/// The relations of frames after a cut, and what a faster bus gains there.
fn cut_table(spots: &[HotSpot]) -> Table {
    let numbers = ["A / no VM", "paper", "B / no VM", "paper", "PCI MB", "paper", "gain of a faster bus"];
    let mut table = Table::new(names().chain(numbers.map(Column::number)));
    for spot in spots {
        let numbers = |shape: Shape| [shape.speed_a, shape.speed_b].map(ratio);
        let (ours, paper) = (numbers(Shape::ours(spot)), printed(spot, numbers));
        let relations = ours.into_iter().zip(paper).flat_map(|(ours, paper)| [ours, paper]);
        let loaded = spot.paper.as_ref().map(|paper| format!("{:.2}", paper.version_a.pci_mb));
        let loaded = [mb(spot.version_a.pci_bytes), loaded.unwrap_or_else(|| "–".to_owned())];
        let fast = spot.with(FAST_BUS, Version::A);
        let gain = ratio(fast.map_or(f64::NAN, |fast| fast.fps / spot.version_a.fps));
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

/// The hot spots with other lines, ways and hashes.
fn line_table(spots: &[HotSpot]) -> Table {
    let names = ["scene", "version", "line", "ways", "hash"].map(Column::text).into_iter();
    let numbers = ["fps", "loaded MB", "Mem MB", "metadata KB"].map(Column::number);
    let mut table = Table::new(names.chain(numbers));
    for (spot, one) in spots.iter().flat_map(|spot| spot.alternatives.iter().map(move |one| (spot, one))) {
        let Alternative { setting, line_bytes, ways, hashed, metadata_bytes, run } = one;
        if !is_of_lines(setting) {
            continue;
        }
        let hash = if *hashed { "yes" } else { "no" };
        table.row([
            spot.name(),
            run.variant.to_owned(),
            line_bytes.to_string(),
            ways.to_string(),
            hash.to_owned(),
            format!("{:.1}", run.fps),
            mb(run.pci_bytes),
            mb(run.mem_bytes),
            format!("{:.0}", *metadata_bytes as f64 / 1024.0),
        ]);
    }
    table
}
