//! Estimates from a sample, for a person to read.

use crate::table::{Column, Table};
use saarcor_studies::sampling::estimate::Estimate;
use saarcor_studies::sampling::row::SampleRow;

/// The estimates and their intervals.
#[must_use]
pub fn table(row: &SampleRow) -> Table {
    let columns = ["estimate", "from", "to", "± %"].map(Column::number);
    let mut table = Table::new([Column::text("quantity")].into_iter().chain(columns));
    for quantity in &row.quantities {
        let numbers = quantity.values().map(|number| match number.as_u64() {
            Some(count) => count.to_string(),
            None => format!("{:.3}", number.as_f64().unwrap_or_default()),
        });
        let Estimate { estimate, low, high } = quantity.estimate;
        let half = if high > low { 50.0 * (high - low) / estimate } else { 0.0 };
        let half = if half.is_finite() { format!("{half:.1}") } else { "-".to_owned() };
        table.row([quantity.name.clone()].into_iter().chain(numbers).chain([half]));
    }
    table
}

/// From how much of the picture.
#[must_use]
pub fn heading(row: &SampleRow) -> String {
    let [packets, in_full] = row.packets;
    format!("estimates from {in_full} of {packets} packets, with intervals of 95 %")
}
