// The virtual memory of the SaarCOR chip as a pipeline: a set-associative cache that takes a request a clock.
//
// Stage 1 holds a request as it was taken, and its set, so that the hash has a clock of its own. Stage 2 looks the set
// up, changes it and fills the answer register in one clock. So each request finds what the one before it left, and
// nothing has to be forwarded. An answer that is not taken stalls both stages. The memory behind the cache is outside:
// who takes the answer to a miss writes the line to its place on the card.
module pipelined_cache #(
    parameter LINE_BITS = 4,  // log2 of the bytes of a line
    parameter SET_BITS = 1,   // log2 of the sets
    parameter WAY_BITS = 2,   // log2 of the ways
    parameter HASH = 1,       // 0: low, 1: add-upper, 2: add-upper-all
    parameter POLICY = 1,     // 0: FIFO, 1: tree-PLRU
    localparam WAYS = 1 << WAY_BITS,
    localparam WAY_WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS,  // no vector has 0 bits
    localparam TREE_WIDTH = WAYS == 1 ? 1 : WAYS - 1,
    localparam TAG_BITS = 32 - LINE_BITS
) (
    input clock,
    input reset,                      // also the flush: forgets all lines
    input request_valid,
    output request_ready,
    input [31:0] request_address,     // host address
    input request_invalidate,         // forget the line, else read it
    output reg answer_valid,
    input answer_ready,
    output reg answer_hit,            // the line was resident
    output reg [WAY_WIDTH-1:0] answer_way,
    output reg [31:0] answer_card,    // where the byte of the address lies
    output reg answer_evicts,
    output reg [31:0] answer_evicted  // first host address of the evicted line
`ifdef SAARCOR_PROVE
    ,                                 // the state of one set and of stage 1, for proofs
    input [31:0] probe,
    output [WAYS-1:0] probe_resident,
    output [WAYS*TAG_BITS-1:0] probe_tags,
    output [TREE_WIDTH-1:0] probe_tree,
    output [WAYS*WAY_WIDTH-1:0] probe_ages,
    output probe_waiting, probe_waiting_invalidate, probe_commit,
    output [31:0] probe_waiting_address
`endif
);
    localparam SETS = 1 << SET_BITS;
    localparam SET_WIDTH = SET_BITS == 0 ? 1 : SET_BITS;
    localparam ORDER_WIDTH = POLICY == 1 ? TREE_WIDTH : WAYS * WAY_WIDTH;

    // How many bits of the line's number are added up, in groups of SET_BITS.
    localparam HASHED = SET_BITS == 0 ? 0 : HASH == 0 ? SET_BITS : HASH == 1 ? 2 * SET_BITS : TAG_BITS;

    function [SET_WIDTH-1:0] set_of(input [TAG_BITS-1:0] number);
        integer low;
        begin
            set_of = 0;
            for (low = 0; low < HASHED; low = low + SET_WIDTH) set_of = set_of + (number >> low);
        end
    endfunction

    // Stage 1.
    reg waiting, invalidate;
    reg [31:0] address;
    reg [SET_WIDTH-1:0] set;
    wire commit = waiting && (!answer_valid || answer_ready);
    assign request_ready = !waiting || commit;
    always @(posedge clock)
        if (reset) waiting <= 0;
        else if (request_ready) begin
            waiting <= request_valid;
            invalidate <= request_invalidate;
            address <= request_address;
            set <= set_of(request_address[31:LINE_BITS]);
        end

    // Stage 2: all ways compare at once. Each has a memory of its own for its tags, the full numbers of its lines.
    wire [TAG_BITS-1:0] line = address[31:LINE_BITS];
    reg [WAYS-1:0] resident [0:SETS-1];
    reg [ORDER_WIDTH-1:0] orders [0:SETS-1];
    wire [WAYS-1:0] set_resident = resident[set];
    wire [WAYS*TAG_BITS-1:0] set_tags;
    wire [WAYS-1:0] found;
    wire hit = |found, full = &set_resident;
    wire load = commit && !invalidate && !hit;
    wire [WAY_WIDTH-1:0] victim;
    reg [WAY_WIDTH-1:0] way;
    genvar w;
    generate
        for (w = 0; w < WAYS; w = w + 1) begin : each
            reg [TAG_BITS-1:0] tags [0:SETS-1];
            always @(posedge clock) if (load && way == w) tags[set] <= line;
            assign set_tags[w*TAG_BITS +: TAG_BITS] = tags[set];
            assign found[w] = set_resident[w] && tags[set] == line;
`ifdef SAARCOR_PROVE
            assign probe_tags[w*TAG_BITS +: TAG_BITS] = tags[probe];
`endif
        end
    endgenerate

    // The way that holds the line, else the lowest free one, else the victim.
    integer n;
    always @* begin
        way = victim;
        for (n = WAYS - 1; n >= 0; n = n - 1) if (!set_resident[n]) way = n;
        for (n = 0; n < WAYS; n = n + 1) if (found[n]) way = n;
    end

    wire [ORDER_WIDTH-1:0] next_order, cold_order;
    generate
        if (POLICY == 1) begin : plru
            plru_order #(WAY_BITS) order(orders[set], way, victim, next_order, cold_order);
        end else begin : fifo
            fifo_order #(WAY_BITS) order(orders[set], way, victim, next_order, cold_order);
        end
    endgenerate

    integer s;
    always @(posedge clock)
        if (reset) begin
`ifndef SAARCOR_COLD  // a proof at full size begins with a cold set: a loop over all sets is a write port a set
            for (s = 0; s < SETS; s = s + 1) begin
                resident[s] <= 0;
                orders[s] <= cold_order;
            end
`endif
        end else if (commit) begin
            resident[set] <= invalidate ? set_resident & ~found : set_resident | 1 << way;
            // A hit is a use, which counts for PLRU alone. Invalidations leave the order as it is.
            if (load || POLICY == 1 && !invalidate) orders[set] <= next_order;
        end

    // The answer register. What it holds stays until it is taken.
    always @(posedge clock)
        if (reset) answer_valid <= 0;
        else if (commit) begin
            answer_valid <= 1;
            answer_hit <= hit;
            answer_way <= way;
            answer_card <= (set << WAY_BITS | way) << LINE_BITS | address & (1 << LINE_BITS) - 1;
            answer_evicts <= load && full;
            answer_evicted <= set_tags[way*TAG_BITS +: TAG_BITS] << LINE_BITS;
        end else if (answer_ready) answer_valid <= 0;

`ifdef SAARCOR_PROVE
    assign probe_resident = resident[probe];
    assign probe_waiting = waiting;
    assign probe_waiting_address = address;
    assign probe_waiting_invalidate = invalidate;
    assign probe_commit = commit && !reset;
    order_shown #(WAY_BITS, POLICY) shown(orders[probe], probe_tree, probe_ages);
    always @* if (waiting) assert(set == set_of(line));
`endif
endmodule
