//! The module in which the implementation and the specification of one set stand side by side, with what is claimed.

use super::config::ProveConfig;
use super::table::pairs;
use saarcor_model::vm::{CacheConfig, Policy};
use std::fmt::Write as _;

/// An input that the environment chooses: any value at each clock.
pub type FreeInput = (String, u32);

/// What is claimed of each answer and of the handshake, in the order of the names, as netlists have them: names with the conditions that must hold, and what a violation
/// says.
pub const CLAIMS: &[(&str, &str, &str)] = &[
    ("card", "!judged || dut_card == want_card", "card address"),
    ("evicted", "!judged || !want_evicts || dut_evicted == want_evicted", "the evicted line"),
    ("evicts", "!judged || want_hit || dut_evicts == want_evicts", "whether a line is evicted"),
    ("hit", "!judged || dut_hit == want_hit", "hit"),
    (
        "late",
        "count == 0 || answer_valid || waited + 1 < LATENCY",
        "no answer within the clocks of 'latency'",
    ),
    ("outstanding", "!accepted || rest < OUTSTANDING", "more requests are taken than 'outstanding' says"),
    ("stable", "!stalled || answer_valid", "an answer is withdrawn that was not taken"),
    ("unasked", "!answer_valid || count != 0", "an answer without a request"),
    ("way", "!judged || dut_way == want_way", "way"),
];

/// The claims about outputs that the implementation has.
pub fn claims(
    config: &ProveConfig,
) -> impl Iterator<Item = &'static (&'static str, &'static str, &'static str)> {
    let answer = config.answer.clone();
    CLAIMS.iter().filter(move |(name, ..)| match *name {
        "way" => answer.way.is_some(),
        "card" => answer.card.is_some(),
        "evicts" => answer.evicts.is_some(),
        "evicted" => answer.evicted.is_some(),
        _ => true,
    })
}

/// What has to be reached, or the claims are empty: what, and when.
#[must_use]
pub fn covers(config: &ProveConfig, ways: u32) -> Vec<(String, String)> {
    let mut covers = vec![
        ("a hit".to_owned(), "judged && want_hit".to_owned()),
        ("a miss without an eviction".to_owned(), "judged && !want_hit && !want_evicts".to_owned()),
    ];
    covers.extend((0..ways).map(|way| {
        (format!("an eviction of way {way}"), format!("judged && want_evicts && want_way == {way}"))
    }));
    if config.request.invalidate.is_some() {
        covers.push((
            "an invalidation of a resident line".to_owned(),
            "accepted && mine && forgets".to_owned(),
        ));
    }
    covers
}

/// A fault that a run plants of its own: its name, and what it does.
pub const PLANTED: &[(&str, &str)] = &[
    ("FAULT_HIT", "the hit is inverted"),
    ("FAULT_TAG", "the top bit of the address is stuck at 0"),
    ("FAULT_WAY", "the lowest bit of the way is stuck at 0"),
    ("FAULT_EVICTS", "no line is ever evicted"),
    ("FAULT_FORGET", "invalidations are dropped"),
];

/// The faults that an implementation can have.
pub fn planted<'a>(
    config: &'a ProveConfig,
    cache: &'a CacheConfig,
) -> impl Iterator<Item = &'static (&'static str, &'static str)> + 'a {
    PLANTED.iter().filter(|(name, _)| match *name {
        "FAULT_FORGET" => config.request.invalidate.is_some(),
        "FAULT_WAY" => cache.geometry.ways() > 1,
        "FAULT_EVICTS" => config.answer.evicts.is_some(),
        _ => true,
    })
}

