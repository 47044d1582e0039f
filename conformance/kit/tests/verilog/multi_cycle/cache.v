// A cache of four ways with LRU that shows nothing of its state, in the style of a small core: a request is taken, the
// entries of its set are read in the next clock, and compared and changed in the one after. Entries of all sets lie in one
// memory, with the resident bit beside the tag.
module multi_cycle_cache #(parameter LB = 7, SB = 5) (
  input clk, input rst_n,
  input req, output gnt, input [31:0] addr, input inval,
  output reg rsp, output reg hit, output reg [1:0] way, output reg evict, output reg [31:0] victim);
  localparam T = 32 - LB;
  reg [T:0] mem [0:(4<<SB)-1];     // {valid, tag}
  reg [7:0] lru [0:(1<<SB)-1];     // ages
  reg [1:0] st; // 0 idle, 1 read, 2 update
  reg [31:0] a; reg inv; reg [SB-1:0] set;
  reg [T:0] e0, e1, e2, e3; reg [7:0] ages;
  wire [T-1:0] line = a[31:LB];
  wire [T-1:0] reql = addr[31:LB];
  assign gnt = st == 0;
  wire [3:0] v = {e3[T], e2[T], e1[T], e0[T]};
  wire [3:0] m = v & {e3[T-1:0] == line, e2[T-1:0] == line, e1[T-1:0] == line, e0[T-1:0] == line};
  wire found = |m;
  wire free = ~&v;
  wire [1:0] fw = m[0] ? 0 : m[1] ? 1 : m[2] ? 2 : 3;
  wire [1:0] frw = !v[0] ? 0 : !v[1] ? 1 : !v[2] ? 2 : 3;
  wire [1:0] ow = ages[1:0] == 3 ? 0 : ages[3:2] == 3 ? 1 : ages[5:4] == 3 ? 2 : 3;
  wire [1:0] use = found ? fw : free ? frw : ow;
  wire [1:0] uage = ages[use*2 +: 2];
  wire [T-1:0] ot = ow == 0 ? e0 : ow == 1 ? e1 : ow == 2 ? e2 : e3;
  integer i; reg [7:0] na;
  always @* begin
    na = ages;
    for (i = 0; i < 4; i = i + 1) if (ages[i*2 +: 2] < uage) na[i*2 +: 2] = ages[i*2 +: 2] + 1;
    na[use*2 +: 2] = 0;
  end
  integer s;
  always @(posedge clk) begin
    rsp <= 0;
    if (!rst_n) begin
      st <= 0;
      for (s = 0; s < (4<<SB); s = s + 1) mem[s] <= 0;
      for (s = 0; s < (1<<SB); s = s + 1) lru[s] <= 8'b11100100;
    end else case (st)
      0: if (req) begin
           a <= addr; inv <= inval; st <= 1;
           set <= reql + (reql >> SB);
         end
      1: begin
           e0 <= mem[{set, 2'd0}]; e1 <= mem[{set, 2'd1}]; e2 <= mem[{set, 2'd2}]; e3 <= mem[{set, 2'd3}];
           ages <= lru[set]; st <= 2;
         end
      2: begin
           st <= 0; rsp <= 1; hit <= found; way <= use; evict <= !found && !free; victim <= {ot, {LB{1'b0}}};
           if (inv) begin if (found) mem[{set, fw}] <= 0; end
           else begin
             lru[set] <= na;
             if (!found) mem[{set, use}] <= {1'b1, line};
           end
         end
      default: st <= 0;
    endcase
  end
endmodule
