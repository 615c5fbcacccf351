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

    wire [DIGIT_BITS*NODES-1:0] stored;

    genvar place, index;
    generate
        for (place = 0; place < DIGIT_BITS; place = place + 1) begin : places
            wire [17:0] load = place == 0 ? load_word : 18'd0;
            wire [18*MEMORIES-1:0] results, values;
            for (index = 0; index < 18 * MEMORIES; index = index + 1) begin : nodes
                if (index < NODES) begin : present
                    assign results[index] = written[DIGIT_BITS*index+place];
                    assign stored[DIGIT_BITS*index+place] = values[index];
                end else begin : absent
                    assign results[index] = 1'b0;
                    wire unused = &{1'b0, values[index]};
                end
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
                    .write_data(loads ? load : results[18 * index +: 18]),
                    .read_enable(1'b1),
                    .read_address(read_address),
                    .read_data(values[18 * index +: 18])
                );
            end
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
