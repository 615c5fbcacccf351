// The earliest change that each of the eight tiles beside a tile can see, out of the rows of a tile's results.
//
// Rows come lowest first, one a cycle; a change of infinity is none. The least of a row takes a level of comparators a
// cycle, LEVELS in all; all eight are there LEVELS + 1 edges after the edge that takes the last row.
module earliest_changes #(
    parameter COLUMNS = 4,
    parameter LEVELS = 2,           // 2 to the power of LEVELS is at least COLUMNS
    parameter BITS = 6
) (
    input  wire                    clk,
    input  wire                    take,
    input  wire                    bottom,
    input  wire                    top,
    input  wire [COLUMNS*BITS-1:0] changes,
    output reg  [BITS-1:0]         north,
    output reg  [BITS-1:0]         north_east,
    output reg  [BITS-1:0]         east,
    output reg  [BITS-1:0]         south_east,
    output reg  [BITS-1:0]         south,
    output reg  [BITS-1:0]         south_west,
    output reg  [BITS-1:0]         west,
    output reg  [BITS-1:0]         north_west
);
    localparam WIDE = 1 << LEVELS;

    // The rows, and which of them each level has.
    reg [COLUMNS*BITS-1:0] row;
    reg taken;
    reg [LEVELS:0] has_bottom, has_top;
    wire [LEVELS+1:0] bottoms = {has_bottom, take & bottom};
    wire [LEVELS+1:0] tops = {has_top, take & top};
    always @(posedge clk) begin
        row <= changes;
        taken <= take;
        has_bottom <= bottoms[LEVELS:0];
        has_top <= tops[LEVELS:0];
    end
    wire unused = bottoms[LEVELS+1] & tops[LEVELS+1];

    // Level l has WIDE >> l values, the last one the least of the row: value i is the lesser of 2 i and 2 i + 1.
    wire [(2*WIDE-1)*BITS-1:0] values;
    genvar level, place;
    generate
        for (place = 0; place < WIDE; place = place + 1) begin : leaf
            if (place < COLUMNS) begin : column
                assign values[place*BITS +: BITS] = row[place*BITS +: BITS];
            end else begin : empty
                assign values[place*BITS +: BITS] = {BITS{1'b1}};
            end
        end
        for (level = 1; level <= LEVELS; level = level + 1) begin : tree
            localparam BELOW = 2 * WIDE - ((2 * WIDE) >> (level - 1));
            localparam HERE = 2 * WIDE - ((2 * WIDE) >> level);
            for (place = 0; place < (WIDE >> level); place = place + 1) begin : pair
                wire [BITS-1:0] even = values[(BELOW+2*place)*BITS +: BITS];
                wire [BITS-1:0] odd = values[(BELOW+2*place+1)*BITS +: BITS];
                reg [BITS-1:0] lesser;
                always @(posedge clk) lesser <= even < odd ? even : odd;
                assign values[(HERE+place)*BITS +: BITS] = lesser;
            end
        end
    endgenerate
    wire [BITS-1:0] least = values[(2*WIDE-2)*BITS +: BITS];

    // Above and below the whole row counts, left and right the outer column, diagonally a corner.
    wire [BITS-1:0] left = row[BITS-1:0], right = row[(COLUMNS-1)*BITS +: BITS];
    always @(posedge clk) begin
        if (has_bottom[LEVELS]) south <= least;
        if (has_top[LEVELS]) north <= least;
        if (taken && (has_bottom[0] || left < west)) west <= left;
        if (taken && (has_bottom[0] || right < east)) east <= right;
        if (has_bottom[0]) begin
            south_west <= left;
            south_east <= right;
        end
        if (has_top[0]) begin
            north_west <= left;
            north_east <= right;
        end
    end
endmodule
