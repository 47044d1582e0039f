//! Where the bytes of the on-board memory go, as stacked bars: a bar a row of Table 2.

use super::tables::CLASSES;
use crate::plot::{accessible, layout};
use kuva::plot::BarPlot;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_paper::table2::HotSpot;

/// Bars of a version.
pub struct Bars {
    /// Name of their file, without ending.
    pub file: &'static str,
    version: &'static str,
    name: &'static str,
}

/// All bars.
pub const ALL: [Bars; 2] = [
    Bars { file: "bytes-a", version: "a", name: "version A" },
    Bars { file: "bytes-b", version: "b", name: "version B" },
];

/// A colour a class, distinct for most kinds of colour blindness (Okabe and Ito 2008).
const COLOURS: [&str; 8] =
    ["#0072b2", "#56b4e9", "#009e73", "#f0e442", "#e69f00", "#999999", "#cc79a7", "#d55e00"];
/// Height of a bar with the space around it.
const BAR: f64 = 18.0;

impl Bars {
    /// The drawing: parts of each row's bytes, in percent, the first row at the top.
    pub fn svg(&self, spots: &[HotSpot]) -> String {
        let rows = spots.iter().rev().filter_map(|spot| Some((spot, spot.traffic.get(self.version)?)));
        let plot = rows.fold(BarPlot::new().with_horizontal(true).with_stacked(), |plot, (spot, traffic)| {
            let all = traffic.mem.values().sum::<u64>().max(1) as f64;
            let part = |class: &str| 100.0 * traffic.mem.get(class).copied().unwrap_or(0) as f64 / all;
            let parts = CLASSES.iter().zip(COLOURS).map(|((_, class), colour)| (part(class), colour));
            plot.with_group(spot.name(), parts)
        });
        let plots = vec![Plot::Bar(plot.with_legend(CLASSES.map(|(class, _)| class).to_vec()))];
        let layout = layout(&plots, 140.0 + BAR * spots.len() as f64)
            .with_x_label("% of the bytes to and from the on-board memory")
            .with_x_axis_max(100.0);
        let scene = render_multiple(plots, layout);
        let title = format!("Where the bytes of the on-board memory go: {}", self.name);
        let description =
            "Of each row, the part of its bytes that each class takes. The tables have them in MB.";
        accessible(&scene, self.file, &title, description)
    }
}
