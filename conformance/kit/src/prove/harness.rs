//! The module in which the implementation and the specification of one set stand side by side, with what is claimed.

use super::config::ProveConfig;
use super::found::{COMMIT, Found};
use super::table::pairs;
use saarcor_model::vm::{CacheConfig, Policy};
use std::fmt::Write as _;

/// An input that the environment chooses: any value at each clock.
pub type FreeInput = (String, u32);

/// A claim: its name, the condition that holds in each clock without reset, and what is wrong where it does not.
pub type Claim = (&'static str, &'static str, &'static str);

/// What is claimed of each answer and of the handshake, in the order of the names, as netlists have them.
pub const CLAIMS: &[Claim] = &[
    ("card", "!judged || dut_card == want_card", "wrong card address"),
    ("evicted", "!judged || !want_evicts || dut_evicted == want_evicted", "wrong line evicted"),
    ("evicts", "!judged || want_hit || dut_evicts == want_evicts", "wrong about an eviction"),
    ("hit", "!judged || dut_hit == want_hit", "wrong about a hit"),
    ("late", "!is_due || waited + 1 < LATENCY", "no answer within the clocks of 'latency'"),
    ("outstanding", "!accepted || rest < OUTSTANDING", "more requests are taken than 'outstanding' says"),
    ("stable", "!stalled || answer_valid", "an answer is withdrawn that was not taken"),
    ("unasked", "!answer_valid || is_there", "an answer without a request"),
    ("way", "!judged || dut_way == want_way", "wrong way"),
];

/// The claims about outputs that the implementation has.
pub fn claims(config: &ProveConfig) -> impl Iterator<Item = &'static Claim> {
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
        covers.push(("an invalidation of a resident line".to_owned(), "step && mine && forgets".to_owned()));
    }
    covers
}

/// Bits of what is kept of a request until it is answered.
pub const ENTRY: usize = 72;
/// Its bit that says whether it reads a line of the set; below are the hit, the eviction, the way, and both addresses.
pub const MINE: usize = 70;

/// Bits of the order of a set, as the specification has it beside an implementation.
#[must_use]
pub fn order_bits(cache: &CacheConfig) -> usize {
    let ways = cache.geometry.ways() as usize;
    if cache.policy == Policy::Plru { (ways - 1).max(1) } else { (ways * (ways - 1) / 2).max(1) }
}

/// Bits of the input that plants a fault.
const PLANTED_BITS: usize = 16;
/// The first of its bits that plant faults in parts of the state.
pub const FIRST_PART: usize = 8;

/// Faults at the ports, which a run plants: the first bits of the input `free_planted`.
pub const PLANTED: [&str; 5] = [
    "the hit is inverted",
    "the top bit of the address is stuck at 0",
    "the lowest bit of the way is stuck at 0",
    "no line is ever evicted",
    "invalidations are dropped",
];

/// The faults at the ports that an implementation can have: their bits, and what they do.
pub fn planted(config: &ProveConfig, cache: &CacheConfig) -> Vec<(usize, &'static str)> {
    let can_have = [
        true,
        true,
        cache.geometry.ways() > 1,
        config.answer.evicts.is_some(),
        config.request.invalidate.is_some(),
    ];
    PLANTED.into_iter().enumerate().filter(|(bit, _)| can_have[*bit]).collect()
}

