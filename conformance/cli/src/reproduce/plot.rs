//! A graph of Figure 3 as SVG.

use crate::plot::{accessible, layout};
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::plots::Plot;
use kuva::render::render::{render_multiple, render_twin_y};
use saarcor_paper::figure3::Graph;
use saarcor_paper::tables::{MB, mb};
use saarcor_studies::walk::FrameRow;

/// A curve of MB a frame: name, colour, style, bytes. The colours stand out from white and from black
/// alike, and the styles distinguish the lines without them.
type Series = (&'static str, &'static str, LineStyle, fn(&FrameRow, u64) -> u64);

const SERIES: [Series; 3] = [
    ("working set", "#2f7fc1", LineStyle::Solid, |row, _| row.working_set_bytes),
    ("transferred", "#c8641b", LineStyle::Solid, |row, _| row.loaded_bytes),
    ("of these, collisions", "#9a5fc0", LineStyle::Dotted, |row, line| row.collisions * line),
];

/// The graph: MB of each frame.
pub fn svg(graph: &Graph) -> String {
    let line = saarcor_studies::standard::LINE.0;
    let plots: Vec<Plot> = SERIES.into_iter().map(|series| curve(graph, series, line)).collect();
    let fps = graph.fps.iter().filter_map(|row| Some((row.frame as f64, row.fps?))).collect::<Vec<_>>();
    let in_time = match fps.is_empty() {
        true => Vec::new(),
        false => {
            let line =
                LinePlot::new().with_data(fps).with_color("#3a9a5f").with_line_style(LineStyle::Dashed);
            vec![Plot::Line(line.with_stroke_width(1.2).with_legend("frames a second (right)"))]
        }
    };
    let mut layout = layout(&plots, 320.0)
        .with_x_label("frame")
        .with_y_label("MB a frame")
        .with_y_axis_min(0.0)
        .with_x_axis_min(0.0);
    let scene = if in_time.is_empty() {
        render_multiple(plots, layout)
    } else {
        layout = layout.with_y2_auto(&in_time).with_y2_axis_min(0.0).with_y2_label("frames a second");
        render_twin_y(plots, in_time, layout)
    };
    let peak = graph.frames.iter().map(|row| row.working_set_bytes).max().unwrap_or(0);
    let title = format!("{} with {} MB of on-board memory", graph.name, mb(graph.memory_bytes));
    let description = format!(
        "Working set, memory transferred and collisions of each frame, and frames a second. The largest working set is {} MB.",
        mb(peak)
    );
    accessible(&scene, &file(graph), &title, &description)
}

/// The name of a graph's files, without the ending: of letters, digits and what needs no quotes in a link or an attribute.
pub fn file(graph: &Graph) -> String {
    let plain = |letter: char| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '-' };
    format!("figure3-{}", graph.name.chars().map(plain).collect::<String>())
}

fn curve(graph: &Graph, (name, colour, style, bytes): Series, line: u64) -> Plot {
    let point = |row: &FrameRow| (row.frame as f64, bytes(row, line) as f64 / MB as f64);
    let points: Vec<(f64, f64)> = graph.frames.iter().map(point).collect();
    let plot = LinePlot::new().with_data(points).with_color(colour).with_line_style(style);
    Plot::Line(plot.with_stroke_width(1.2).with_legend(name))
}
