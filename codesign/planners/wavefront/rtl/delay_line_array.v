// The array: a delay-line node for every cell of the map, the global counter, and the end of the wave.
//
// A pass of the wave runs while ``run`` is high; ``stop`` is high in its last cycle. At cycle t the counter shows t + 1:
// an open register then holds t, so that a node whose y rises at t keeps t. The last pass ends with the cycle in which
// the wave reaches the selected node (D + 1 cycles), or in which no wave is on its way to any node. Open registers then
// hold one value more than the largest potential, which is infinity.
module delay_line_array #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter CHAIN = 0,
    parameter WAITS = 1,            // 1: the wave ends at the selected node; 0: at its own end
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,
    parameter LONGEST = 21,         // the potential at which the wave from the obstacles ends
    parameter FLAGS = 2,
    parameter LOAD_CELLS = 32,
    parameter WORD = 6
) (
    input  wire                        clk,
    input  wire                        load,
    input  wire [LOAD_CELLS*FLAGS-1:0] load_word,
    input  wire                        run,
    input  wire                        obstacle_pass,
    output wire                        stop,
    input  wire                        shift,
    input  wire [ROW_BITS-1:0]         row,
    input  wire [COLUMN_BITS-1:0]      column,
    output wire [WORD-1:0]             word         // addressed: of the node selected one edge ago; chain: of node 0
);
    localparam NODES = ROWS * COLUMNS;
    localparam WIDE = COLUMNS + 2;
    localparam PADDED = (ROWS + 2) * WIDE;
    localparam COUNTER_BITS = BITS > OBSTACLE_BITS ? BITS : OBSTACLE_BITS;
    localparam [31:0] LAST_COUNT = LONGEST + 1;

    // Cntr. of Figure 2.
    reg [COUNTER_BITS-1:0] counter;
    wire clear = ~run | stop;
    always @(posedge clk) counter <= clear ? {{COUNTER_BITS-1{1'b0}}, 1'b1} : counter + 1'b1;

    // The nodes, with a border that sends nothing.
    wire [PADDED-1:0] y, open;
    wire [NODES-1:0] node_y, moving;
    wire [NODES*FLAGS-1:0] flags;
    wire [NODES*WORD-1:0] words;
    genvar r, c;
    generate
        for (r = 0; r < ROWS + 2; r = r + 1) begin : padded_row
            for (c = 0; c < WIDE; c = c + 1) begin : place
                localparam AT = r * WIDE + c;
                if (r == 0 || r == ROWS + 1 || c == 0 || c == COLUMNS + 1) begin : border
                    assign y[AT] = 1'b0;
                    assign open[AT] = 1'b0;
                end else begin : inner
                    localparam NODE = (r - 1) * COLUMNS + c - 1;
                    wire [FLAGS-1:0] flags_in;
                    wire [WORD-1:0] word_in;
                    if (NODE < LOAD_CELLS) begin : from_stream
                        assign flags_in = load_word[NODE*FLAGS +: FLAGS];
                    end else begin : from_node
                        assign flags_in = flags[(NODE-LOAD_CELLS)*FLAGS +: FLAGS];
                    end
                    if (NODE < NODES - 1) begin : link
                        assign word_in = words[(NODE+1)*WORD +: WORD];
                    end else if (WORD > BITS) begin : tail
                        // Registers are left at 0. F and P go round, as the next wave needs them.
                        assign word_in = {words[WORD-1:BITS], {BITS{1'b0}}};
                    end else begin : empty_tail
                        assign word_in = {BITS{1'b0}};
                    end
                    delay_line_node #(
                        .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                        .WAITS(WAITS), .SAFE(SAFE), .CHAIN(CHAIN), .BITS(BITS), .OBSTACLE_BITS(OBSTACLE_BITS),
                        .COUNTER_BITS(COUNTER_BITS), .FLAGS(FLAGS), .WORD(WORD)
                    ) node (
                        .clk(clk), .load(load), .flags_in(flags_in), .flags(flags[NODE*FLAGS +: FLAGS]),
                        .clear(clear), .run(run), .obstacle_pass(obstacle_pass), .counter(counter),
                        .straight({y[AT-1], y[AT+WIDE], y[AT+1], y[AT-WIDE]}),
                        .diagonal({y[AT-WIDE-1], y[AT+WIDE-1], y[AT+WIDE+1], y[AT-WIDE+1]}),
                        .beside({open[AT-1], open[AT+WIDE], open[AT+1], open[AT-WIDE]}),
                        .shift(shift), .word_in(word_in), .word(words[NODE*WORD +: WORD]),
                        .open(open[AT]), .y(y[AT]), .moving(moving[NODE])
                    );
                    assign node_y[NODE] = y[AT];
                end
            end
        end
    endgenerate

    // The end of a pass.
    wire at_end;
    generate
        if (WAITS != 0) begin : waits
            wire reached;
            select_word #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS), .WORD(1)
            ) selected_y (.row(row), .column(column), .words(node_y), .word(reached));
            // A node that no wave reaches: the counter at infinity ends the wave.
            assign at_end = reached | &counter[BITS-1:0];
        end else begin : whole_map
            assign at_end = ~|moving;
        end
        if (SAFE != 0) begin : two_passes
            assign stop = run & (obstacle_pass ? counter == LAST_COUNT[COUNTER_BITS-1:0] : at_end);
        end else begin : one_pass
            assign stop = run & at_end;
        end
    endgenerate

    // The read-out.
    generate
        if (CHAIN != 0) begin : chain
            assign word = words[WORD-1:0];
        end else begin : addressed
            wire [WORD-1:0] selected;
            reg [WORD-1:0] read_word;
            select_word #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS), .WORD(WORD)
            ) read_out (.row(row), .column(column), .words(words), .word(selected));
            always @(posedge clk) read_word <= selected;
            assign word = read_word;
        end
    endgenerate

    // Inputs that other parameters need.
    wire unused = &{1'b0, load_word, row, column, shift, node_y, moving, flags, obstacle_pass};
endmodule