/// The module `saarcor_prove`.
///
/// Bit n of its output `happens` says that claim n is violated. Macros choose among its forms: `SAARCOR_COVER` for what has to
/// be reached in the place of violations; `SAARCOR_PLANTED` for a violation with the one or the other fault, of which as many
/// are in the state as there are `parts`; `SAARCOR_SMT` for SMT, where the set is a constant and claims are assertions;
/// `SAARCOR_COLD` for a cold set in the place of the reset; `SAARCOR_INDUCTION` for what an induction needs beside the claims:
/// the relations that were found, and, with `SAARCOR_STATE`, claims about the state that is shown. Each bit of `free_planted`
/// stands for a fault: those of [`PLANTED`], and in parts of the state from [`FIRST_PART`] on.
#[must_use]
pub fn verilog(
    config: &ProveConfig,
    cache: &CacheConfig,
    free: &[FreeInput],
    parts: usize,
    found: &Found,
) -> String {
    let ways = cache.geometry.ways() as usize;
    let way_bits = cache.geometry.ways().trailing_zeros();
    let line_bits = cache.geometry.line().0.trailing_zeros();
    let tag_bits = 32 - line_bits;
    let sets = cache.geometry.sets() - 1;
    let mut text = String::from(
        "// Generated: an implementation beside the specification of one of its sets.\nmodule saarcor_prove(\n    input clock, free_reset, free_valid, free_forget, free_ready,\n    input [31:0] free_address, free_witness",
    );
    let _ = write!(text, ",\n    input [{}:0] free_planted", PLANTED_BITS - 1);
    for (name, width) in free {
        let _ = write!(text, ",\n    input [{}:0] env_{name}", width - 1);
    }
    for (name, width) in found.inputs(cache) {
        let _ = write!(text, ",\n    input [{}:0] {name}", width - 1);
    }
    let covers = covers(config, ways as u32);
    let mut faults: Vec<_> = planted(config, cache).into_iter().map(|(bit, _)| bit).collect();
    faults.extend((0..parts).map(|part| FIRST_PART + part));
    let _ = write!(
        text,
        ",\n`ifdef SAARCOR_COVER\n    output [{}:0] happens\n`elsif SAARCOR_PLANTED\n    output [{}:0] happens\n`else\n    \
         output [{}:0] happens\n`endif\n",
        covers.len() - 1,
        faults.len() - 1,
        claims(config).count() - 1
    );
    let _ = write!(
        text,
        ");
    localparam OUTSTANDING = {outstanding}, LATENCY = {latency}, EARLY = {early}, ENTRY = {ENTRY}, MINE = {MINE}, SET_BITS = {set_bits};
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
`ifdef SAARCOR_PLANTED
    reg [{planted_top}:0] kept_planted = 0;
    wire [{planted_top}:0] planted = first ? free_planted : kept_planted;
    always @(posedge clock) kept_planted <= planted;
`else
    wire [{planted_top}:0] planted = 0;
`endif
    wire valid = free_valid;
    wire forget = {forget};
    wire [31:0] address = free_address;
    wire answer_ready = {answer_ready};
    wire ready{ready};
    wire raw_hit, raw_evicts, answer_valid, dut_forget;
    wire [31:0] dut_address, dut_evicted, raw_card;
    wire [{way_top}:0] raw_way;
    wire [{ways_top}:0] shown_resident;
    wire [{tags_top}:0] shown_tags;
    wire [{ages_top}:0] shown_ages;
    wire [{tree_top}:0] shown_tree;
    wire shown_waiting, shown_forget, shown_commit;
    wire [31:0] shown_address;
    wire dut_hit = raw_hit ^ planted[0];
    assign dut_address = planted[1] ? address & 32'h7fffffff : address;
    wire [31:0] dut_card = planted[2] ? raw_card & ~32'h{way_bit:x} : raw_card;
    wire [3:0] dut_way = planted[2] ? raw_way & ~4'h1 : raw_way;
    wire dut_evicts = raw_evicts && !planted[3];
    assign dut_forget = forget && !planted[4];
",
        planted_top = PLANTED_BITS - 1,
        outstanding = config.outstanding,
        // At once is within one clock.
        latency = config.latency.max(1),
        early = u32::from(config.latency == 0),
        set_bits = cache.geometry.set_bits(),
        forget = if config.request.invalidate.is_some() { "free_forget" } else { "0" },
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
    let order_top = order_bits(cache) - 1;
    let _ = write!(
        text,
        "    wire accepted = valid && ready && !reset;
    // The request that changes the state in this clock.
    reg [32:0] waiting = 0;
    reg [3:0] waits = 0;
{commit}    wire mine, hit, evicts, legal, forgets, present;
    wire [{ways_top}:0] matches;
    wire [3:0] way;
    wire [31:0] evicted, card, sum;
    wire [{ways_top}:0] resident;
    wire [{lines_top}:0] lines;
    wire [{order_top}:0] order;
    saarcor_set set(clock, reset, step, step_forgets, step_address, witness, mine, hit, evicts, way, evicted, card, sum,
        matches, present, resident, lines, order, legal, forgets);
    // What is to be answered, the oldest request first: so many are taken, and so many of them are waiting.
    reg [ENTRY*OUTSTANDING-1:0] queue = 0;
    reg [3:0] count = 0;
    reg [7:0] waited = 0;
    reg stalled = 0;
    wire [3:0] known = count - waits;
    wire answered = answer_valid && answer_ready && !reset;
    wire [ENTRY-1:0] asked = {{1'b0, mine && !step_forgets, hit, evicts, way, evicted, card}};
    wire is_there = known != 0 || (EARLY && step);
    wire is_due = EARLY ? accepted && !answer_valid : count != 0 && !answer_valid;
    wire [3:0] rest = answered ? count - 4'd1 : count;
    wire [3:0] rest_known = answered ? known - 4'd1 : known;
    integer i;
    always @(posedge clock) begin
        stalled <= answer_valid && !answer_ready && !reset;
        waited <= reset || !is_due ? 0 : waited + 1;
        count <= reset ? 0 : accepted ? rest + 1 : rest;
        waits <= reset ? 0 : waits + accepted - step;
        if (accepted) waiting <= {{forget, address}};
        for (i = 0; i < OUTSTANDING; i = i + 1)
            if (step && rest_known == i) queue[i*ENTRY +: ENTRY] <= asked;
            else if (answered && i + 1 < OUTSTANDING) queue[i*ENTRY +: ENTRY] <= queue >> ((i + 1) * ENTRY);
    end
    wire want_mine, want_hit, want_evicts;
    wire [3:0] want_way;
    wire [31:0] want_evicted, want_card;
    wire [ENTRY-1:0] wanted = known != 0 ? queue[ENTRY-1:0] : asked;
    assign {{want_mine, want_hit, want_evicts, want_way, want_evicted, want_card}} = wanted[ENTRY-2:0];
    wire judged = answer_valid && is_there && want_mine && !reset;
`ifdef SAARCOR_COVER
",
        commit = steps(config, found),
        ways_top = ways - 1,
        lines_top = 32 * ways - 1,
    );
    for (n, (_, when)) in covers.iter().enumerate() {
        let _ = writeln!(text, "    assign happens[{n}] = !reset && ({when});");
    }
    text.push_str("`elsif SAARCOR_SMT\n");
    for (name, condition, _) in claims(config) {
        let _ = writeln!(text, "    always @* if (!reset) claim_{name}: assert({condition});");
    }
    text.push_str("    assign happens = 0;\n`else\n");
    // The last stands first: bit 0 is the first claim's.
    let mut violations: Vec<_> = claims(config).map(|(_, condition, _)| format!("!({condition})")).collect();
    violations.reverse();
    let _ = writeln!(
        text,
        "    wire [{0}:0] violated = reset ? 0 : {{{1}}};\n`ifdef SAARCOR_PLANTED",
        violations.len() - 1,
        violations.join(", ")
    );
    for (n, bit) in faults.iter().enumerate() {
        let _ = writeln!(
            text,
            "    assign happens[{n}] = planted == {PLANTED_BITS}'d{} && violated != 0;",
            1 << bit
        );
    }
    text.push_str("`else\n    assign happens = violated;\n`endif\n`endif\n`ifdef SAARCOR_INDUCTION\n    // A reset may clear the implementation at once, and the specification with the next clock.\n    always @* if (!first && !reset) begin\n");
    text.push_str("        state_count: assert(count <= OUTSTANDING && waits <= count && waited < LATENCY);\n        state_legal: assert(legal);\n");
    for (n, relation) in found.relations.iter().enumerate() {
        let _ = writeln!(text, "        {RELATION}{n}: assert({});", relation.text);
    }
    text.push_str("    end\n`endif\n`ifdef SAARCOR_STATE\n");
    state_claims(&mut text, config, cache, tag_bits, way_bits.max(1));
    text.push_str("`endif\n`ifdef SAARCOR_COLD\n");
    assume_cold(&mut text, config, cache, way_bits.max(1), found);
    text.push_str("`endif\nendmodule\n");
    text
}

