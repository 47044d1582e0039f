//! Which contestants are worth their time: the front of speed against error.

use super::contest::Contestant;
use super::measure::{Row, quantile};
use crate::args::kernel_name;
use crate::plot::{accessible, theme};
use crate::table::{Column, Table};
use kuva::backend::svg::SvgBackend;
use kuva::plot::ScatterPlot;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;

/// A contestant over all suites.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Which one.
    pub contestant: Contestant,
    /// Nanoseconds a test: median over the suites.
    pub ns: f64,
    /// Wrong answers in a million cases.
    pub wrong_per_million: f64,
    /// Leaks.
    pub leaks: u64,
    /// What 99.9 % of the distances' errors do not exceed, in ulps, in the median suite.
    pub t_ulp_p999: f64,
    /// No other contestant is both faster and less often wrong.
    pub on_front: bool,
}

impl Standing {
    /// Kernel and format.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", kernel_name(self.contestant.kernel), self.contestant.format.name())
    }
}

/// The standing of each contestant in `rows`, the fastest first.
#[must_use]
pub fn standings(rows: &[Row]) -> Vec<Standing> {
    let mut standings: Vec<Standing> = Vec::new();
    for row in rows {
        let contestant = row.contestant();
        if standings.iter().any(|known| known.contestant == contestant) {
            continue;
        }
        let own: Vec<&Row> = rows.iter().filter(|row| row.contestant() == contestant).collect();
        let median =
            |number: fn(&Row) -> f64| quantile(&mut own.iter().map(|r| number(r)).collect::<Vec<_>>(), 0.5);
        let sum = |number: fn(&Row) -> u64| own.iter().map(|row| number(row)).sum::<u64>();
        standings.push(Standing {
            contestant,
            ns: median(|row| row.ns_per_test),
            wrong_per_million: sum(Row::wrong) as f64 * 1e6 / sum(|row| row.cases).max(1) as f64,
            leaks: sum(|row| row.leaks),
            t_ulp_p999: median(|row| row.t_ulp_p999),
            on_front: false,
        });
    }
    standings.sort_by(|a, b| a.ns.total_cmp(&b.ns));
    let mut least_wrong = f64::INFINITY;
    for standing in &mut standings {
        standing.on_front = standing.wrong_per_million < least_wrong;
        least_wrong = least_wrong.min(standing.wrong_per_million);
    }
    standings
}

/// The standings as a table.
#[must_use]
pub fn table(standings: &[Standing]) -> Table {
    let numbers = ["ns a test", "wrong in 10^6", "leaks", "t p99.9 (ulp)"].map(Column::number);
    let mut table =
        Table::new([Column::text("contestant")].into_iter().chain(numbers).chain([Column::text("front")]));
    for standing in standings {
        table.row([
            standing.name(),
            format!("{:.1}", standing.ns),
            format!("{:.1}", standing.wrong_per_million),
            standing.leaks.to_string(),
            format!("{:.3}", standing.t_ulp_p999),
            if standing.on_front { "yes" } else { "" }.to_owned(),
        ]);
    }
    table
}

/// In place of no wrong answer at all, which a logarithmic axis does not have.
const NONE: f64 = 0.1;

/// Nanoseconds against wrong answers as SVG; the contestants on the front are named.
#[must_use]
pub fn svg(standings: &[Standing]) -> String {
    let points = |on_front: bool| {
        let chosen = standings.iter().filter(move |standing| standing.on_front == on_front);
        chosen.map(|standing| (standing.ns, standing.wrong_per_million.max(NONE))).collect::<Vec<_>>()
    };
    let names: Vec<String> = standings.iter().filter(|it| it.on_front).map(Standing::name).collect();
    // The colours stand out from white and from black alike, and the sizes tell the two apart.
    let front = ScatterPlot::new()
        .with_data(points(true))
        .with_color("#c8641b")
        .with_size(6.0)
        .with_labels(names.clone())
        .with_repel_labels()
        .with_legend("on the front");
    let others = ScatterPlot::new()
        .with_data(points(false))
        .with_color("#2f7fc1")
        .with_size(3.5)
        .with_legend("slower and no better than another");
    let plots = vec![Plot::Scatter(others), Plot::Scatter(front)];
    let layout = Layout::auto_from_plots(&plots)
        .with_width(760.0)
        .with_height(420.0)
        .with_log_scale()
        // Room below the contestants that are never wrong.
        .with_y_axis_min(NONE / 10.0)
        .with_x_label("nanoseconds a test")
        .with_y_label(format!("wrong answers in 10^6 cases ({NONE}: none)"))
        .with_legend_position(kuva::plot::LegendPosition::OutsideBottomColumns)
        .with_grid_line_width(0.4)
        .with_legend_box(false)
        .with_theme(theme());
    let scene = render_multiple(plots, layout);
    let description = format!("Time against wrong answers. On the front: {}.", names.join(", "));
    let (width, height) = (scene.width, scene.height);
    let drawn = SvgBackend::new().render_scene(&scene);
    accessible(&drawn, "accuracy", "Speed against error", &description, (width, height))
}