/// The module `saarcor_prove`.
///
/// Macros choose among its forms: `SAARCOR_SMT` for SMT, where the set is a constant; `SAARCOR_COLD` for a cold set in
/// the place of the reset; `SAARCOR_COVER` for what has to be reached in the place of the claims; `SAARCOR_STATE` for
/// the claims about the state that is shown; and the faults of [`PLANTED`].
#[must_use]
pub fn verilog(config: &ProveConfig, cache: &CacheConfig, address_bits: u32, free: &[FreeInput]) -> String {
    let ways = cache.geometry.ways() as usize;
    let way_bits = cache.geometry.ways().trailing_zeros();
    let line_bits = cache.geometry.line().0.trailing_zeros();
    let tag_bits = 32 - line_bits;
    let sets = cache.geometry.sets() - 1;
    let mut text = String::from(
        "// Generated: an implementation beside the specification of one of its sets.\nmodule saarcor_prove(\n    input clock, free_reset, free_valid, free_forget, free_ready,\n    input [31:0] free_address, free_witness",
    );
    for (name, width) in free {
        let _ = write!(text, ",\n    input [{}:0] env_{name}", width - 1);
    }
    let _ = write!(
        text,
        ");
    localparam OUTSTANDING = {outstanding}, LATENCY = {latency}, ENTRY = 72;
    reg first = 1;
    always @(posedge clock) first <= 0;
`ifdef SAARCOR_COLD
    wire reset = 0;
`else
    wire reset = first || free_reset;
`endif
`ifdef SAARCOR_SMT
    (* anyconst *) wire [31:0] any;
    wire [31:0] witness = any & 32'h{sets:x};
`else
    reg [31:0] kept = 0;
    wire [31:0] witness = (first ? free_witness : kept) & 32'h{sets:x};
    always @(posedge clock) kept <= witness;
`endif
    wire valid = free_valid;
    wire forget = {forget};
    wire [31:0] address = free_address & 32'h{address_mask:x};
    wire answer_ready = {answer_ready};
    wire ready{ready};
    wire raw_hit, raw_evicts, answer_valid, dut_forget;
    wire [31:0] dut_address, dut_evicted, raw_card;
    wire [{way_top}:0] raw_way;
    wire [{ways_top}:0] shown_resident;
    wire [{tags_top}:0] shown_tags;
    wire [{ages_top}:0] shown_ages;
    wire [{tree_top}:0] shown_tree;
`ifdef FAULT_HIT
    wire dut_hit = !raw_hit;
`else
    wire dut_hit = raw_hit;
`endif
`ifdef FAULT_EVICTS
    wire dut_evicts = 0;
`else
    wire dut_evicts = raw_evicts;
`endif
`ifdef FAULT_TAG
    assign dut_address = address & 32'h7fffffff;
`else
    assign dut_address = address;
`endif
`ifdef FAULT_FORGET
    assign dut_forget = 0;
`else
    assign dut_forget = forget;
`endif
`ifdef FAULT_WAY
    wire [31:0] dut_card = raw_card & ~32'h{way_bit:x};
    wire [3:0] dut_way = raw_way & ~4'h1;
`else
    wire [31:0] dut_card = raw_card;
    wire [3:0] dut_way = raw_way;
`endif
",
        outstanding = config.outstanding,
        latency = config.latency,
        forget = if config.request.invalidate.is_some() { "free_forget" } else { "0" },
        address_mask = (1_u64 << address_bits) - 1,
        answer_ready = if config.answer.ready.is_some() { "free_ready" } else { "1" },
        ready = if config.request.ready.is_some() { "" } else { " = 1" },
        way_top = way_bits.max(1) - 1,
        ways_top = ways - 1,
        tags_top = ways as u32 * tag_bits - 1,
        ages_top = ways as u32 * way_bits.max(1) - 1,
        tree_top = (ways - 1).max(1) - 1,
        way_bit = 1_u64 << line_bits,
    );
    let parameters: Vec<_> = config
        .parameters
        .iter()
        .map(|(name, value)| format!(".{name}({})", config.value(value, cache)))
        .collect();
    let parameters =
        if parameters.is_empty() { String::new() } else { format!(" #({})", parameters.join(", ")) };
    let mut ports: Vec<_> =
        config.ports(cache).iter().map(|port| format!(".{}({})", port.name, port.wire)).collect();
    ports.extend(free.iter().map(|(name, _)| format!(".{name}(env_{name})")));
    let _ = writeln!(text, "    {}{parameters} dut({});", config.top, ports.join(", "));
    let order_top = (ways * (ways - 1) / 2).max(1) - 1;
    let order_top = if cache.policy == Policy::Plru { (ways - 1).max(1) - 1 } else { order_top };
    let _ = write!(
        text,
        "    wire accepted = valid && ready && !reset;
    wire mine, hit, evicts, legal, forgets;
    wire [3:0] way;
    wire [31:0] evicted, card;
    wire [{}:0] resident;
    wire [{}:0] lines;
    wire [{order_top}:0] order;
    saarcor_set set(clock, reset, accepted, forget, address, witness, mine, hit, evicts, way, evicted, card, resident, lines,
        order, legal, forgets);
    // What is to be answered, the oldest request first.
    reg [ENTRY*OUTSTANDING-1:0] queue = 0;
    reg [3:0] count = 0;
    reg [7:0] waited = 0;
    reg stalled = 0;
    wire answered = answer_valid && answer_ready && !reset;
    wire [ENTRY-1:0] asked = {{1'b0, mine && !forget, hit, evicts, way, evicted, card}};
    wire [3:0] rest = answered ? count - 4'd1 : count;
    integer i;
    always @(posedge clock) begin
        stalled <= answer_valid && !answer_ready && !reset;
        waited <= reset || answer_valid || count == 0 ? 0 : waited + 1;
        count <= reset ? 0 : accepted ? rest + 1 : rest;
        for (i = 0; i < OUTSTANDING; i = i + 1)
            if (accepted && rest == i) queue[i*ENTRY +: ENTRY] <= asked;
            else if (answered && i + 1 < OUTSTANDING) queue[i*ENTRY +: ENTRY] <= queue >> ((i + 1) * ENTRY);
    end
    wire want_mine, want_hit, want_evicts;
    wire [3:0] want_way;
    wire [31:0] want_evicted, want_card;
    assign {{want_mine, want_hit, want_evicts, want_way, want_evicted, want_card}} = queue[ENTRY-2:0];
    wire judged = answered && want_mine && count != 0;
`ifdef SAARCOR_COVER
",
        ways - 1,
        32 * ways - 1,
    );
    for (n, (_, when)) in covers(config, ways as u32).iter().enumerate() {
        let _ = writeln!(text, "    always @* if (!reset) cover{n:02}: assert(!({when}));");
    }
    text.push_str("`else\n");
    for (name, condition, _) in claims(config) {
        let _ = writeln!(text, "    always @* if (!reset) claim_{name}: assert({condition});");
    }
    text.push_str("`endif\n`ifdef SAARCOR_STATE\n");
    state_claims(&mut text, config, cache, tag_bits, way_bits.max(1));
    text.push_str("`endif\nendmodule\n");
    text
}

