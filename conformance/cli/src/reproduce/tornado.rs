//! What each value of an Assumed number does to the error, as bars: a tornado.

use crate::plot::{accessible, theme};
use kuva::plot::BarPlot;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_paper::sensitivity::{Bar, Errors, Sensitivity};

/// Of which error a tornado is.
pub struct Tornado {
    /// Name of its file, without ending.
    pub file: &'static str,
    /// What the error is of.
    pub of: &'static str,
    error: fn(&Errors) -> f64,
}

/// All tornados.
pub const TORNADOS: [Tornado; 4] = [
    Tornado { file: "tornado-a", of: "A / no VM", error: |errors| errors.a },
    Tornado { file: "tornado-b", of: "B / no VM", error: |errors| errors.b },
    Tornado { file: "tornado-mem", of: "Mem of version A", error: |errors| errors.mem },
    Tornado { file: "tornado-pci", of: "PCI of version A", error: |errors| errors.pci },
];

/// Changes that are smaller, in points, have no bar.
const WORTH_A_BAR: f64 = 0.05;
/// Height of a bar with the space around it.
const BAR: f64 = 20.0;

/// Nearer to the paper, and farther.
const COLOURS: [&str; 2] = ["#2f7fc1", "#c8641b"];

impl Tornado {
    /// The drawing: the longest bar at the top.
    pub fn svg(&self, sensitivity: &Sensitivity) -> String {
        let all = |bar: &Bar| bar.effects.get("all").map_or(0.0, |effect| (self.error)(&effect.errors));
        let defaults = all(&sensitivity.defaults);
        let mut bars: Vec<(&str, f64)> =
            sensitivity.bars.iter().map(|bar| (bar.setting.as_str(), all(bar) - defaults)).collect();
        let left_out = bars.len();
        bars.retain(|(_, change)| change.abs() >= WORTH_A_BAR);
        let left_out = left_out - bars.len();
        // The drawing begins at the bottom.
        bars.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let height = 90.0 + BAR * bars.len().max(1) as f64;
        let plot = bars.iter().fold(BarPlot::new().with_horizontal(true), |plot, (setting, change)| {
            plot.with_group(*setting, [(*change, COLOURS[usize::from(*change > 0.0)])])
        });
        let plots = vec![Plot::Bar(plot)];
        let layout = Layout::auto_from_plots(&plots)
            .with_width(760.0)
            .with_height(height)
            .with_x_label("change of the error in points of percent: less than 0 is nearer to the paper")
            .with_grid_line_width(0.4)
            .with_theme(theme());
        let scene = render_multiple(plots, layout);
        let title = format!("{}: error of {defaults:.1} % with the defaults", self.of);
        let description = format!(
            "Change of the geometric error of {} over {} rows when one Assumed number has another value. {left_out} values \
             that change it by less than {WORTH_A_BAR} points are left out.",
            self.of,
            sensitivity.defaults.effects.get("all").map_or(0, |effect| effect.rows),
        );
        accessible(&scene, self.file, &title, &description)
    }
}
