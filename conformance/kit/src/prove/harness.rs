//! The module in which the implementation and the specification of one set stand side by side, with what is claimed.

use super::checker;
use super::config::{DataPorts, ProveConfig};
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
    ("data", "!judged || !want_of_byte || ahead >= OUTSTANDING || dut_byte == want_byte", "wrong byte"),
    ("evicted", "!judged || !want_evicts || dut_evicted == want_evicted", "wrong line evicted"),
    ("evicts", "!judged || want_hit || dut_evicts == want_evicts", "wrong about an eviction"),
    ("hit", "!judged || dut_hit == want_hit", "wrong about a hit"),
    ("late", "!is_due || host_works || waited + 1 < LATENCY", "no answer within the clocks of 'latency'"),
    ("load", "!load || !loading", "a line is asked for while another is loaded"),
    (
        "loaded",
        "!judged || !want_of_byte || ahead < OUTSTANDING",
        "the line of an answer was not loaded once for each miss",
    ),
    ("outstanding", "!accepted || rest < OUTSTANDING", "more requests are taken than 'outstanding' says"),
    ("stable", "!stalled || answer_valid", "an answer is withdrawn that was not taken"),
    ("unasked", "!answer_valid || is_there", "an answer without a request"),
    ("way", "!judged || dut_way == want_way", "wrong way"),
];

