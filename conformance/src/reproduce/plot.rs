//! A graph of Figure 3 as SVG. It takes its text colour from what surrounds it, so that it is
//! legible on light and on dark ground.

use super::figure3::Graph;
use crate::table::{escaped, mb};
use crate::walk::FrameRow;
use kuva::backend::svg::SvgBackend;
use kuva::plot::{LegendPosition, LinePlot, LineStyle};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;
use saarcor_reference::paper::MB;

/// What is drawn a frame, in MB: name, colour, style, bytes. The colours stand out from white and
/// from black alike, and the styles tell the lines apart without them.
type Series = (&'static str, &'static str, LineStyle, fn(&FrameRow, u64) -> u64);

const SERIES: [Series; 3] = [
    ("working set", "#2f7fc1", LineStyle::Solid, |row, _| row.working_set_bytes),
    ("transferred", "#c8641b", LineStyle::Solid, |row, _| row.loaded_bytes),
    ("of these, collisions", "#9a5fc0", LineStyle::Dotted, |row, line| row.collisions * line),
];

/// The graph: MB of each frame.
pub fn svg(graph: &Graph) -> String {
    let line = crate::standard::line().0;
    let plots: Vec<Plot> = SERIES.into_iter().map(|series| curve(graph, series, line)).collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_width(760.0)
        .with_height(320.0)
        .with_x_label("frame")
        .with_y_label("MB a frame")
        .with_y_axis_min(0.0)
        .with_x_axis_min(0.0)
        .with_legend_position(LegendPosition::OutsideBottomColumns)
        .with_grid_line_width(0.4)
        .with_legend_box(false)
        .with_theme(theme());
    let scene = render_multiple(plots, layout);
    accessible(&SvgBackend::new().render_scene(&scene), graph, scene.width, scene.height)
}

fn curve(graph: &Graph, (name, colour, style, bytes): Series, line: u64) -> Plot {
    let point = |row: &FrameRow| (row.frame as f64, bytes(row, line) as f64 / MB as f64);
    let points: Vec<(f64, f64)> = graph.frames.iter().map(point).collect();
    let plot = LinePlot::new().with_data(points).with_color(colour).with_line_style(style);
    Plot::Line(plot.with_stroke_width(1.2).with_legend(name))
}

fn theme() -> Theme {
    let text = || "currentColor".to_owned();
    Theme {
        background: "none".to_owned(),
        axis_color: text(),
        tick_color: text(),
        text_color: text(),
        grid_color: "#9a9a9a".to_owned(),
        legend_bg: "none".to_owned(),
        legend_border: "none".to_owned(),
        font_family: Some("system-ui, sans-serif".to_owned()),
        ..Theme::light()
    }
}

/// The same drawing with a name and a description, scaling with its place, and with colours of its
/// own where it stands alone.
fn accessible(svg: &str, graph: &Graph, width: f64, height: f64) -> String {
    let peak = graph.frames.iter().map(|row| row.working_set_bytes).max().unwrap_or(0);
    let title = format!("{} with {} MB of on-board memory", graph.name, graph.memory_bytes / MB);
    let description = format!(
        "Working set, memory transferred and collisions of each frame. The largest working set is {} MB.",
        mb(peak)
    );
    let style = ":root{color:#1b1b1b;background:#fff}\
                 @media(prefers-color-scheme:dark){:root{color:#e8e8e8;background:#161616}}";
    let id = &graph.name;
    let begin = format!(
        "<svg role=\"img\" aria-labelledby=\"{id}-title {id}-description\" viewBox=\"0 0 {width:.0} {height:.0}\" "
    );
    let head = format!(
        "<title id=\"{id}-title\">{}</title><desc id=\"{id}-description\">{}</desc><style>{style}</style>",
        escaped(&title),
        escaped(&description)
    );
    svg.replacen("<svg ", &begin, 1).replacen('>', &format!(">{head}"), 1)
}
