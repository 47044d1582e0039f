//! The front of speed against error of triangle tests: as a table, and as a graph.

use crate::plot::{accessible, layout};
use crate::table::{Column, Table};
use kuva::plot::ScatterPlot;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use saarcor_studies::accuracy::front::Standing;

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
    // The colours stand out from white and from black alike, and the sizes distinguish the two.
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
    let layout = layout(&plots, 420.0)
        .with_log_scale()
        // Room below the contestants that are never wrong.
        .with_y_axis_min(NONE / 10.0)
        .with_x_label("nanoseconds a test")
        .with_y_label(format!("wrong answers in 10^6 cases ({NONE}: none)"));
    let scene = render_multiple(plots, layout);
    let description = format!("Time against wrong answers. On the front: {}.", names.join(", "));
    accessible(&scene, "accuracy", "Speed against error", &description)
}
