// Memories of one side of the harmonic block: the nodes along that side of every block, 18 to a memory.
//
// Words of a block, most significant first: 1 for a goal, then p bits of the values, as on the stream. The memories are
// written at the address of the visited block and read at that of the neighbouring block on the other side. With digits
// of DIGIT_BITS bits there is a memory for each bit of a digit, and that of the lowest bits is loaded.
module harmonic_border #(
    parameter NODES = 18,
    parameter ADDRESS_BITS = 10,
    parameter DIGIT_BITS = 1,
    parameter PIPELINE = 0
) (
    input  wire                               clk,
    input  wire                               valid,  // the words that leave the memories now are values of a block
    input  wire [ADDRESS_BITS-1:0]            read_address,
    input  wire [(NODES + 17) / 18 - 1:0]     write_enable,
    input  wire [ADDRESS_BITS-1:0]            write_address,
    input  wire                               loads,
    input  wire [17:0]                        load_word,
    input  wire [DIGIT_BITS*NODES-1:0]        written,
    output wire [DIGIT_BITS*NODES-1:0]        stream
);
    localparam MEMORIES = (NODES + 17) / 18;

    localparam WIDTH = 18 * MEMORIES;

    // Node k has bits DIGIT_BITS k and above of the streams; the memories of a bit have that bit of all nodes.
    wire [DIGIT_BITS*WIDTH-1:0] values;
    reg [DIGIT_BITS*NODES-1:0] stored;
    reg [DIGIT_BITS*WIDTH-1:0] results;
    always @* stored = by_node(values);
    always @* results = by_place(written);

    function [DIGIT_BITS*NODES-1:0] by_node(input [DIGIT_BITS*WIDTH-1:0] bits);
        integer node, bit_place;
        for (node = 0; node < NODES; node = node + 1)
            for (bit_place = 0; bit_place < DIGIT_BITS; bit_place = bit_place + 1)
                by_node[DIGIT_BITS*node+bit_place] = bits[WIDTH*bit_place+node];
    endfunction

    function [DIGIT_BITS*WIDTH-1:0] by_place(input [DIGIT_BITS*NODES-1:0] bits);
        integer node, bit_place;
        for (node = 0; node < WIDTH; node = node + 1)
            for (bit_place = 0; bit_place < DIGIT_BITS; bit_place = bit_place + 1)
                by_place[WIDTH*bit_place+node] = node < NODES ? bits[DIGIT_BITS*node+bit_place] : 1'b0;
    endfunction

    genvar place, index;
    generate
        for (place = 0; place < DIGIT_BITS; place = place + 1) begin : places
            wire [17:0] load = place == 0 ? load_word : 18'd0;
            for (index = 0; index < MEMORIES; index = index + 1) begin : memories
                localparam LOW = WIDTH * place + 18 * index;
                ram_1w1r #(
                    .WIDTH(18),
                    .DEPTH(1 << ADDRESS_BITS),
                    .ADDRESS_BITS(ADDRESS_BITS),
                    .OUTPUT_REGISTER(PIPELINE)
                ) memory (
                    .clk(clk),
                    .write_enable(write_enable[index]),
                    .write_address(write_address),
                    .write_data(loads ? load : results[LOW+:18]),
                    .read_enable(1'b1),
                    .read_address(read_address),
                    .read_data(values[LOW+:18])
                );
            end
        end
        if (WIDTH > NODES) begin : padding
            wire unused = &{1'b0, values};
        end
        if (PIPELINE != 0) begin : registered
            reg [DIGIT_BITS*NODES-1:0] streams;
            always @(posedge clk) streams <= stored & {(DIGIT_BITS*NODES){valid}};
            assign stream = streams;
        end else begin : direct
            assign stream = stored & {(DIGIT_BITS*NODES){valid}};
        end
    endgenerate
endmodule