/// The name of a relation that was found, before its number.
pub const RELATION: &str = "relation_";

/// When a request changes the state of the specification: when it is taken, or, where the implementation says when, the oldest
/// that is waiting.
fn steps(config: &ProveConfig, found: &Found) -> String {
    let at_once = "    wire step = accepted;
    wire step_forgets = forget;
    wire [31:0] step_address = address;
";
    let waiting = |commit: &str| {
        format!(
            "    wire step = ({commit}) && waits != 0 && !reset;
    wire step_forgets = waiting[32];
    wire [31:0] step_address = waiting[31:0];
"
        )
    };
    if let Some(commit) = &found.commit {
        waiting(&format!("{COMMIT} == {}'d{}", commit.width, commit.value))
    } else if config.state.as_ref().is_some_and(|state| state.waiting.is_some()) {
        format!("`ifdef SAARCOR_STATE\n{}`else\n{at_once}`endif\n", waiting("shown_commit"))
    } else {
        at_once.to_owned()
    }
}

/// That the state which is shown is the specification's.
fn state_claims(text: &mut String, config: &ProveConfig, cache: &CacheConfig, tag_bits: u32, way_bits: u32) {
    let ways = cache.geometry.ways() as usize;
    text.push_str(
        "    always @* if (!first && !reset) begin\n        state_resident: assert(shown_resident == resident);\n",
    );
    for way in 0..ways {
        let low = way as u32 * tag_bits;
        let _ = writeln!(
            text,
            "        state_tag{way}: assert(!resident[{way}] || shown_tags[{low} +: {tag_bits}] == lines[{} +: 32]);",
            32 * way
        );
    }
    if let Some(waiting) = config.state.as_ref().and_then(|state| state.waiting.as_ref()) {
        text.push_str(
            "        state_waiting: assert(shown_waiting == (waits != 0) && waits <= 1);\n        \
             state_commit: assert(!shown_commit || waits != 0);\n        \
             state_address: assert(waits == 0 || shown_address == waiting[31:0]);\n        \
             state_known: assert(known == answer_valid);\n",
        );
        if waiting.invalidate.is_some() {
            text.push_str("        state_forget: assert(waits == 0 || shown_forget == waiting[32]);\n");
        }
    }
    let ages = cache.policy != Policy::Plru && ways > 1;
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
    text.push_str("    end\n");
}

/// That the set is cold in the first clock, as after a reset: what is shown says so, and what was found stands to a cold set as
/// it should.
fn assume_cold(text: &mut String, config: &ProveConfig, cache: &CacheConfig, way_bits: u32, found: &Found) {
    let ways = cache.geometry.ways();
    text.push_str("    always @* if (first) begin\n        assume(!answer_valid);\n");
    for relation in &found.relations {
        let _ = writeln!(text, "        assume({});", relation.text);
    }
    if let Some(state) = &config.state {
        text.push_str("        assume(shown_resident == 0);\n");
        if state.waiting.is_some() {
            text.push_str("        assume(!shown_waiting);\n");
        }
        if cache.policy == Policy::Plru && ways > 1 {
            text.push_str("        assume(shown_tree == 0);\n");
        } else if ways > 1 {
            for way in 0..ways {
                let _ =
                    writeln!(text, "        assume(shown_ages[{} +: {way_bits}] == {way});", way * way_bits);
            }
        }
    }
    text.push_str("    end\n");
}
