//! The specification of one set in Verilog: the module that stands beside an implementation in a proof.
//!
//! The set is any, and stays the same: what holds of it holds of all. Its rows are those of a [`Table`].

use super::table::{Event, Literals, Table, pairs};
use saarcor_model::vm::{CacheConfig, Hash, Policy};
use std::fmt::Write as _;

/// By how much a line is shifted down for each of the summands whose lower bits are its set (VM-3).
#[must_use]
pub fn shifts(hash: Hash, set_bits: u32) -> Vec<u32> {
    match hash {
        Hash::Low => vec![0],
        Hash::AddUpper => vec![0, set_bits],
        // A group is added with what is above it, which the set's bits do not see.
        Hash::AddUpperAll => {
            (0..32).step_by(set_bits.max(1) as usize).take(if set_bits == 0 { 1 } else { 32 }).collect()
        }
    }
}

/// The sum, in Verilog, whose lowest bits are the set of a line.
#[must_use]
pub fn sum(config: &CacheConfig, line: &str) -> String {
    let shifts = shifts(config.hash, config.geometry.set_bits());
    shifts.iter().map(|shift| format!("({line} >> {shift})")).collect::<Vec<_>>().join(" + ")
}

/// The module `saarcor_set` of a cache with that table.
///
/// Its inputs are a request (`step`, `forget`, `address`), the set (`witness`) and `clear`, which forgets all lines. Its
/// outputs say whether the request is one of the set (`mine`; `sum`, of which the lowest bits are its set), what is to be answered, and the state: `resident`, `lines`
/// (a line of 32 bits a way), `order`, and whether both are `legal`.
#[must_use]
pub fn verilog(config: &CacheConfig, table: &Table) -> String {
    let geometry = config.geometry;
    let (ways, bits) = (table.ways, table.bits);
    let line_bits = geometry.line().0.trailing_zeros();
    let way_bits = geometry.ways().trailing_zeros();
    let order_bits = bits - ways;
    let mask = geometry.sets() - 1;
    let offsets = geometry.line().0 - 1;
    let mut text = format!(
        "// Generated from the specification's step: {ways} ways, {:?}.\n\
         module saarcor_set(\n    input clock, clear, step, forget,\n    input [31:0] address, witness,\n    \
         output mine,\n    output reg hit, evicts,\n    output reg [3:0] way,\n    output [31:0] evicted, card, sum,\n    \
         output [{}:0] matches,\n    output present,\n    \
         output [{}:0] resident,\n    output [{}:0] lines,\n    output [{}:0] order,\n    output reg legal, forgets\n);\n",
        table.policy,
        ways - 1,
        ways - 1,
        32 * ways - 1,
        order_bits.max(1) - 1,
    );
    let _ = writeln!(text, "    wire [31:0] line = address >> {line_bits};");
    let _ = writeln!(text, "    assign sum = {};", sum(config, "line"));
    let _ = writeln!(text, "    assign mine = (sum & 32'h{mask:x}) == witness;");
    let _ = writeln!(text, "    reg [{}:0] state = 0;", bits - 1);
    let _ = writeln!(text, "    reg [{}:0] next;", bits - 1);
    for way in 0..ways {
        let _ = writeln!(text, "    reg [31:0] line{way} = 0;");
        let _ = writeln!(text, "    wire match{way} = state[{way}] && line{way} == line;");
        let _ = writeln!(text, "    assign lines[{} +: 32] = line{way};", 32 * way);
    }
    let matches: Vec<_> = (0..ways).map(|way| format!("match{way}")).collect();
    let _ = writeln!(text, "    wire found = {};", matches.join(" || "));
    let all: Vec<_> = matches.iter().rev().map(String::as_str).collect();
    let _ = writeln!(text, "    assign matches = {{{}}};\n    assign present = found;", all.join(", "));
    let _ = writeln!(text, "    assign resident = state[{}:0];", ways - 1);
    match order_bits {
        0 => text.push_str("    assign order = 0;\n"),
        _ => {
            let _ = writeln!(text, "    assign order = state[{}:{ways}];", bits - 1);
        }
    }
    text.push_str("    reg [31:0] old;\n    always @* begin\n        hit = 0; evicts = 0; way = 0; next = state; old = 0; forgets = 0;\n");
    for row in &table.rows {
        let way = row.way;
        let condition = match row.event {
            Event::Hit => format!("!forget && match{way}"),
            Event::Forget => format!("forget && match{way}"),
            Event::Fill | Event::Evict => format!("!forget && !found{}", holds(row.when, bits)),
        };
        let says = match row.event {
            Event::Hit => "hit = 1;".to_owned(),
            Event::Fill => String::new(),
            Event::Evict => format!("evicts = 1; old = line{way};"),
            Event::Forget => "forgets = 1;".to_owned(),
        };
        let then = row.then;
        let _ = writeln!(
            text,
            "        if ({condition}) begin way = {way}; {says} next = (state & ~{bits}'h{:x}) | {bits}'h{:x}; end",
            then.mask, then.values
        );
    }
    text.push_str("    end\n");
    let _ = writeln!(text, "    assign evicted = old << {line_bits};");
    let _ = writeln!(
        text,
        "    assign card = (((witness << {way_bits}) | way) << {line_bits}) | (address & 32'h{offsets:x});"
    );
    text.push_str("    always @(posedge clock)\n        if (clear) state <= 0;\n        else if (step && mine) begin\n            state <= next;\n");
    for way in 0..ways {
        let _ = writeln!(text, "            if (!forget && !found && way == {way}) line{way} <= line;");
    }
    text.push_str("        end\n    always @* begin\n        legal = 1;\n");
    for (a, b) in pairs(ways) {
        let _ = writeln!(text, "        if (state[{a}] && state[{b}] && line{a} == line{b}) legal = 0;");
    }
    if table.policy != Policy::Plru {
        // An order: of three ways, none was used before the next all around.
        let bit = |a: usize, b: usize| {
            let place = pairs(ways).position(|pair| pair == (a.min(b), a.max(b))).unwrap_or(0) + ways;
            if a < b { format!("state[{place}]") } else { format!("!state[{place}]") }
        };
        for (a, b) in pairs(ways) {
            for c in b + 1..ways {
                let _ = writeln!(
                    text,
                    "        if ({} == {} && {} == {}) legal = 0;",
                    bit(a, b),
                    bit(b, c),
                    bit(b, c),
                    bit(c, a)
                );
            }
        }
    }
    text.push_str("    end\nendmodule\n");
    text
}

/// The condition of a row, behind others.
fn holds(when: Literals, bits: usize) -> String {
    format!(" && (state & {bits}'h{:x}) == {bits}'h{:x}", when.mask, when.values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use saarcor_model::vm::LineAddr;

    #[test]
    fn the_sum_of_shifts_is_the_hash() {
        let mut line = 1_u32;
        for set_bits in 0..=32 {
            let mask = (1_u64 << set_bits) - 1;
            for hash in [Hash::Low, Hash::AddUpper, Hash::AddUpperAll] {
                for _ in 0..200 {
                    line = line.wrapping_mul(0x9e37_79b1).rotate_left(7) ^ set_bits;
                    let sum: u64 = shifts(hash, set_bits).iter().map(|&by| u64::from(line) >> by).sum();
                    assert_eq!(
                        sum & mask,
                        u64::from(hash.set_of(LineAddr(line), set_bits).0),
                        "{hash:?} {set_bits}"
                    );
                }
            }
        }
    }
}
