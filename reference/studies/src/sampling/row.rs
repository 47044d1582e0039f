//! A row of a sample.

use super::estimate::Estimate;
use super::plan::{Plan, SampleFraction};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

/// An estimate with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The key of the same quantity in the row of a full run; inside objects, with dots between.
    pub name: String,
    /// What it is, and between which values.
    pub estimate: Estimate,
}

impl Quantity {
    /// An estimate of this name.
    pub fn new(name: impl Into<String>, estimate: Estimate) -> Self {
        Self { name: name.into(), estimate }
    }

    /// What a full run counted.
    pub fn counted(name: impl Into<String>, count: u64) -> Self {
        Self::new(name, Estimate::exact(count as f64))
    }

    /// The estimate and the ends of its interval. Counts are whole numbers, and their intervals begin and
    /// end with such.
    #[must_use]
    pub fn values(&self) -> [Value; 3] {
        let Estimate { estimate, low, high } = self.estimate;
        match self.name.as_str() {
            "fps" => [estimate, low, high].map(Value::from),
            _ => [estimate.round(), low.floor(), high.ceil()].map(|number| Value::from(number as u64)),
        }
    }
}

/// A frame of which a part was worked on in full. In JSON, the keys and the shape are those of a full
/// run's row, with the estimates in the place of the numbers, and again in `interval`, with the ends
/// of the intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleRow {
    /// What was run: names and values as in a full run's row.
    pub of: Vec<(&'static str, Value)>,
    /// The part that was asked for.
    pub sample: SampleFraction,
    /// Packets of the picture, and of these, packets that were worked on in full.
    pub packets: [usize; 2],
    /// What is estimated.
    pub quantities: Vec<Quantity>,
}

impl SampleRow {
    /// A row of a sample.
    #[must_use]
    pub fn new(
        of: Vec<(&'static str, Value)>,
        sample: SampleFraction,
        plan: &Plan,
        quantities: Vec<Quantity>,
    ) -> Self {
        Self { of, sample, packets: [plan.packets(), plan.sample.len()], quantities }
    }
}

impl Serialize for SampleRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row: Map<String, Value> =
            self.of.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        let [packets, in_full] = self.packets;
        row.insert("sample".to_owned(), self.sample.to_string().into());
        row.insert("packets".to_owned(), packets.into());
        row.insert("packets_in_full".to_owned(), in_full.into());
        let mut intervals = Map::new();
        for quantity in &self.quantities {
            let [estimate, low, high] = quantity.values();
            put(&mut row, &quantity.name, estimate);
            put(&mut intervals, &quantity.name, Value::from(vec![low, high]));
        }
        row.insert("interval".to_owned(), Value::Object(intervals));
        row.serialize(serializer)
    }
}

/// Puts a value into an object, and into objects inside it where the name has dots.
fn put(object: &mut Map<String, Value>, name: &str, value: Value) {
    match name.split_once('.') {
        None => {
            object.insert(name.to_owned(), value);
        }
        Some((outer, inner)) => {
            let inside = object.entry(outer).or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(inside) = inside {
                put(inside, inner, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::PacketOrder;
    use serde_json::json;

    #[test]
    fn rows_have_the_shape_of_full_runs() {
        let plan = Plan::new((12, 12), PacketOrder::Scan, SampleFraction::one_of(2), 0).expect("a plan");
        let estimate = Estimate { estimate: 10.4, low: 9.7, high: 11.2 };
        let quantities = vec![
            Quantity::new("cycles", estimate),
            Quantity::new("fps", estimate),
            Quantity::new("l1.list.hits", estimate),
            Quantity::counted("rays", 7),
        ];
        let row = SampleRow::new(vec![("frame", 3.into())], SampleFraction::one_of(2), &plan, quantities);
        let expected = json!({
            "frame": 3, "sample": "1/2", "packets": 144, "packets_in_full": 72,
            "cycles": 10, "fps": 10.4, "l1": {"list": {"hits": 10}}, "rays": 7,
            "interval": {
                "cycles": [9, 12], "fps": [9.7, 11.2], "l1": {"list": {"hits": [9, 12]}}, "rays": [7, 7],
            },
        });
        assert_eq!(serde_json::to_value(&row).expect("JSON"), expected);
    }
}
