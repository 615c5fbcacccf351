// Memories of one side of the harmonic block: the nodes along that side of every block, 18 to a memory.
//
// Words of a block, most significant first: 1 for a goal, then p bits of the values, as on the stream. The memories are
// written at the address of the visited block and read at that of the neighbouring block on the other side.
module harmonic_border #(
    parameter NODES = 18,
    parameter ADDRESS_BITS = 10,
    parameter PIPELINE = 0
) (
    input  wire                               clk,
    input  wire                               valid,  // the words that leave the memories now are values of a block
    input  wire [ADDRESS_BITS-1:0]            read_address,
    input  wire [(NODES + 17) / 18 - 1:0]     write_enable,
    input  wire [ADDRESS_BITS-1:0]            write_address,
    input  wire                               loads,
    input  wire [17:0]                        load_word,
    input  wire [NODES-1:0]                   written,
    output wire [NODES-1:0]                   stream
);
    localparam MEMORIES = (NODES + 17) / 18;

    wire [18 * MEMORIES - 1:0] padded, stored;
    assign padded[NODES-1:0] = written;

    genvar index;
    generate
        if (18 * MEMORIES > NODES) begin : padding
            assign padded[18*MEMORIES-1:NODES] = {(18 * MEMORIES - NODES){1'b0}};
            wire unused = &{1'b0, stored[18*MEMORIES-1:NODES]};
        end
        for (index = 0; index < MEMORIES; index = index + 1) begin : memories
            ram_1w1r #(
                .WIDTH(18),
                .DEPTH(1 << ADDRESS_BITS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .OUTPUT_REGISTER(PIPELINE)
            ) memory (
                .clk(clk),
                .write_enable(write_enable[index]),
                .write_address(write_address),
                .write_data(loads ? load_word : padded[18 * index +: 18]),
                .read_enable(1'b1),
                .read_address(read_address),
                .read_data(stored[18 * index +: 18])
            );
        end
        if (PIPELINE != 0) begin : registered
            reg [NODES-1:0] stream_bits;
            always @(posedge clk) stream_bits <= valid ? stored[NODES-1:0] : {NODES{1'b0}};
            assign stream = stream_bits;
        end else begin : direct
            assign stream = valid ? stored[NODES-1:0] : {NODES{1'b0}};
        end
    endgenerate
endmodule
