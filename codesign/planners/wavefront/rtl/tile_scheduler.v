// The scheduler: the tile with the earliest change is the next one, among equal ones the first in raster order.
//
// A word for each tile: the earliest change since its last visit, and the earliest one ever, which is the time at which
// its next visit begins (potentials only fall). A scan reads all tiles, one a cycle, and takes up the changes of the last
// visit on its way:
//
//   settle (the changes arrive)   address   word, changes, write   compare   decided
//
// The walk over the tiles also counts them while the map is loaded.
module tile_scheduler #(
    parameter DOWN = 2,
    parameter ACROSS = 2,
    parameter DOWN_BITS = 2,        // hold DOWN itself, so that a row beside is no other one
    parameter ACROSS_BITS = 2,
    parameter TILE_BITS = 2,
    parameter ADDRESS_BITS = 6,
    parameter DOWN_STEP = 13,       // from the first word of the last tile of a row to that of the next tile
    parameter SETTLE = 2,
    parameter SAFE = 0,
    parameter BITS = 6
) (
    input  wire                    clk,
    input  wire                    restart,         // before the map is loaded
    input  wire                    note,            // the last word of a tile of the map
    input  wire                    has_source,
    input  wire                    has_obstacle,
    output reg  [ADDRESS_BITS-1:0] walk_base,
    output wire                    walk_last,
    input  wire                    scan,
    input  wire                    fresh,           // the first scan of a wave
    input  wire                    obstacle_pass,
    input  wire                    visit,           // the tile that was decided is visited
    input  wire [BITS-1:0]         north,
    input  wire [BITS-1:0]         north_east,
    input  wire [BITS-1:0]         east,
    input  wire [BITS-1:0]         south_east,
    input  wire [BITS-1:0]         south,
    input  wire [BITS-1:0]         south_west,
    input  wire [BITS-1:0]         west,
    input  wire [BITS-1:0]         north_west,
    output wire                    decided,
    output reg  [BITS-1:0]         earliest,        // of the tile that is decided, as the next four
    output reg  [BITS-1:0]         begins,
    output reg  [TILE_BITS-1:0]    tile,
    output reg  [ADDRESS_BITS-1:0] base,
    output reg                     at_top,          // of the tile that is visited
    output reg                     at_bottom,
    output reg                     at_left,
    output reg                     at_right
);
    localparam TILES = DOWN * ACROSS;
    localparam WORD = 2 * BITS + 1 + (SAFE != 0 ? 1 : 0);
    localparam [31:0] LAST_TILE = TILES - 1, BOTTOM = DOWN - 1, RIGHT = ACROSS - 1, NEXT_ROW = DOWN_STEP;
    localparam [31:0] SETTLED = SETTLE;
    localparam [BITS-1:0] INFINITY = {BITS{1'b1}};

    // The walk: its tile, row and column of tiles, and the address of the tile's first word.
    reg [TILE_BITS-1:0] walk_tile;
    reg [DOWN_BITS-1:0] walk_row;
    reg [ACROSS_BITS-1:0] walk_column;
    reg [3:0] settling;
    reg walked;
    wire walking = scan && settling == SETTLED[3:0] && !walked;
    wire row_ends = walk_column == RIGHT[ACROSS_BITS-1:0];
    assign walk_last = walk_tile == LAST_TILE[TILE_BITS-1:0];
    always @(posedge clk)
        if (restart || (note || walking) && walk_last) begin
            walk_tile <= {TILE_BITS{1'b0}};
            walk_row <= {DOWN_BITS{1'b0}};
            walk_column <= {ACROSS_BITS{1'b0}};
            walk_base <= {ADDRESS_BITS{1'b0}};
        end else if (note || walking) begin
            walk_tile <= walk_tile + 1'b1;
            walk_row <= row_ends ? walk_row + 1'b1 : walk_row;
            walk_column <= row_ends ? {ACROSS_BITS{1'b0}} : walk_column + 1'b1;
            walk_base <= walk_base + (row_ends ? NEXT_ROW[ADDRESS_BITS-1:0] : {{ADDRESS_BITS-1{1'b0}}, 1'b1});
        end

    // The stages of a scan, each with its tile.
    reg asked, merged, asked_last, merged_last, compared_last;
    reg [TILE_BITS-1:0] asked_tile, merged_tile;
    reg [DOWN_BITS-1:0] asked_row, merged_row, row, visited_row;
    reg [ACROSS_BITS-1:0] asked_column, merged_column, column, visited_column;
    reg [ADDRESS_BITS-1:0] asked_base, merged_base;
    assign decided = compared_last;
    always @(posedge clk) begin
        settling <= !scan || decided ? 4'd0 : settling == SETTLED[3:0] ? settling : settling + 4'd1;
        walked <= scan && !decided && (walked || walking && walk_last);
        asked <= walking;
        merged <= scan && asked;
        asked_last <= walking && walk_last;
        merged_last <= scan && asked_last;
        compared_last <= scan && merged_last;
        {asked_tile, asked_row, asked_column, asked_base} <= {walk_tile, walk_row, walk_column, walk_base};
        {merged_tile, merged_row, merged_column, merged_base} <= {asked_tile, asked_row, asked_column, asked_base};
    end

    // The word of a tile, and the change of the last visit that it sees.
    wire [WORD-1:0] word;
    wire flagged;
    wire above = asked_row + 1'b1 == visited_row, level = asked_row == visited_row;
    wire below = asked_row == visited_row + 1'b1;
    wire to_left = asked_column + 1'b1 == visited_column, upright = asked_column == visited_column;
    wire to_right = asked_column == visited_column + 1'b1;
    wire visited = !fresh && level && upright;
    reg [BITS-1:0] change;
    always @* begin
        change = INFINITY;
        if (!fresh) case ({above, level, below, to_left, upright, to_right})
            6'b100_010: change = north;
            6'b100_001: change = north_east;
            6'b010_001: change = east;
            6'b001_001: change = south_east;
            6'b001_010: change = south;
            6'b001_100: change = south_west;
            6'b010_100: change = west;
            6'b100_100: change = north_west;
            default: change = INFINITY;
        endcase
    end
    wire [BITS-1:0] first = {BITS{~flagged}};
    wire [BITS-1:0] since = fresh ? first : visited ? INFINITY : word[BITS +: BITS];
    wire [BITS-1:0] ever = fresh ? first : word[BITS-1:0];
    wire [BITS-1:0] next_since = change < since ? change : since;
    wire [BITS-1:0] next_ever = change < ever ? change : ever;
    wire [WORD-1:0] next_word;
    assign next_word[2*BITS-1:0] = {next_since, next_ever};
    assign next_word[2*BITS] = note ? has_source : word[2*BITS];
    generate
        if (SAFE != 0) begin : two_waves
            assign next_word[WORD-1] = note ? has_obstacle : word[WORD-1];
            assign flagged = obstacle_pass ? word[WORD-1] : word[2*BITS];
        end else begin : one_wave
            assign flagged = word[2*BITS];
            wire unused = &{1'b0, has_obstacle, obstacle_pass};
        end
    endgenerate
    ram_1w1r #(.WIDTH(WORD), .DEPTH(TILES > 1 ? TILES : 2), .ADDRESS_BITS(TILE_BITS)) tiles (
        .clk(clk), .write_enable(note | scan & asked), .write_address(note ? walk_tile : asked_tile),
        .write_data(next_word), .read_enable(1'b1), .read_address(walk_tile), .read_data(word)
    );

    // The earliest of all tiles.
    reg [BITS-1:0] merged_since, merged_ever;
    always @(posedge clk) begin
        merged_since <= next_since;
        merged_ever <= next_ever;
        if (walking && walk_tile == {TILE_BITS{1'b0}}) earliest <= INFINITY;
        else if (merged && merged_since < earliest) begin
            earliest <= merged_since;
            begins <= merged_ever;
            {tile, row, column, base} <= {merged_tile, merged_row, merged_column, merged_base};
        end
        if (visit) begin
            visited_row <= row;
            visited_column <= column;
            at_top <= row == {DOWN_BITS{1'b0}};
            at_bottom <= row == BOTTOM[DOWN_BITS-1:0];
            at_left <= column == {ACROSS_BITS{1'b0}};
            at_right <= column == RIGHT[ACROSS_BITS-1:0];
        end
    end
endmodule
