// A cache that holds the bytes of its lines: it answers a read with the four bytes at its address, and loads a line that is
// not resident from the host, four bytes at a time. A request at a time; lines leave in the order of loading.
module cache_with_memory #(parameter LINE_BITS = 5, SET_BITS = 5, WAY_BITS = 1) (
  input clock, input reset,
  input request, output ready, input [31:0] address, input invalidate,
  output reg answer, output reg hit, output reg [31:0] card, output reg evicts, output reg [31:0] evicted,
  output reg [31:0] data,
  output load, input load_ready, output [31:0] load_address,
  input fill, output fill_ready, input [31:0] fill_data);
  localparam WAYS = 1 << WAY_BITS, SETS = 1 << SET_BITS, TAG_BITS = 32 - LINE_BITS, BEAT_BITS = LINE_BITS - 2;
  reg [31:0] memory [0:(1 << SET_BITS + WAY_BITS + BEAT_BITS) - 1];
  reg [WAYS*TAG_BITS-1:0] tags [0:SETS-1];
  reg [WAYS-1:0] resident [0:SETS-1];
  reg [WAYS*WAY_BITS-1:0] ages [0:SETS-1];  // 0 is the line that was loaded last

  localparam IDLE = 0, LOOK = 1, LOAD = 2, FILL = 3, READ = 4;
  reg [2:0] state;
  reg [31:0] host;
  reg forgets;
  reg [WAY_BITS-1:0] way;
  reg [BEAT_BITS-1:0] beat;
  assign ready = state == IDLE;
  assign load = state == LOAD;
  assign load_address = {host[31:LINE_BITS], {LINE_BITS{1'b0}}};
  assign fill_ready = state == FILL;

  wire [TAG_BITS-1:0] line = host[31:LINE_BITS];
  wire [SET_BITS-1:0] set = line + (line >> SET_BITS);
  wire [WAYS*TAG_BITS-1:0] set_tags = tags[set];
  wire [WAYS-1:0] set_resident = resident[set];
  wire [WAYS*WAY_BITS-1:0] set_ages = ages[set];
  reg found, free;
  reg [WAY_BITS-1:0] use;
  integer i;
  always @* begin
    found = 0; free = 0; use = 0;
    for (i = WAYS - 1; i >= 0; i = i - 1) if (set_ages[i*WAY_BITS +: WAY_BITS] == WAYS - 1) use = i;
    for (i = WAYS - 1; i >= 0; i = i - 1) if (!set_resident[i]) begin free = 1; use = i; end
    for (i = WAYS - 1; i >= 0; i = i - 1)
      if (set_resident[i] && set_tags[i*TAG_BITS +: TAG_BITS] == line) begin found = 1; use = i; end
  end
  reg [WAYS*WAY_BITS-1:0] next_ages;
  integer j;
  always @* begin
    next_ages = set_ages;
    for (j = 0; j < WAYS; j = j + 1)
      if (set_ages[j*WAY_BITS +: WAY_BITS] < set_ages[use*WAY_BITS +: WAY_BITS])
        next_ages[j*WAY_BITS +: WAY_BITS] = set_ages[j*WAY_BITS +: WAY_BITS] + 1;
    next_ages[use*WAY_BITS +: WAY_BITS] = 0;
  end
  wire [WAYS*WAY_BITS-1:0] cold_ages;
  genvar w;
  generate for (w = 0; w < WAYS; w = w + 1) assign cold_ages[w*WAY_BITS +: WAY_BITS] = w; endgenerate

  integer s;
  always @(posedge clock) begin
    answer <= 0;
    if (reset) begin
      state <= IDLE;
`ifndef SAARCOR_COLD
      for (s = 0; s < SETS; s = s + 1) begin
        resident[s] <= 0;
        ages[s] <= cold_ages;
      end
`endif
    end else case (state)
      IDLE: if (request) begin
        host <= address; forgets <= invalidate; state <= LOOK;
      end
      LOOK: begin
        way <= use; beat <= 0;
        hit <= found; evicts <= !found && !free; evicted <= set_tags[use*TAG_BITS +: TAG_BITS] << LINE_BITS;
        card <= {set, use, host[LINE_BITS-1:0]};
        if (forgets) begin
          if (found) resident[set][use] <= 0;
          answer <= 1; state <= IDLE;
        end else begin
          if (!found) begin
            tags[set][use*TAG_BITS +: TAG_BITS] <= line;
            resident[set][use] <= 1;
            ages[set] <= next_ages;
          end
          state <= found ? READ : LOAD;
        end
      end
      LOAD: if (load_ready) state <= FILL;
      FILL: if (fill) begin
        memory[{set, way, beat}] <= fill_data;
        beat <= beat + 1;
        if (&beat) state <= READ;
      end
      READ: begin
        data <= memory[{set, way, host[LINE_BITS-1:2]}];
        answer <= 1; state <= IDLE;
      end
      default: state <= IDLE;
    endcase
  end
endmodule
