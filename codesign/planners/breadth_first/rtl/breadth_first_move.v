// The address of a neighbour, and whether it lies outside of the map (Vacariu et al. 2008, Figure 2: a closed border).
//
// LINEAR = 0: an address is row and column side by side; both are compared with the size of the map.
// LINEAR = 1: an address is row * (COLUMNS + 1) + column. A wall follows every row but the last, so that a step to the
// side never comes to another row; the address is compared with the number of words.
module breadth_first_move #(
    parameter LINEAR = 0,
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14
) (
    input  wire [ADDRESS_BITS-1:0] from,
    input  wire                    north,
    input  wire                    south,
    input  wire                    west,
    input  wire                    east,
    output wire [ADDRESS_BITS-1:0] to,
    output wire                    outside
);
    generate
        if (LINEAR != 0) begin : linear
            localparam [31:0] LENGTH = COLUMNS + 1;
            localparam [31:0] CELLS = ROWS * (COLUMNS + 1) - 1;
            localparam [ADDRESS_BITS:0] STRIDE = LENGTH[ADDRESS_BITS:0];
            localparam [ADDRESS_BITS:0] WORDS = CELLS[ADDRESS_BITS:0];
            wire [ADDRESS_BITS:0] offset = (north ? -STRIDE : {ADDRESS_BITS+1{1'b0}})
                                         | (south ?  STRIDE : {ADDRESS_BITS+1{1'b0}})
                                         | {{ADDRESS_BITS{west}}, west | east};
            wire [ADDRESS_BITS:0] sum = {1'b0, from} + offset;
            assign to = sum[ADDRESS_BITS-1:0];
            assign outside = sum >= WORDS;
        end else begin : side_by_side
            // row + south - north and column + east - west. The lowest bit makes the carry; the highest bit is set
            // by a step to row or column -1.
            localparam [31:0] HEIGHT = ROWS, WIDTH = COLUMNS;
            wire [ROW_BITS+1:0] row = {1'b0, from[ADDRESS_BITS-1:COLUMN_BITS], 1'b1} + {{ROW_BITS+1{north}}, south};
            wire [COLUMN_BITS+1:0] column = {1'b0, from[COLUMN_BITS-1:0], 1'b1} + {{COLUMN_BITS+1{west}}, east};
            assign to = {row[ROW_BITS:1], column[COLUMN_BITS:1]};
            assign outside = row[ROW_BITS+1:1] >= HEIGHT[ROW_BITS:0] ||
                             column[COLUMN_BITS+1:1] >= WIDTH[COLUMN_BITS:0];
            wire unused = &{1'b0, row[0], column[0]};
        end
    endgenerate
endmodule
