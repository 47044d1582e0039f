//! The features that a scene needs of the chip, and the bytes of its image, for a person to read.

use crate::table::{Column, Table};
use saarcor_model::host::Features;
use saarcor_paper::mb;
use saarcor_studies::summary::{Summary, needs};

/// The names of the features that a scene needs, or does not need.
#[must_use]
pub fn listed(features: Features, needed: bool) -> String {
    let names: Vec<_> =
        needs(features).into_iter().filter(|need| need.1 == needed).map(|need| need.0).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

/// The facts in a few lines.
#[must_use]
pub fn lines(summary: &Summary) -> Vec<String> {
    let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let without_area = match summary.triangles_without_area {
        0 => String::new(),
        n => format!(" ({n} without area)"),
    };
    vec![
        format!(
            "{}: {}{without_area}, {}, {}",
            summary.scene,
            plural(summary.triangles, "triangle"),
            plural(summary.lights as usize, "light"),
            plural(summary.frames, "frame")
        ),
        format!("needs: {}", listed(summary.features, true)),
        format!("does not need: {}", listed(summary.features, false)),
        format!(
            "kd-tree: {}, {} leaves, {:.2} references a triangle",
            plural(summary.nodes, "node"),
            summary.leaves,
            summary.references as f64 / summary.triangles.max(1) as f64
        ),
    ]
}

/// The bytes of the image by region on one line.
#[must_use]
pub fn image_line(summary: &Summary) -> String {
    let regions: Vec<_> =
        summary.regions.iter().map(|region| format!("{} {}", region.region, mb(region.bytes))).collect();
    format!("image: {} MB ({})", mb(summary.image_bytes), regions.join(", "))
}

/// The bytes of the image by region.
#[must_use]
pub fn image_table(summary: &Summary) -> Table {
    let mut table = Table::new([
        Column::text("region"),
        Column::number("bytes"),
        Column::number("MB"),
        Column::number("bytes a triangle"),
    ]);
    for region in &summary.regions {
        table.row([
            region.region.to_owned(),
            region.bytes.to_string(),
            mb(region.bytes),
            format!("{:.1}", region.bytes_a_triangle),
        ]);
    }
    table
}

/// How long the scene took to make ready.
#[must_use]
pub fn seconds_line(summary: &Summary) -> String {
    let [loaded, built, laid_out] = summary.seconds;
    format!("seconds: {loaded:.2} scene, {built:.2} kd-tree, {laid_out:.2} image")
}