/// The claims about outputs that the implementation has.
pub fn claims(config: &ProveConfig) -> impl Iterator<Item = &'static Claim> {
    let (answer, data) = (config.answer.clone(), config.data.clone());
    CLAIMS.iter().filter(move |(name, ..)| match *name {
        "data" | "loaded" => data.is_some(),
        "load" => data.as_ref().is_some_and(|data| data.load_ready.is_none()),
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
    if config.data.is_some() {
        let when = "judged && want_of_byte && want_hit && want_number == 2";
        covers.push(("a hit of a byte that was loaded again".to_owned(), when.to_owned()));
    }
    covers
}

/// Bits of what is kept of a request until it is answered.
pub const ENTRY: usize = 108;
/// Its bit that says whether it reads a line of the set; below are the hit, the eviction, the way, and both addresses; above is
/// what is kept of bytes, and the request itself.
pub const MINE: usize = 70;
/// Its bit that says whether a line is evicted.
pub const EVICTS: usize = 68;
/// The bits of the address of that line.
pub const EVICTED: std::ops::Range<usize> = 32..64;

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
pub const PLANTED: [&str; 6] = [
    "the hit is inverted",
    "the top bit of the address is stuck at 0",
    "the lowest bit of the way is stuck at 0",
    "no line is ever evicted",
    "invalidations are dropped",
    "the lowest bit of each byte is stuck at 0",
];

/// The faults at the ports that an implementation can have: their bits, and what they do.
pub fn planted(config: &ProveConfig, cache: &CacheConfig) -> Vec<(usize, &'static str)> {
    let can_have = [
        true,
        true,
        cache.geometry.ways() > 1,
        config.answer.evicts.is_some(),
        config.request.invalidate.is_some(),
        config.data.is_some(),
    ];
    PLANTED.into_iter().enumerate().filter(|(bit, _)| can_have[*bit]).collect()
}

/// The module `saarcor_prove`.
///
/// Bit n of its output `happens` says that claim n is violated. Macros choose among its forms: `SAARCOR_COVER` for what has to
/// be reached in the place of violations; `SAARCOR_PLANTED` for a violation with the one or the other fault, of which as many
/// are in the state as there are `parts`; `SAARCOR_SMT` for SMT, where the set is a constant and claims are assertions;
/// `SAARCOR_COLD` for a cold set in the place of the reset, of which a search has one clock; `SAARCOR_INDUCTION` for what an induction needs beside the claims:
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
    let mut text = String::from(
        "// Generated: an implementation beside the specification of one of its sets.\nmodule saarcor_prove(\n    input clock, free_reset, free_valid, free_forget, free_ready,\n    input [31:0] free_address, free_witness",
    );
    let _ = write!(text, ",\n    input [{}:0] free_planted", PLANTED_BITS - 1);
    for (name, width) in free {
        let _ = write!(text, ",\n    input [{}:0] env_{name}", width - 1);
    }
    if let Some(data) = &config.data {
        let _ = write!(
            text,
            ",\n    input free_load_ready, free_fill,\n    input [31:0] free_byte,\n    input [{}:0] free_fill_data",
            data.fill_bits - 1
        );
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
`ifdef SAARCOR_INDUCTION
    wire reset = 0;
`else
    // Registers begin as a reset leaves them.
    wire reset = first;
`endif
`else
    wire reset = first || free_reset;
`endif
{witness}`ifdef SAARCOR_PLANTED
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
{data_ports}    wire dut_hit = raw_hit ^ planted[0];
    assign dut_address = planted[1] ? address & 32'h7fffffff : address;
    wire [31:0] dut_card = planted[2] ? raw_card & ~32'h{way_bit:x} : raw_card;
    wire [3:0] dut_way = planted[2] ? raw_way & ~4'h1 : raw_way;
    wire dut_evicts = raw_evicts && !planted[3];
    assign dut_forget = forget && !planted[4];
",
        witness = witness(config, cache),
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
        data_ports = config.data.as_ref().map(data_ports).unwrap_or_default(),
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
{host}    // What is to be answered, the oldest request first: so many are taken, and so many of them are waiting.
    reg [ENTRY*OUTSTANDING-1:0] queue = 0;
    reg [3:0] count = 0;
    reg [7:0] waited = 0;
    reg stalled = 0;
    wire [3:0] known = count - waits;
    wire answered = answer_valid && answer_ready && !reset;
    wire [ENTRY-1:0] asked = {{step_address, number, step_forgets, mine && !step_forgets, hit, evicts, way, evicted, card}};
    wire is_there = known != 0 || (EARLY && step);
    wire is_due = EARLY ? accepted && !answer_valid : count != 0 && !answer_valid;
    wire [3:0] rest = answered ? count - 4'd1 : count;
    wire [3:0] rest_known = answered ? known - 4'd1 : known;
    integer i;
    always @(posedge clock) begin
        stalled <= answer_valid && !answer_ready && !reset;
        waited <= reset || !is_due ? 0 : host_works ? waited : waited + 1;
        count <= reset ? 0 : accepted ? rest + 1 : rest;
        waits <= reset ? 0 : waits + accepted - step;
        if (accepted) waiting <= {{forget, address}};
        for (i = 0; i < OUTSTANDING; i = i + 1)
            if (step && rest_known == i) queue[i*ENTRY +: ENTRY] <= asked;
            else if (answered && i + 1 < OUTSTANDING) queue[i*ENTRY +: ENTRY] <= queue >> ((i + 1) * ENTRY);
    end
    wire want_forgets, want_mine, want_hit, want_evicts;
    wire [3:0] want_number, want_way;
    wire [31:0] want_address, want_evicted, want_card;
    wire [ENTRY-1:0] wanted = known != 0 ? queue[ENTRY-1:0] : asked;
    assign {{want_address, want_number, want_forgets, want_mine, want_hit, want_evicts, want_way, want_evicted, want_card}} = wanted;
    wire judged = answer_valid && is_there && want_mine && !reset;
{bytes}`ifdef SAARCOR_COVER
",
        bytes = bytes(config.data.as_ref(), cache),
        commit = steps(config, found),
        host = host(config.data.as_ref(), cache),
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
    if config.data.is_some() {
        let _ = write!(
            text,
            "        state_mine: assert(known == 0 || want_mine == (!want_forgets && (want_sum & ((1 << SET_BITS) - 1)) == witness));
        state_beat: assert(loading || beat == 0);
        state_youngest: assert(known == 0 || !youngest_mine || youngest_number == misses);
        state_kept: assert(known == 0 || !youngest_mine || youngest_resident);
"
        );
    }
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

/// The set that is looked at: any; or the set of the byte that is looked at, where it is any byte.
fn witness(config: &ProveConfig, cache: &CacheConfig) -> String {
    let any = |name: &str, free: &str| {
        format!(
            "`ifdef SAARCOR_SMT
    (* anyconst *) wire [31:0] {name};
`else
    reg [31:0] kept = 0;
    wire [31:0] {name} = first ? {free} : kept;
    always @(posedge clock) kept <= {name};
`endif
"
        )
    };
    let sets = cache.geometry.sets() - 1;
    let (any, number) = if config.data.is_some() {
        let number = format!("(byte_address >> {})", cache.geometry.line().0.trailing_zeros());
        (any("byte_address", "free_byte"), checker::sum(cache, &number))
    } else {
        (any("any", "free_witness"), "any".to_owned())
    };
    format!("{any}    wire [31:0] witness = ({number}) & 32'h{sets:x};\n")
}

/// The wires of the ports of bytes.
fn data_ports(data: &DataPorts) -> String {
    let always = if data.fill_ready.is_some() { "" } else { " = 1" };
    format!(
        "    wire load, load_ready, fill, fill_ready{always};
    wire [31:0] load_address;
    wire [{}:0] raw_data;
    wire [{}:0] fill_data = free_fill_data;
",
        data.answer_bits - 1,
        data.fill_bits - 1,
    )
}

