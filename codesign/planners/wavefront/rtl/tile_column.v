// A column of the tile: its memory with a word for each of its cells in all tiles, and what visits make of the words.
//
//   F  potential     the potential is infinity where all its bits are 1
//   0  infinity      an obstacle, or outside of the map
//   0  0             a source that no visit has reached yet
//   1  any           a free cell; 0: a source
//
// With SAFE a second memory of the same words holds p^d: all cells are free, and obstacles are the sources.
module tile_column #(
    parameter SAFE = 0,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,    // of p^d in a word that is shown
    parameter FLAGS = 2,
    parameter WORD = 6,             // that is shown: potential, p^d, F (where corners may not be cut), P
    parameter DEPTH = 64,
    parameter ADDRESS_BITS = 6
) (
    input  wire                    clk,
    input  wire                    obstacle_pass,
    input  wire [ADDRESS_BITS-1:0] read_address,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire                    load,            // write the word of a cell of the map
    input  wire [FLAGS-1:0]        load_flags,
    input  wire                    store,           // write the result of a visit over the word that was read
    input  wire [BITS-1:0]         result,
    input  wire [BITS-1:0]         last_count,      // the result of a node that no wave reached
    output wire [FLAGS-1:0]        flags,           // of the word that was read: F, Z, P
    output wire                    live,            // it has a potential
    output wire [BITS-1:0]         potential,
    output wire [BITS-1:0]         change,          // its new potential; infinity: it stays as it was
    output wire [WORD-1:0]         word
);
    localparam MEMORY_BITS = BITS + 1 + (EXTRA > 0 ? 1 : 0);
    localparam P_AT = BITS + OBSTACLE_BITS + (CORNER_CUTTING != 0 ? 0 : 1);
    localparam [BITS-1:0] INFINITY = {BITS{1'b1}};

    // The result of a visit.
    wire free;
    wire source = ~|potential;
    wire reached = result != last_count;
    assign live = free & ~&potential;
    assign flags[1:0] = {source, free | source};
    assign change = reached && !(free && potential == result) ? result : INFINITY;
    wire [BITS:0] stored = {free | source, reached ? result : INFINITY};

    // The potentials.
    wire [MEMORY_BITS-1:0] first_in, first_word;
    wire first_source = load_flags[0] & load_flags[1];
    assign first_in[BITS:0] = load ? {load_flags[0] & ~load_flags[1], {BITS{~first_source}}} : stored;
    wire pass = SAFE != 0 ? obstacle_pass : 1'b0;
    ram_1w1r #(.WIDTH(MEMORY_BITS), .DEPTH(DEPTH), .ADDRESS_BITS(ADDRESS_BITS)) potentials (
        .clk(clk), .write_enable(load | store & ~pass), .write_address(write_address), .write_data(first_in),
        .read_enable(1'b1), .read_address(read_address), .read_data(first_word)
    );
    generate
        if (EXTRA > 0) begin : penalty
            assign first_in[MEMORY_BITS-1] = load ? load_flags[2] : first_word[MEMORY_BITS-1];
            assign flags[2] = first_word[MEMORY_BITS-1] & ~pass;
            assign word[P_AT] = first_word[MEMORY_BITS-1];
        end
        if (CORNER_CUTTING == 0) begin : shown
            assign word[BITS+OBSTACLE_BITS] = first_word[BITS] | ~|first_word[BITS-1:0];
        end
        // p^d. F = 0 and Z = 1 in the stream: outside of the map.
        if (SAFE != 0) begin : distance
            wire [BITS:0] second_word;
            wire second_source = ~load_flags[0] & ~load_flags[1];
            ram_1w1r #(.WIDTH(BITS + 1), .DEPTH(DEPTH), .ADDRESS_BITS(ADDRESS_BITS)) obstacle_potentials (
                .clk(clk), .write_enable(load | store & pass), .write_address(write_address),
                .write_data(load ? {load_flags[0], {BITS{~second_source}}} : stored),
                .read_enable(1'b1), .read_address(read_address), .read_data(second_word)
            );
            assign {free, potential} = pass ? second_word : first_word[BITS:0];
            assign word[BITS +: OBSTACLE_BITS] = second_word[OBSTACLE_BITS-1:0];
        end else begin : no_distance
            assign {free, potential} = first_word[BITS:0];
        end
    endgenerate
    assign word[BITS-1:0] = first_word[BITS-1:0];
endmodule
