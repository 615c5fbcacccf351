// The cell that is read out: its column of the tile, and its address in the memory of that column.
//
// The address of a cell is its row times the tiles across, and the number of its tile in the row. So a step up or down
// adds or subtracts ACROSS, and a step over the edge of a tile one.
module tile_cursor #(
    parameter ACROSS = 2,
    parameter COLUMNS = 4,          // of a tile
    parameter WORDS = 64,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter ADDRESS_BITS = 6,
    parameter PLACE_BITS = 2
) (
    input  wire                    clk,
    input  wire                    at_start,        // stay on the start, which the next four give
    input  wire [ROW_BITS-1:0]     start_row,
    input  wire [COLUMN_BITS-1:0]  start_column,
    input  wire [ADDRESS_BITS-1:0] start_address,
    input  wire [PLACE_BITS-1:0]   start_place,
    input  wire                    rewind,          // to the first cell of the map
    input  wire                    next,            // to the next cell in raster order
    input  wire                    row_ends,
    input  wire                    look,            // read a cell beside, or the own one
    input  wire                    move,            // and go there
    input  wire [ROW_BITS-1:0]     row,
    input  wire [COLUMN_BITS-1:0]  column,
    output wire [ADDRESS_BITS-1:0] address,
    output wire [PLACE_BITS-1:0]   place
);
    localparam [31:0] ROW_STEP = ACROSS, RIGHT = COLUMNS - 1, END = WORDS;

    // Two bits of a row or a column tell where a cell beside lies.
    reg [ROW_BITS-1:0] own_row;
    reg [COLUMN_BITS-1:0] own_column;
    reg [ADDRESS_BITS-1:0] own_address;
    reg [PLACE_BITS-1:0] own_place;
    wire [ROW_BITS:0] down = {1'b0, row} - {1'b0, own_row};
    wire [COLUMN_BITS:0] right = {1'b0, column} - {1'b0, own_column};
    wire goes_down = down[1:0] == 2'd1, goes_up = down[1:0] == 2'd3;
    wire goes_right = right[1:0] == 2'd1, goes_left = right[1:0] == 2'd3;
    wire at_right = own_place == RIGHT[PLACE_BITS-1:0], at_left = own_place == {PLACE_BITS{1'b0}};
    wire [ADDRESS_BITS-1:0] across =
        goes_right && at_right ? {{ADDRESS_BITS-1{1'b0}}, 1'b1} : goes_left && at_left ? {ADDRESS_BITS{1'b1}}
        : {ADDRESS_BITS{1'b0}};
    wire [ADDRESS_BITS-1:0] along =
        goes_down ? ROW_STEP[ADDRESS_BITS-1:0] : goes_up ? -ROW_STEP[ADDRESS_BITS-1:0] : {ADDRESS_BITS{1'b0}};
    wire [ADDRESS_BITS-1:0] seen = own_address + across + along;
    wire [PLACE_BITS-1:0] right_place = at_right ? {PLACE_BITS{1'b0}} : own_place + 1'b1;
    wire [PLACE_BITS-1:0] left_place = at_left ? RIGHT[PLACE_BITS-1:0] : own_place - 1'b1;

    // A cell beside the map is not used; any word of the memory may stand for it.
    wire on_map = {1'b0, seen} < END[ADDRESS_BITS:0];
    assign address = !look ? own_address : on_map ? seen : {ADDRESS_BITS{1'b0}};
    assign place = !look ? own_place : goes_right ? right_place : goes_left ? left_place : own_place;
    always @(posedge clk)
        if (rewind) begin
            own_address <= {ADDRESS_BITS{1'b0}};
            own_place <= {PLACE_BITS{1'b0}};
        end else if (at_start) begin
            own_row <= start_row;
            own_column <= start_column;
            own_address <= start_address;
            own_place <= start_place;
        end else if (move) begin
            own_row <= row;
            own_column <= column;
            own_address <= address;
            own_place <= place;
        end else if (next) begin
            own_address <= row_ends || at_right ? own_address + 1'b1 : own_address;
            own_place <= row_ends ? {PLACE_BITS{1'b0}} : right_place;
        end
    wire unused = &{1'b0, down, right};
endmodule
