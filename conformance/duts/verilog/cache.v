// The virtual memory of the SaarCOR chip: a set-associative cache with hashed sets and LRU, a request at a time.
//
// The metadata lies on the chip (version A). The requester's bytes, the on-board memory and the bus to the host are
// outside: `load` asks for the line `address` to be written to `card` before `done` is acted upon.
module cache #(
    parameter LINE_BITS = 4,  // log2 of the bytes of a line
    parameter SET_BITS = 1,   // log2 of the sets
    parameter WAY_BITS = 2,   // log2 of the ways
    parameter HASH = 1        // 0: low, 1: add-upper, 2: add-upper-all
) (
    input clock,
    input reset,              // also the flush: invalidates all lines
    input start,              // a request begins
    input forget,             // it invalidates the line, else it reads it
    input [31:0] address,     // host address
    output reg done,
    output reg hit,
    output reg load,          // the line is to be loaded
    output reg evicts,        // a line is evicted
    output reg [31:0] evicted,// its first host address
    output reg [31:0] card    // where the byte of `address` lies
`ifdef SAARCOR_PROVE
    ,                         // the state of one set, for proofs
    input [31:0] probe,
    output [(1 << WAY_BITS)-1:0] probe_resident,
    output [(32 - LINE_BITS << WAY_BITS)-1:0] probe_tags,
    output [((WAY_BITS == 0 ? 1 : WAY_BITS) << WAY_BITS)-1:0] probe_ages
`endif
);
    localparam WAYS = 1 << WAY_BITS;
    localparam SETS = 1 << SET_BITS;
    localparam TAG_BITS = 32 - LINE_BITS;
    localparam WAY_WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS;

    // An entry a way: the line's full address, whether it is resident, and its age in the set.
    reg [WAYS*TAG_BITS-1:0] tags [0:SETS-1];
    reg [WAYS-1:0] resident [0:SETS-1];
    reg [WAYS*WAY_WIDTH-1:0] ages [0:SETS-1];  // 0 is the youngest

    wire [TAG_BITS-1:0] line = address[31:LINE_BITS];

    // The lower bits of the line, plus its upper bits; the carry is dropped.
    function [31:0] set_of(input [TAG_BITS-1:0] number);
        integer shift;
        begin
            set_of = number;
            if (HASH == 1) set_of = number + (number >> SET_BITS);
            if (HASH == 2 && SET_BITS > 0)
                for (shift = SET_BITS; shift < TAG_BITS; shift = shift + (SET_BITS > 0 ? SET_BITS : 1))
                    set_of = set_of + (number >> shift);
            set_of = set_of & (SETS - 1);
        end
    endfunction

    wire [31:0] set = set_of(line);
    wire [WAYS*TAG_BITS-1:0] set_tags = tags[set];
    wire [WAYS-1:0] set_resident = resident[set];
    wire [WAYS*WAY_WIDTH-1:0] set_ages = ages[set];

`ifdef SAARCOR_PROVE
    assign probe_resident = resident[probe];
    assign probe_tags = tags[probe];
    assign probe_ages = ages[probe];
`endif

    // All ways are compared at once: the one that holds the line, the lowest free one, the oldest.
    reg found, free;
    reg [WAY_WIDTH-1:0] found_way, free_way, oldest;
    integer i;
    always @* begin
        found = 0; free = 0; found_way = 0; free_way = 0; oldest = 0;
        for (i = WAYS - 1; i >= 0; i = i - 1) begin
            if (set_resident[i] && set_tags[i*TAG_BITS +: TAG_BITS] == line) begin found = 1; found_way = i; end
            if (!set_resident[i]) begin free = 1; free_way = i; end
            if (set_ages[i*WAY_WIDTH +: WAY_WIDTH] == WAYS - 1) oldest = i;
        end
    end
    wire [WAY_WIDTH-1:0] way = found ? found_way : free ? free_way : oldest;

    // Ways younger than the one that is used grow older by one.
    reg [WAYS*WAY_WIDTH-1:0] next_ages;
    integer j;
    always @* begin
        next_ages = set_ages;
        for (j = 0; j < WAYS; j = j + 1)
            if (set_ages[j*WAY_WIDTH +: WAY_WIDTH] < set_ages[way*WAY_WIDTH +: WAY_WIDTH])
                next_ages[j*WAY_WIDTH +: WAY_WIDTH] = set_ages[j*WAY_WIDTH +: WAY_WIDTH] + 1;
        next_ages[way*WAY_WIDTH +: WAY_WIDTH] = 0;
    end

    // In a cold set way w has the age w.
    wire [WAYS*WAY_WIDTH-1:0] cold_ages;
    genvar w;
    generate for (w = 0; w < WAYS; w = w + 1) assign cold_ages[w*WAY_WIDTH +: WAY_WIDTH] = w; endgenerate

    integer s;
    always @(posedge clock) begin
        done <= start && !reset;
        load <= 0;
        if (reset) begin
`ifndef SAARCOR_COLD  // a proof at full size begins with a cold set: a loop over all sets is a write port a set
            for (s = 0; s < SETS; s = s + 1) begin
                resident[s] <= 0;
                ages[s] <= cold_ages;
            end
`endif
        end else if (start && forget) begin
            if (found) resident[set][found_way] <= 0;
        end else if (start) begin
            hit <= found;
            load <= !found;
            evicts <= !found && !free;
            evicted <= set_tags[way*TAG_BITS +: TAG_BITS] << LINE_BITS;
            card <= (((set << WAY_BITS) | (WAY_BITS == 0 ? 0 : way)) << LINE_BITS) | (address & ((1 << LINE_BITS) - 1));
            ages[set] <= next_ages;
            if (!found) begin
                tags[set][way*TAG_BITS +: TAG_BITS] <= line;
                resident[set][way] <= 1;
            end
        end
    end
endmodule
