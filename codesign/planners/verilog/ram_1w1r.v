// A memory of a circuit. Synthesis for a family may put its own module of the same name in its place.
//
// A read takes one edge: read_data holds the word of the address that the last edge saw. With OUTPUT_REGISTER = 1
// it takes two. A read of the word that the same edge writes is undefined: no circuit does it (no_rw_check).
// It is a block RAM, however few words it has. Without an image the contents are unknown until they are written.
//
// One port that writes, one port that reads.
module ram_1w1r #(
    parameter WIDTH = 18,
    parameter DEPTH = 1024,
    parameter ADDRESS_BITS = 10,
    parameter OUTPUT_REGISTER = 0,
    parameter HAS_IMAGE = 0,
    parameter IMAGE = "none.hex"
) (
    input  wire                    clk,
    input  wire                    write_enable,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [WIDTH-1:0]        write_data,
    input  wire                    read_enable,
    input  wire [ADDRESS_BITS-1:0] read_address,
    output wire [WIDTH-1:0]        read_data
);
    (* no_rw_check, ram_style = "block" *) reg [WIDTH-1:0] words [0:DEPTH-1];
    reg [WIDTH-1:0] word;

    generate
        if (HAS_IMAGE != 0) begin : image
            initial $readmemh(IMAGE, words);
        end
    endgenerate

    always @(posedge clk) begin
        if (write_enable) words[write_address] <= write_data;
        if (read_enable) word <= words[read_address];
    end

    generate
        if (OUTPUT_REGISTER != 0) begin : registered
            reg [WIDTH-1:0] output_word;
            always @(posedge clk) output_word <= word;
            assign read_data = output_word;
        end else begin : direct
            assign read_data = word;
        end
    endgenerate
endmodule
