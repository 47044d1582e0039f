//! The costs of a sweep as curves over the sizes of one axis: bytes loaded, and metadata.

use crate::plot::{accessible, layout};
use crate::size::Size;
use anyhow::{Result, anyhow, ensure};
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::layout::TickFormat;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_model::vm::Bytes;
use saarcor_paper::MB;
use saarcor_studies::sweep::PointCosts;
use std::sync::Arc;

/// The values of an axis as sizes.
///
/// # Errors
/// If one is none: an axis of names has no curve.
pub fn sizes<'a>(values: impl Iterator<Item = &'a str>, axis: &str) -> Result<Vec<u64>> {
    values
        .map(|value| {
            let Size(Bytes(size)) = value.parse().map_err(|_| {
                anyhow!(
                    "--svg: {axis} {value} is no size; curves are drawn over sizes, such as those of line"
                )
            })?;
            ensure!(size > 0, "--svg: {axis} 0 has no place on a logarithmic axis");
            Ok(size)
        })
        .collect()
}

/// The curves, with a line where the product of both costs is least. What costs nothing has no
/// place on a logarithmic axis and is left out.
///
/// # Errors
/// If nothing is left to draw.
pub fn svg(axis: &str, frame: &str, costs: &[PointCosts]) -> Result<String> {
    let mut costs = costs.to_vec();
    costs.retain(|costs| costs.loaded > 0 && costs.metadata > 0);
    costs.sort_by_key(|costs| costs.size);
    let best =
        PointCosts::best(&costs).ok_or_else(|| anyhow!("--svg: no point loads anything and has metadata"))?;
    let place = |costs: &PointCosts| (costs.size as f64).log2();
    let curve = |name: &str, colour: &str, style, points: Vec<(f64, f64)>| {
        let plot = LinePlot::new().with_data(points).with_color(colour).with_line_style(style);
        Plot::Line(plot.with_stroke_width(1.6).with_legend(name))
    };
    let megabytes = |bytes: u64| bytes as f64 / MB as f64;
    let loaded: Vec<_> = costs.iter().map(|costs| (place(costs), megabytes(costs.loaded))).collect();
    let metadata: Vec<_> = costs.iter().map(|costs| (place(costs), megabytes(costs.metadata))).collect();
    let here = [best.loaded, best.metadata].map(|bytes| (place(best), megabytes(bytes)));
    let plots = vec![
        curve("loaded from the host a frame", "#c8641b", LineStyle::Solid, loaded),
        curve("metadata", "#2f7fc1", LineStyle::Dashed, metadata),
        curve("least product of both", "#9a5fc0", LineStyle::Dotted, here.to_vec()),
    ];
    let size = |log2: f64| Size(Bytes(log2.exp2().round() as u64)).to_string();
    let layout = layout(&plots, 360.0)
        .with_x_label(axis)
        .with_y_label("MB")
        .with_log_y()
        .with_x_tick_step(1.0)
        .with_x_tick_format(TickFormat::Custom(Arc::new(size)))
        .with_y_tick_format(TickFormat::Custom(Arc::new(|value| value.to_string())));
    let scene = render_multiple(plots, layout);
    let description = format!(
        "Bytes loaded and metadata over {axis}. Their product is least at {}.",
        Size(Bytes(best.size))
    );
    Ok(accessible(&scene, "sweep", frame, &description))
}
