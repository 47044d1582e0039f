//! Estimates for a person to read.

use saarcor_paper::mb;
use saarcor_studies::sampling::estimate::Estimate;

/// In place of an estimate whose interval is wider than half of it.
const NOT_KNOWN: &str = "not known from this sample";

/// A quantity of this name, with half of its interval's width if it is not exact: cycles, frames a second, and MB of bytes.
#[must_use]
pub fn text(name: &str, estimate: Estimate) -> String {
    if !estimate.is_known() {
        return NOT_KNOWN.to_owned();
    }
    let value = match name {
        "cycles" => format!("{:.0}", estimate.value),
        "fps" => format!("{:.1}", estimate.value),
        _ => format!("{} MB", mb(estimate.value.round() as u64)),
    };
    match estimate.half_width() {
        0.0 => value,
        half => format!("{value} ± {:.1} %", 100.0 * half),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_wide_is_no_number() {
        let of = |low, high| text("cycles", Estimate { value: 1000.0, low, high });
        assert_eq!(of(900.0, 1100.0), "1000 ± 10.0 %");
        assert_eq!(of(700.0, 1300.0), NOT_KNOWN);
        assert_eq!(text("pci_bytes", Estimate::exact(2097152.0)), "2.00 MB");
    }
}
