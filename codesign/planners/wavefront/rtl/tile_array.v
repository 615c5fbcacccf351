// The array of one tile: a delay-line node for every cell, and around it the cells that emit into the tile.
//
// Everything moves down by rows. The first row that is loaded is the lowest one, and the lowest row leaves first:
//
//   row in          left cells and right cells, corners included, move down beside the rows;
//   v v v v         the cells above and below are loaded a row at once
//   nodes
//   v v v v
//   row out
//
// A wave runs while ``run`` is high; ``stop`` is high in its last cycle. ``arm`` is the cycle before the first one: the
// counter shows the time of the first emission, and then one more than the time. Nodes that no wave reached hold the
// last count.
module tile_array #(
    parameter ROWS = 4,
    parameter COLUMNS = 4,
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter BITS = 6,
    parameter FLAGS = 2,
    parameter WORD = 6                              // of a node: register, F (where corners may not be cut), P
) (
    input  wire                     clk,
    input  wire                     load,           // a row of F, Z, P
    input  wire [COLUMNS*FLAGS-1:0] row_flags,
    input  wire                     load_above,     // a row of cells around the tile, of the next three
    input  wire                     load_below,
    input  wire [COLUMNS-1:0]       row_open,
    input  wire [COLUMNS-1:0]       row_live,
    input  wire [COLUMNS*BITS-1:0]  row_potentials,
    input  wire                     load_left,      // a cell beside the tile
    input  wire                     left_open,
    input  wire                     left_live,
    input  wire [BITS-1:0]          left_potential,
    input  wire                     load_right,
    input  wire                     right_open,
    input  wire                     right_live,
    input  wire [BITS-1:0]          right_potential,
    input  wire                     arm,
    input  wire                     run,
    input  wire [BITS-1:0]          counter,
    output wire                     stop,
    input  wire                     shift,
    output wire [COLUMNS*BITS-1:0]  row_out
);
    localparam NODES = ROWS * COLUMNS;
    localparam WIDE = COLUMNS + 2;
    localparam PADDED = (ROWS + 2) * WIDE;

    wire [PADDED-1:0] y, open, waiting;
    wire [PADDED-1:0] live;
    wire [PADDED*BITS-1:0] potential;
    wire [NODES*FLAGS-1:0] flags;
    wire [NODES*WORD-1:0] words;
    wire count = arm | run;
    genvar r, c;
    generate
        for (r = 0; r < ROWS + 2; r = r + 1) begin : padded_row
            for (c = 0; c < WIDE; c = c + 1) begin : place
                localparam AT = r * WIDE + c;
                if (c == 0 || c == COLUMNS + 1) begin : beside
                    wire first_open, first_live;
                    wire [BITS-1:0] first_potential;
                    if (r > 0) begin : from_above
                        assign {first_open, first_live} = {open[AT-WIDE], live[AT-WIDE]};
                        assign first_potential = potential[(AT-WIDE)*BITS +: BITS];
                    end else if (c == 0) begin : from_left
                        assign {first_open, first_live} = {left_open, left_live};
                        assign first_potential = left_potential;
                    end else begin : from_right
                        assign {first_open, first_live} = {right_open, right_live};
                        assign first_potential = right_potential;
                    end
                    halo_cell #(.BITS(BITS)) cell_beside (
                        .clk(clk), .take(c == 0 ? load_left : load_right), .open_in(first_open),
                        .live_in(first_live), .potential_in(first_potential), .count(count), .counter(counter),
                        .open(open[AT]), .live(live[AT]), .potential(potential[AT*BITS +: BITS]), .y(y[AT])
                    );
                    assign waiting[AT] = live[AT] & ~y[AT];
                end else if (r == 0 || r == ROWS + 1) begin : around
                    halo_cell #(.BITS(BITS)) cell_around (
                        .clk(clk), .take(r == 0 ? load_above : load_below), .open_in(row_open[c-1]),
                        .live_in(row_live[c-1]), .potential_in(row_potentials[(c-1)*BITS +: BITS]), .count(count),
                        .counter(counter), .open(open[AT]), .live(live[AT]),
                        .potential(potential[AT*BITS +: BITS]), .y(y[AT])
                    );
                    assign waiting[AT] = live[AT] & ~y[AT];
                end else begin : inner
                    localparam NODE = (r - 1) * COLUMNS + c - 1;
                    wire [FLAGS-1:0] flags_in;
                    wire [WORD-1:0] word_in;
                    if (r == 1) begin : top_row
                        assign flags_in = row_flags[NODE*FLAGS +: FLAGS];
                        assign word_in = {WORD{1'b0}};
                    end else begin : lower_row
                        assign flags_in = flags[(NODE-COLUMNS)*FLAGS +: FLAGS];
                        assign word_in = words[(NODE-COLUMNS)*WORD +: WORD];
                    end
                    delay_line_node #(
                        .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                        .WAITS(0), .SAFE(0), .CHAIN(1), .BITS(BITS), .OBSTACLE_BITS(0), .COUNTER_BITS(BITS),
                        .FLAGS(FLAGS), .WORD(WORD)
                    ) node (
                        .clk(clk), .load(load), .flags_in(flags_in), .flags(flags[NODE*FLAGS +: FLAGS]),
                        .clear(~run), .run(run), .obstacle_pass(1'b0), .counter(counter),
                        .straight({y[AT-1], y[AT+WIDE], y[AT+1], y[AT-WIDE]}),
                        .diagonal({y[AT-WIDE-1], y[AT+WIDE-1], y[AT+WIDE+1], y[AT-WIDE+1]}),
                        .beside({open[AT-1], open[AT+WIDE], open[AT+1], open[AT-WIDE]}),
                        .shift(shift), .word_in(word_in), .word(words[NODE*WORD +: WORD]),
                        .open(open[AT]), .y(y[AT]), .moving(waiting[AT])
                    );
                    assign live[AT] = 1'b0;
                    assign potential[AT*BITS +: BITS] = {BITS{1'b0}};
                    if (r == ROWS) begin : bottom_row
                        assign row_out[(c-1)*BITS +: BITS] = words[NODE*WORD +: BITS];
                    end
                end
            end
        end
    endgenerate

    // The end of a visit: no wave is on its way to a node, and every cell around has emitted.
    assign stop = run & ~|waiting;

    // What lies at the lower edge, and inputs that other parameters need.
    wire unused = &{1'b0, flags, words, live, potential, open};
endmodule