/// The host, of which one byte is looked at, as an implementation that has the bytes of lines sees it.
fn host(data: Option<&DataPorts>, cache: &CacheConfig) -> String {
    let Some(data) = data else {
        return "    wire host_works = 0;\n    wire [3:0] number = 0;\n".to_owned();
    };
    let (line, fill) = (cache.geometry.line().0, u64::from(data.fill_bits / 8));
    let beats = line / fill;
    format!(
        "    // One line is loaded at a time.
    reg loading = 0, loads_byte = 0;
    reg [{beat_top}:0] beat = 0;
    assign load_ready = {load_ready}!loading;
    wire loads = load && load_ready && !reset;
    assign fill = free_fill && loading && !reset;
    wire filled = fill && fill_ready;
    wire is_last = filled && beat == {last_beat};
    (* keep *) wire asks = load || loading;
    wire host_works = loading || load && !load_ready;
    always @(posedge clock) begin
        loading <= (loading || loads) && !reset && !is_last;
        beat <= loading && !reset && !is_last ? beat + filled : 0;
        loads_byte <= reset ? 0 : loads ? load_address >> {line_bits} == byte_address >> {line_bits} : loading && loads_byte;
    end
    // The byte as it was brought for the first, the second miss of its line, and so on, modulo 16.
    reg [3:0] misses = 0, fills = 0;
    reg [127:0] brought = 0;
    wire [31:0] byte_beat = (byte_address & 32'h{offsets:x}) >> {fill_shift};
    wire brings = filled && loads_byte && beat == byte_beat;
    (* keep *) wire comes = loading && loads_byte && beat <= byte_beat;
    wire [7:0] brought_now = fill_data >> 8 * (byte_address & 32'h{fill_mask:x});
    wire [3:0] fills_now = fills + brings;
    wire is_of_line = step_address >> {line_bits} == byte_address >> {line_bits};
    wire [3:0] number = misses + (mine && !step_forgets && !hit && is_of_line);
    always @(posedge clock) begin
        misses <= reset ? 0 : step ? number : misses;
        fills <= reset ? 0 : fills_now;
        if (brings) brought[8 * fills_now +: 8] <= brought_now;
    end
",
        beat_top = beats.trailing_zeros().max(1) - 1,
        last_beat = beats - 1,
        load_ready = if data.load_ready.is_some() { "free_load_ready && " } else { "" },
        fill_shift = fill.trailing_zeros(),
        fill_mask = fill - 1,
        offsets = line - 1,
        line_bits = line.trailing_zeros(),
    )
}

/// The byte of an answer and the one that is right; and what an induction may need to know of where that byte lies.
fn bytes(data: Option<&DataPorts>, cache: &CacheConfig) -> String {
    let Some(data) = data else { return String::new() };
    let ways = cache.geometry.ways();
    let line_bits = cache.geometry.line().0.trailing_zeros();
    // What is kept is read by relations that are found, or by nobody.
    let mut text = format!(
        "    wire [7:0] dut_byte = (raw_data >> 8 * (byte_address & 32'h{answer_mask:x})) & (planted[5] ? 8'hfe : 8'hff);
    wire [7:0] want_byte = brings && fills_now == want_number ? brought_now : brought[8 * want_number +: 8];
    wire want_of_byte = want_address >> {answer_shift} == byte_address >> {answer_shift};
    wire [3:0] ahead = fills_now - want_number;
    (* keep *) wire [31:0] want_sum = {sum};
    // The youngest request that changed the state left its line where it is said to be.
    wire [ENTRY-1:0] youngest = queue >> (known - 4'd1) * ENTRY;
    wire youngest_mine = youngest[MINE];
    wire [3:0] youngest_number = youngest[MINE + 2 +: 4], youngest_way = youngest >> {line_bits} & {last_way};
    wire youngest_resident = resident[youngest_way] && lines[32 * youngest_way +: 32] == youngest[MINE + 6 +: 32] >> {line_bits};
    wire [3:0] left = misses - fills;
    // Misses whose byte has not come: none, one; 2 where it came for a miss that is not noted; else 3.
    (* keep *) wire [1:0] owed = left == 15 ? 2 : left < 2 ? left : 3;
    (* keep *) wire [7:0] byte_right = brought[8 * fills +: 8];
    (* keep *) wire known_hit = known != 0 && want_mine && want_hit;
    (* keep *) wire known_of_line = known != 0 && want_address >> {line_bits} == byte_address >> {line_bits};
    reg byte_resident;
    (* keep *) reg [3:0] byte_way;
    always @* begin
        byte_resident = 0;
        byte_way = way;
",
        answer_mask = data.answer_bits / 8 - 1,
        answer_shift = (data.answer_bits / 8).trailing_zeros(),
        last_way = ways - 1,
        sum = checker::sum(cache, &format!("(want_address >> {line_bits})")),
    );
    for way in 0..ways {
        let _ = writeln!(
            text,
            "        if (resident[{way}] && lines[{} +: 32] == byte_address >> {line_bits}) begin byte_resident = 1; byte_way = {way}; end",
            32 * way
        );
    }
    let _ = write!(
        text,
        "    end
    // It lies in its way: where its line is resident, and where it was loaded before that is noted.
    (* keep *) wire byte_lies = byte_resident ? owed == 0 : waits != 0 && mine && is_of_line && !step_forgets && owed == 2;
    wire [31:0] byte_offset = byte_address & 32'h{offsets:x};
    (* keep *) wire [31:0] byte_card = (((witness << {way_bits}) | byte_way) << {line_bits}) | byte_offset;
    (* keep *) wire [31:0] byte_apart = (((byte_way << SET_BITS) | witness) << {line_bits}) | byte_offset;
    (* keep *) wire [31:0] byte_in_way = (witness << {line_bits}) | byte_offset;
",
        way_bits = ways.trailing_zeros(),
        offsets = cache.geometry.line().0 - 1,
    );
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
