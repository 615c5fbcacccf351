// The VGA controller (Vacariu et al. 2008, section 3.1.1): 800 x 600 pixels, the map on the left half of the screen and
// the directions of discovery on the right half, a pixel a cell.
//
// The paper prints a clock of 65 MHz and 60 frames a second. A frame then has 1344 x 806 pixels, those of 1024 x 768,
// with borders. A pixel lasts PIXEL_CYCLES clocks: two give 65 MHz where the design runs at 130 MHz.
//
// Colours (red, green, blue). Left: obstacle 000, free 111, goal or path 100, visited 010. Right: 1 and the direction
// where a cell was visited or is on the path, else 000.
module breadth_first_display #(
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14,
    parameter LINEAR = 0,
    parameter PIXEL_CYCLES = 2
) (
    input  wire                    clk,
    input  wire                    reset,
    output wire [ADDRESS_BITS-1:0] address,
    input  wire [1:0]              code,
    input  wire [1:0]              direction,
    output reg                     horizontal_sync,
    output reg                     vertical_sync,
    output reg  [2:0]              colour
);
    localparam [10:0] HALF = 400, SYNC_BEGIN = 936, SYNC_END = 1072, LINE = 1344;
    localparam [9:0] LINE_SYNC_BEGIN = 687, LINE_SYNC_END = 693, FRAME = 806;
    localparam [31:0] LAST_TICK = PIXEL_CYCLES - 1, STRIDE = COLUMNS + 1;

    // ---- the counters of pixels and lines; column is the pixel within its half
    reg [3:0] ticks;
    reg [10:0] x;
    reg [9:0] y;
    reg [10:0] column;
    wire tick = ticks == LAST_TICK[3:0];
    wire line_end = x == LINE - 11'd1;
    wire frame_end = y == FRAME - 10'd1;
    wire half_end = x == HALF - 11'd1;
    always @(posedge clk) begin
        ticks <= reset || tick ? 4'd0 : ticks + 4'd1;
        if (reset) begin
            x <= 11'd0;
            y <= 10'd0;
            column <= 11'd0;
        end else if (tick) begin
            x <= line_end ? 11'd0 : x + 11'd1;
            column <= line_end || half_end ? 11'd0 : column + 11'd1;
            if (line_end) y <= frame_end ? 10'd0 : y + 10'd1;
        end
    end

    // ---- the address of the cell under the pixel
    localparam [31:0] HEIGHT = ROWS, WIDTH = COLUMNS;
    wire on_map = y < HEIGHT[9:0] && column < WIDTH[10:0];
    generate
        if (LINEAR != 0) begin : linear
            reg [ADDRESS_BITS-1:0] cell_address, line;
            always @(posedge clk)
                if (reset || (tick && line_end && frame_end)) begin
                    cell_address <= {ADDRESS_BITS{1'b0}};
                    line <= {ADDRESS_BITS{1'b0}};
                end else if (tick) begin
                    if (line_end) line <= line + STRIDE[ADDRESS_BITS-1:0];
                    if (line_end) cell_address <= line + STRIDE[ADDRESS_BITS-1:0];
                    else cell_address <= half_end ? line : cell_address + 1'b1;
                end
            assign address = cell_address;
        end else begin : side_by_side
            assign address = {y[ROW_BITS-1:0], column[COLUMN_BITS-1:0]};
        end
    endgenerate

    // ---- the picture: the memories answer two clocks after the address, and the syncs wait for them
    reg [1:0] map_later, right_later, horizontal_later, vertical_later;
    wire seen = code[1];
    always @(posedge clk) begin
        map_later <= {map_later[0], on_map};
        right_later <= {right_later[0], x >= HALF};
        horizontal_later <= {horizontal_later[0], x >= SYNC_BEGIN && x < SYNC_END};
        vertical_later <= {vertical_later[0], y >= LINE_SYNC_BEGIN && y < LINE_SYNC_END};
        horizontal_sync <= horizontal_later[1];
        vertical_sync <= vertical_later[1];
        if (!map_later[1]) colour <= 3'b000;
        else if (right_later[1]) colour <= {3{seen}} & {1'b1, direction};
        else
            case (code)
                2'd0: colour <= 3'b000;
                2'd1: colour <= 3'b111;
                2'd2: colour <= 3'b100;
                default: colour <= 3'b010;
            endcase
    end
endmodule