/// That the state which is shown is the specification's, and that a cold set is assumed where there is no reset.
fn state_claims(text: &mut String, config: &ProveConfig, cache: &CacheConfig, tag_bits: u32, way_bits: u32) {
    let ways = cache.geometry.ways() as usize;
    text.push_str("    always @* if (!first) begin\n        state_count: assert(count <= OUTSTANDING && waited < LATENCY);\n        state_legal: assert(legal);\n        state_resident: assert(shown_resident == resident);\n");
    for way in 0..ways {
        let low = way as u32 * tag_bits;
        let _ = writeln!(
            text,
            "        state_tag{way}: assert(!resident[{way}] || shown_tags[{low} +: {tag_bits}] == lines[{} +: 32]);",
            32 * way
        );
    }
    let ages = config.state.as_ref().is_some_and(|state| state.ages.is_some()) && ways > 1;
    if ages {
        for way in 0..ways {
            let younger: Vec<_> = pairs(ways)
                .enumerate()
                .filter_map(|(bit, (a, b))| match way {
                    _ if way == a => Some(format!("{{7'b0, order[{bit}]}}")),
                    _ if way == b => Some(format!("{{7'b0, !order[{bit}]}}")),
                    _ => None,
                })
                .collect();
            let low = way as u32 * way_bits;
            let _ = writeln!(
                text,
                "        state_age{way}: assert(shown_ages[{low} +: {way_bits}] == {});",
                younger.join(" + ")
            );
        }
    } else if ways > 1 {
        text.push_str("        state_tree: assert(shown_tree == order);\n");
    }
    text.push_str("    end\n`ifdef SAARCOR_COLD\n    always @* if (first) begin\n        assume(shown_resident == 0 && !answer_valid);\n");
    if ages {
        for way in 0..ways {
            let _ = writeln!(
                text,
                "        assume(shown_ages[{} +: {way_bits}] == {way});",
                way as u32 * way_bits
            );
        }
    } else if ways > 1 {
        text.push_str("        assume(shown_tree == 0);\n");
    }
    text.push_str("    end\n`endif\n");
}
