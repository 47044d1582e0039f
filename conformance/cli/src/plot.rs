//! How graphs look. A graph takes its text colour from what surrounds it, so that it is legible on
//! light and on dark ground.

use crate::table::escaped;
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

/// The same drawing with a name and a description, scaling with its place, and with colours of its
/// own where it stands alone. `id` distinguishes it from other graphs of a page.
#[must_use]
pub fn accessible(
    svg: &str,
    id: &str,
    title: &str,
    description: &str,
    (width, height): (f64, f64),
) -> String {
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
