// Test bench: speaks saarcor-vm over stdin and stdout (PROTOCOL.md), and has the memories beside the cache. It reads
// ahead, so that requests follow each other clock by clock, and it takes each third answer two clocks late. The shell
// script `serve` reads hello and configuration, and gives the geometry as parameters.
module bench #(parameter LINE_BITS = 4, SET_BITS = 1, WAY_BITS = 2, HASH = 1, POLICY = 1);
    localparam LINE = 1 << LINE_BITS;
    localparam WAY_WIDTH = WAY_BITS == 0 ? 1 : WAY_BITS;
    localparam STDIN = 32'h8000_0000;
    localparam PAGE = 16;      // bytes of a page of host memory
    localparam PAGES = 65536;  // pages that can be written to
    localparam MOST = 4;       // requests without an answer: there is room for more than the pipeline holds
    localparam PATIENCE = 16;  // clocks without an answer, after which there will be none

    reg clock = 0, reset = 0, valid = 0, invalidate = 0, answer_ready = 1;
    reg [31:0] address = 0;
    wire ready, answer_valid, hit, evicts;
    wire [WAY_WIDTH-1:0] way;
    wire [31:0] card, evicted;
    pipelined_cache #(LINE_BITS, SET_BITS, WAY_BITS, HASH, POLICY) cache(clock, reset, valid, ready, address, invalidate,
        answer_valid, answer_ready, hit, way, card, evicts, evicted);

    bit [7:0] memory [0:(LINE << SET_BITS << WAY_BITS)-1];  // on-board memory: its bytes are never unknown

    // Host memory: a hash table of the pages that were written to.
    reg [8*PAGE-1:0] pages [0:PAGES-1];
    reg [27:0] numbers [0:PAGES-1];
    bit used [0:PAGES-1];
    integer at;
    task find(input [27:0] number);
        begin
            at = (number * 32'd40503 >> 4) % PAGES;
            while (used[at] && numbers[at] != number) at = (at + 1) % PAGES;
        end
    endtask

    task write_byte(input [31:0] host, input [7:0] value);
        begin
            find(host >> 4);
            if (!used[at]) pages[at] = 0;
            used[at] = 1;
            numbers[at] = host >> 4;
            pages[at][host[3:0]*8 +: 8] = value;
        end
    endtask

    integer i;
    reg [8*PAGE-1:0] page;  // what is left of it
    task load_line(input [31:0] host, input [31:0] place);  // addresses of its first byte
        for (i = 0; i < LINE; i = i + 1) begin
            if (i % PAGE == 0) find(host + i >> 4);
            if (i % PAGE == 0) page = used[at] ? pages[at] >> host[3:0] * 8 : 0;
            memory[place + i] = page;
            page = page >> 8;
        end
    endtask

    // What was asked, the oldest request first, and the answer to it. An invalidation of several lines is answered once.
    reg [31:0] asked_host [0:MOST-1];
    reg [31:0] asked_count [0:MOST-1];  // bytes to read; 0 for an invalidation
    reg asked_last [0:MOST-1];          // there is something to say
    integer asked = 0, answered = 0, k;
    task answer;
        begin
            k = answered % MOST;
            if (asked_count[k] != 0) begin
                if (!hit) load_line(asked_host[k] & ~(LINE - 1), card & ~(LINE - 1));
                if (hit) $write("h %0x ", card);
                else if (evicts) $write("m %0x %0x ", card, evicted);
                else $write("m %0x - ", card);
                for (i = 0; i < asked_count[k]; i = i + 1) $write("%02x", memory[card + i]);
                $write("\n");
            end else if (asked_last[k]) $write("ok\n");
            answered = answered + 1;
        end
    endtask

    // A clock. An answer to nothing, or none at all, is the cache's fault, and ends the conversation.
    integer stall = 0, waited = 0;
    reg taken;
    task tick;
        begin
            #1 answer_ready = stall == 0;
            #1 taken = valid && ready && !reset;
            waited = answer_valid ? 0 : waited + 1;
            if (answer_valid && asked == answered || asked != answered && waited > PATIENCE) $finish(0);
            else if (answer_valid && answer_ready) begin
                answer;
                stall = answered % 3 == 2 ? 2 : 0;
            end else if (answer_valid) stall = stall - 1;
            clock = 1;
            #1 clock = 0;
        end
    endtask

    task ask(input [31:0] host, input [31:0] count, input last);
        begin
            k = asked % MOST;
            asked_host[k] = host; asked_count[k] = count; asked_last[k] = last;
            address = host; invalidate = count == 0; valid = 1;
            taken = 0;
            while (!taken) tick;
            valid = 0;
            asked = asked + 1;
        end
    endtask

    task drain; while (asked != answered) tick; endtask

    task flush; begin drain; reset = 1; tick; reset = 0; end endtask

    function [3:0] digit(input [7:0] letter);
        digit = letter <= "9" ? letter - "0" : (letter | 8'h20) - "a" + 10;
    endfunction

    integer letter, rest, got;
    reg [31:0] host;
    reg [63:0] count, next;
    initial begin
        flush;
        letter = $fgetc(STDIN);
        while (letter != "e" && letter != -1) begin
            if (letter == "r") begin
                got = $fscanf(STDIN, " %x %x", host, count);
                ask(host, count, 1);
            end else if (letter == "w") begin
                drain;  // a line that is asked for has the bytes from before the write
                got = $fscanf(STDIN, " %x ", host);
                letter = $fgetc(STDIN);
                while (letter != "\n" && letter != "\r" && letter != -1) begin
                    rest = $fgetc(STDIN);
                    write_byte(host, {digit(letter), digit(rest)});
                    host = host + 1;
                    letter = $fgetc(STDIN);
                end
                $write("ok\n");
            end else if (letter == "i") begin
                got = $fscanf(STDIN, " %x %x", host, count);
                count = host + count;  // the end of the range
                if (host < LINE && count == 64'h1_0000_0000) begin flush; $write("ok\n"); end  // all lines at once
                else for (next = host & ~(LINE - 1); next < count; next = next + LINE)
                    ask(next[31:0], 0, next + LINE >= count);
            end else if (letter == "f") begin flush; $write("ok\n"); end
            while (letter != "\n" && letter != -1) letter = $fgetc(STDIN);
            letter = $fgetc(STDIN);
        end
        drain;
        if (letter == "e") $write("end\n");
        $finish(0);
    end
endmodule
