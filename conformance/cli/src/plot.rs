//! How graphs look. A graph takes its text colour from what surrounds it, so that it is legible on
//! light and on dark ground.

use crate::table::escaped;
use kuva::backend::svg::SvgBackend;
use kuva::plot::LegendPosition;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;
use kuva::render::theme::Theme;

/// Colours of a graph.
#[must_use]
pub fn theme() -> Theme {
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

/// The layout of a graph of that height: as wide as a page, with the legend below.
#[must_use]
pub fn layout(plots: &[Plot], height: f64) -> Layout {
    Layout::auto_from_plots(plots)
        .with_width(760.0)
        .with_height(height)
        .with_legend_position(LegendPosition::OutsideBottomColumns)
        .with_grid_line_width(0.4)
        .with_legend_box(false)
        .with_theme(theme())
}

/// A graph as SVG, with a name and a description, scaling with its place, and with colours of its
/// own where it stands alone. `id` distinguishes it from other graphs of a page.
#[must_use]
pub fn accessible(scene: &Scene, id: &str, title: &str, description: &str) -> String {
    let (svg, width, height) = (SvgBackend::new().render_scene(scene), scene.width, scene.height);
    let style = ":root{color:#1b1b1b;background:#fff}\
                 @media(prefers-color-scheme:dark){:root{color:#e8e8e8;background:#161616}}";
    let begin = format!(
        "<svg role=\"img\" aria-labelledby=\"{id}-title {id}-description\" viewBox=\"0 0 {width:.0} {height:.0}\" "
    );
    let head = format!(
        "<title id=\"{id}-title\">{}</title><desc id=\"{id}-description\">{}</desc><style>{style}</style>",
        escaped(title),
        escaped(description)
    );
    svg.replacen("<svg ", &begin, 1).replacen('>', &format!(">{head}"), 1)
}
