// The loader: clears the words of all blocks in all memories at once, then takes the map from the stream.
//
// For each block in raster order: one word a memory for the address of the flag (clusters: 1 for a fixed node; sides: 1
// for a goal), then one word a memory for the highest bit (clusters: 1 for a goal; sides: 0). A token selects the memory.
//
//     cycles = blocks (p + 1) + 2 blocks memories
module harmonic_load #(
    parameter BLOCKS = 1,
    parameter STRIDE = 16,
    parameter MEMORIES = 4,
    parameter ADDRESS_BITS = 10
) (
    input  wire                    clk,
    input  wire                    reset,
    input  wire                    start,
    input  wire [17:0]             in_data,
    input  wire                    in_valid,
    output reg                     in_ready,
    output wire                    over,          // the last word is taken at this edge
    output reg                     writes,        // this module has the memories: it clears or stores
    output wire [ADDRESS_BITS-1:0] write_address,
    output wire [MEMORIES-1:0]     write_enable,
    output reg  [17:0]             load_word
);
    localparam COUNT_BITS = $clog2(2 * BLOCKS * MEMORIES + 1);
    localparam integer CLEARED_WORDS = BLOCKS * STRIDE;
    localparam integer MAP_WORDS = 2 * BLOCKS * MEMORIES;
    localparam [ADDRESS_BITS:0] LAST_ADDRESS = CLEARED_WORDS[ADDRESS_BITS:0] - 1;
    localparam [COUNT_BITS-1:0] WORDS = MAP_WORDS[COUNT_BITS-1:0];
    localparam integer REST_WORDS = STRIDE - 1;
    localparam [ADDRESS_BITS:0] REST = REST_WORDS[ADDRESS_BITS:0];

    reg clears, stores, fresh, highest, last_word;
    reg [ADDRESS_BITS:0] address;
    reg [COUNT_BITS-1:0] remaining;
    reg [MEMORIES-1:0] token;
    wire [MEMORIES:0] ring = {token, fresh | token[MEMORIES-1]};
    wire takes = in_ready & in_valid;

    assign over = takes & last_word;
    assign write_address = address[ADDRESS_BITS-1:0];
    assign write_enable = {MEMORIES{clears}} | (token & {MEMORIES{stores}});

    always @(posedge clk) begin
        stores <= takes;
        writes <= takes | (clears && address != LAST_ADDRESS);
        last_word <= takes ? remaining == 2 : remaining == 1;
        if (clears) begin
            address <= address == LAST_ADDRESS ? {(ADDRESS_BITS + 1){1'b0}} : address + 1'b1;
            if (address == LAST_ADDRESS) begin
                clears <= 1'b0;
                in_ready <= 1'b1;
            end
        end else if (takes) begin
            fresh <= 1'b0;
            load_word <= in_data;
            token <= ring[MEMORIES-1:0];
            remaining <= remaining - 1'b1;
            if (ring[MEMORIES]) begin
                address <= address + (highest ? REST : {{ADDRESS_BITS{1'b0}}, 1'b1});
                highest <= ~highest;
            end
            if (over) in_ready <= 1'b0;
        end
        if (start) begin
            clears <= 1'b1;
            writes <= 1'b1;
            fresh <= 1'b1;
            highest <= 1'b0;
            address <= {(ADDRESS_BITS + 1){1'b0}};
            token <= {MEMORIES{1'b0}};
            load_word <= 18'd0;
            remaining <= WORDS;
        end
        if (reset) begin
            clears <= 1'b0;
            stores <= 1'b0;
            writes <= 1'b0;
            in_ready <= 1'b0;
        end
    end
endmodule
