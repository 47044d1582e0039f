//! What virtual memories of many sizes load, as a table and as a picture: a row a line, a number of ways, a hash and a policy,
//! a column a size of the on-board memory.

use crate::plot::accessible;
use crate::size::Size;
use crate::table::{Column, Table};
use anyhow::{Result, ensure};
use kuva::plot::{ColorMap, Heatmap};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;
use saarcor_kit::vm::config::{HASHES, POLICIES};
use saarcor_model::vm::{Bytes, CacheConfig};
use saarcor_paper::{MB, mb};
use saarcor_studies::names::name_of;
use std::sync::Arc;

/// What a virtual memory loads.
#[derive(Clone, Copy, Debug)]
pub struct Loaded {
    /// The virtual memory.
    pub config: CacheConfig,
    /// Bytes from the host.
    pub bytes: u64,
}

/// The rows: their names, and their cells in the order of the columns. All rows have the same columns, one after the other.
fn rows(loaded: &[Loaded]) -> Vec<(String, &[Loaded])> {
    let several =
        |value: &dyn Fn(&Loaded) -> &'static str| loaded.iter().any(|one| value(one) != value(&loaded[0]));
    let hash = |one: &Loaded| name_of(HASHES, &one.config.hash);
    let policy = |one: &Loaded| name_of(POLICIES, &one.config.policy);
    let (hashes, policies) = (several(&hash), several(&policy));
    let name = |one: &Loaded| {
        let geometry = one.config.geometry;
        let way = if geometry.ways() == 1 { "way" } else { "ways" };
        let mut name = format!("{}, {} {way}", Size(geometry.line()), geometry.ways());
        if hashes {
            name = format!("{name}, {}", hash(one));
        }
        if policies {
            name = format!("{name}, {}", policy(one));
        }
        name
    };
    loaded.chunks(columns(loaded).len()).map(|row| (name(&row[0]), row)).collect()
}

/// The sizes of the on-board memory.
fn columns(loaded: &[Loaded]) -> Vec<Bytes> {
    let mut sizes: Vec<Bytes> = Vec::new();
    for memory in loaded.iter().map(|one| one.config.geometry.memory()) {
        if sizes.first() == Some(&memory) {
            break;
        }
        sizes.push(memory);
    }
    sizes
}

/// So many frames in words.
#[must_use]
pub fn frames_in_words(frames: usize) -> String {
    if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") }
}

/// The table, in MB.
#[must_use]
pub fn table(loaded: &[Loaded]) -> Table {
    let sizes = columns(loaded).into_iter().map(|size| Column::number(Size(size).to_string()));
    let mut table = Table::new([Column::text("line, ways")].into_iter().chain(sizes));
    for (name, row) in rows(loaded) {
        table.row([name].into_iter().chain(row.iter().map(|one| mb(one.bytes))));
    }
    table
}

/// The picture: a field a virtual memory, the darker the more it loads, by the logarithm.
///
/// `id` distinguishes it from other pictures of a page.
///
/// # Errors
/// If nothing is loaded.
pub fn svg(loaded: &[Loaded], id: &str, scene: &str, frames: usize) -> Result<String> {
    let megabytes = |one: &Loaded| one.bytes as f64 / MB as f64;
    let (least, most) = loaded
        .iter()
        .map(megabytes)
        .fold((f64::INFINITY, 0.0_f64), |(least, most), loaded| (least.min(loaded), most.max(loaded)));
    ensure!(least > 0.0, "--svg: nothing is loaded");
    let frames = frames_in_words(frames);
    // The colour is chosen by where a value lies between the least and the most.
    let colour = move |place: f64| {
        let value = least + place * (most - least);
        let dark = if most > least { (value / least).ln() / (most / least).ln() } else { 0.0 };
        let mix = |light: f64, full: f64| (light + dark * (full - light)).round() as u8;
        format!("#{:02x}{:02x}{:02x}", mix(236.0, 200.0), mix(240.0, 100.0), mix(244.0, 27.0))
    };
    // The lowest row of the picture comes first.
    let rows: Vec<_> = rows(loaded).into_iter().rev().collect();
    let sizes = columns(loaded).into_iter().map(|size| Size(size).to_string()).collect();
    let heat = Heatmap::new()
        .with_data(rows.iter().map(|(_, row)| row.iter().map(megabytes).collect::<Vec<_>>()))
        .with_color_map(ColorMap::Custom(Arc::new(colour)))
        .with_values();
    let plots = vec![Plot::Heatmap(heat)];
    // The numbers stand on the fields' own colours: light ones, whatever the page is.
    let ground = Theme {
        background: "#ffffff".to_owned(),
        font_family: Some("system-ui, sans-serif".to_owned()),
        ..Theme::light()
    };
    let layout = Layout::auto_from_plots(&plots)
        .with_title(format!("{scene}: MB loaded from the host by {frames}"))
        .with_width(760.0)
        .with_height(120.0 + 24.0 * rows.len() as f64)
        .with_x_label("on-board memory")
        .with_y_label("line, ways")
        .with_x_categories(sizes)
        .with_y_categories(rows.iter().map(|(name, _)| name.clone()).collect())
        .with_theme(ground);
    let drawn = render_multiple(plots, layout);
    let description = format!(
        "MB loaded from the host by {frames}, over the size of the on-board memory, the line and the ways: \
         from {least:.2} to {most:.2}."
    );
    Ok(accessible(&drawn, id, scene, &description))
}
