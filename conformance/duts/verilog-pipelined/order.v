// Which way of a set is replaced next. Both modules are combinational, and have the same ports: the order of the set as
// it is, a way that is used or loaded, the victim, the order after that, and the order of a cold set.

// FIFO: a list of all ways, that loaded last in the lowest bits. A way that is loaded goes to the front, wherever it was:
// an invalidation leaves a way in its place, and it may be loaded again before those behind it are evicted.
module fifo_order #(
    parameter WAY_BITS = 2,
    localparam WAYS = 1 << WAY_BITS,
    localparam WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS
) (
    input [WAYS*WIDTH-1:0] order,
    input [WIDTH-1:0] way,
    output [WIDTH-1:0] victim,
    output reg [WAYS*WIDTH-1:0] next,
    output reg [WAYS*WIDTH-1:0] cold
);
    assign victim = order[(WAYS-1)*WIDTH +: WIDTH];

    // The list is a shift register in which the places behind that of the way stand still.
    wire [WAYS*WIDTH-1:0] shifted = order << WIDTH | way;
    reg behind;
    integer place;
    always @* begin
        next = order;
        behind = 0;
        for (place = 0; place < WAYS; place = place + 1) begin
            cold[place*WIDTH +: WIDTH] = place;
            if (!behind) next[place*WIDTH +: WIDTH] = shifted[place*WIDTH +: WIDTH];
            if (order[place*WIDTH +: WIDTH] == way) behind = 1;
        end
    end
endmodule

// Tree-PLRU: the bits of nodes 1, 2, .. of a binary tree. The root is node 1, node i has the children 2 i and 2 i + 1, and
// way w is the leaf WAYS + w. A bit of 1 points to the upper half.
module plru_order #(
    parameter WAY_BITS = 2,
    localparam WAYS = 1 << WAY_BITS,
    localparam WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS,
    localparam NODES = WAYS == 1 ? 1 : WAYS - 1
) (
    input [NODES-1:0] order,
    input [WIDTH-1:0] way,
    output [WIDTH-1:0] victim,
    output reg [NODES-1:0] next,
    output [NODES-1:0] cold
);
    assign cold = 0;

    // From the root to where the bits point.
    reg [WAY_BITS:0] node;
    integer level;
    always @* begin
        node = 1;
        for (level = 0; level < WAY_BITS; level = level + 1) node = {node, order[node-1]};
    end
    assign victim = node - WAYS;

    // From the leaf of the way to the root: each bit on the path points away from where the path came from.
    wire [WAY_BITS:0] leaf = WAYS + way;
    integer height;
    always @* begin
        next = order;
        for (height = 1; height <= WAY_BITS; height = height + 1) next[(leaf >> height)-1] = !leaf[height-1];
    end
endmodule

// The order of a set as proofs have it: the bits of the tree, or how many lines were loaded after that of each way. That
// which is not the policy's is 0.
module order_shown #(
    parameter WAY_BITS = 2, POLICY = 1,
    localparam WAYS = 1 << WAY_BITS,
    localparam WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS,
    localparam NODES = WAYS == 1 ? 1 : WAYS - 1
) (
    input [(POLICY == 1 ? NODES : WAYS * WIDTH)-1:0] order,
    output [NODES-1:0] tree,
    output reg [WAYS*WIDTH-1:0] ages
);
    assign tree = POLICY == 1 ? order : 0;
    wire [WAYS*WIDTH-1:0] list = order;
    integer way, place;
    always @* begin
        ages = 0;
        for (way = 0; way < WAYS; way = way + 1)
            for (place = 0; place < WAYS; place = place + 1)
                if (POLICY == 0 && list[place*WIDTH +: WIDTH] == way) ages[way*WIDTH +: WIDTH] = place;
    end
endmodule
