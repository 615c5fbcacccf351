// The address of a neighbour, and whether a step leaves the map (Vacariu et al. 2008, Figure 2: a closed border).
//
// LINEAR = 0: an address is row and column side by side. A step leaves the map from its first or last row or column.
// LINEAR = 1: an address is row * (COLUMNS + 1) + column. A wall follows every row but the last, so a step to the side
// never comes to another row; only the ends of the words are compared with.
//
// leaving looks at the step alone that is known a cycle ahead (north, south, west, east).
module breadth_first_move #(
    parameter LINEAR = 0,
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14
) (
    input  wire [ADDRESS_BITS-1:0] from,
    input  wire [3:0]              known,
    input  wire                    following,
    input  wire [1:0]              direction,
    output wire [ADDRESS_BITS-1:0] to,
    output wire                    leaving
);
    wire north = known[3] || (following && direction == 2'd0);
    wire south = known[2] || (following && direction == 2'd1);
    wire west = known[1] || (following && direction == 2'd2);
    wire east = known[0] || (following && direction == 2'd3);
    wire at_top, at_bottom, at_left, at_right;
    assign leaving = (known[3] && at_top) || (known[2] && at_bottom) || (known[1] && at_left) || (known[0] && at_right);

    generate
        if (LINEAR != 0) begin : linear
            localparam [31:0] STRIDE = COLUMNS + 1;
            localparam [31:0] LAST = ROWS * (COLUMNS + 1) - 2;
            localparam [31:0] LAST_ROW = (ROWS - 1) * (COLUMNS + 1);
            localparam [ADDRESS_BITS-1:0] LENGTH = STRIDE[ADDRESS_BITS-1:0];
            assign to = from + ((north ? -LENGTH : {ADDRESS_BITS{1'b0}}) | (south ? LENGTH : {ADDRESS_BITS{1'b0}})
                                | {{ADDRESS_BITS-1{west}}, west | east});
            assign at_top = from < LENGTH || ROWS == 1;
            if (ROWS > 1) begin : rows assign at_bottom = from >= LAST_ROW[ADDRESS_BITS-1:0]; end else assign at_bottom = 1'b1;
            assign at_left = from == {ADDRESS_BITS{1'b0}};
            assign at_right = from == LAST[ADDRESS_BITS-1:0];
        end else begin : side_by_side
            // row + south - north and column + east - west; the lowest bit makes the carry.
            localparam [31:0] BOTTOM = ROWS - 1, RIGHT = COLUMNS - 1;
            wire [ROW_BITS-1:0] row = from[ADDRESS_BITS-1:COLUMN_BITS];
            wire [COLUMN_BITS-1:0] column = from[COLUMN_BITS-1:0];
            wire [ROW_BITS:0] next_row = {row, 1'b1} + {{ROW_BITS{north}}, south};
            wire [COLUMN_BITS:0] next_column = {column, 1'b1} + {{COLUMN_BITS{west}}, east};
            assign to = {next_row[ROW_BITS:1], next_column[COLUMN_BITS:1]};
            assign at_top = row == {ROW_BITS{1'b0}};
            assign at_bottom = row == BOTTOM[ROW_BITS-1:0];
            assign at_left = column == {COLUMN_BITS{1'b0}};
            assign at_right = column == RIGHT[COLUMN_BITS-1:0];
            wire unused = &{1'b0, next_row[0], next_column[0]};
        end
    endgenerate
endmodule
