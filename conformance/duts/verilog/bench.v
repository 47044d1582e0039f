// Test bench: speaks saarcor-vm over stdin and stdout (PROTOCOL.md), and has the memories beside the cache. The shell
// script `serve` reads hello and configuration, and gives the geometry as parameters.
module bench #(parameter LINE_BITS = 4, parameter SET_BITS = 1, parameter WAY_BITS = 2, parameter HASH = 1);
    localparam LINE = 1 << LINE_BITS;
    localparam STDIN = 32'h8000_0000;
    localparam BLOCK = 16;      // bytes of a block of host memory
    localparam BLOCKS = 65536;  // blocks that can be written to

    reg clock = 0, reset = 0, start = 0, forget = 0;
    reg [31:0] address = 0;
    wire done, hit, load, evicts;
    wire [31:0] evicted, card;
    cache #(LINE_BITS, SET_BITS, WAY_BITS, HASH) cache(clock, reset, start, forget, address, done, hit, load, evicts,
        evicted, card);

    reg [7:0] memory [0:(LINE << SET_BITS << WAY_BITS)-1];  // on-board memory

    // Host memory: the blocks that were written to, found by linear probing from their number on.
    reg [7:0] bytes [0:BLOCKS*BLOCK-1];
    reg [27:0] names [0:BLOCKS-1];
    reg used [0:BLOCKS-1];
    integer slot;
    task find(input [31:0] host);
        begin
            slot = ((host >> 4) * 32'd40503 >> 4) % BLOCKS;
            while (used[slot] === 1 && names[slot] != host >> 4) slot = (slot + 1) % BLOCKS;
        end
    endtask

    integer n;
    task write_byte(input [31:0] host, input [7:0] value);
        begin
            find(host);
            if (used[slot] !== 1) for (n = 0; n < BLOCK; n = n + 1) bytes[slot*BLOCK + n] = 0;
            used[slot] = 1;
            names[slot] = host >> 4;
            bytes[slot*BLOCK + host % BLOCK] = value;
        end
    endtask

    task tick; begin #1 clock = 1; #1 clock = 0; end endtask

    task ask(input [31:0] host, input invalidates);
        begin
            address = host; forget = invalidates; start = 1;
            tick;
            start = 0;
        end
    endtask

    integer i;
    task load_line;
        for (i = 0; i < LINE; i = i + 1) begin
            if (i == 0 || i % BLOCK == 0) find((address & ~(LINE - 1)) + i);
            memory[(card & ~(LINE - 1)) + i] = used[slot] === 1 ? bytes[slot*BLOCK + ((address & ~(LINE - 1)) + i) % BLOCK] : 0;
        end
    endtask

    function [3:0] digit(input [7:0] letter);
        digit = letter <= "9" ? letter - "0" : (letter | 8'h20) - "a" + 10;
    endfunction

    reg [7:0] name, rest;
    reg [31:0] host;
    reg [63:0] count, at;
    integer got, k;
    initial begin
        reset = 1; tick; reset = 0;
        name = $fgetc(STDIN);
        while (name != "e") begin
            if (name == "r") begin
                got = $fscanf(STDIN, " %x %x", host, count);
                ask(host, 0);
                if (load) load_line;
                if (hit) $write("h %0x ", card);
                else if (evicts) $write("m %0x %0x ", card, evicted);
                else $write("m %0x - ", card);
                for (k = 0; k < count; k = k + 1) $write("%02x", memory[card + k]);
                $write("\n");
            end else if (name == "w") begin
                got = $fscanf(STDIN, " %x ", host);
                name = $fgetc(STDIN);
                while (name != "\n") begin
                    rest = $fgetc(STDIN);
                    write_byte(host, {digit(name), digit(rest)});
                    host = host + 1;
                    name = $fgetc(STDIN);
                end
                $write("ok\n");
            end else if (name == "i") begin
                got = $fscanf(STDIN, " %x %x", host, count);
                if (count == 64'h1_0000_0000) begin reset = 1; tick; reset = 0; end  // all lines at once
                else for (at = host & ~(LINE - 1); at < host + count; at = at + LINE) ask(at[31:0], 1);
                $write("ok\n");
            end else if (name == "f") begin
                reset = 1; tick; reset = 0;
                $write("ok\n");
            end
            while (name != "\n") name = $fgetc(STDIN);
            name = $fgetc(STDIN);
        end
        $write("end\n");
        $finish(0);
    end
endmodule
