// A memory of a circuit. Synthesis for a family may put its own module of the same name in its place.
//
// A read takes one edge: read_data holds the word of the address that the last edge saw. With OUTPUT_REGISTER = 1
// it takes two. A read of the word that the same edge writes is undefined: no circuit does it (no_rw_check).
// It is a block RAM, however few words it has. Without an image the contents are unknown until they are written.
//
// Two ports, each of which reads or writes at an edge. A port that writes keeps its read_data.
module ram_2rw #(
    parameter WIDTH = 18,
    parameter DEPTH = 1024,
    parameter ADDRESS_BITS = 10,
    parameter OUTPUT_REGISTER = 0,
    parameter HAS_IMAGE = 0,
    parameter IMAGE = "none.hex"
) (
    input  wire                    clk,
    input  wire                    enable_a,
    input  wire                    write_a,
    input  wire [ADDRESS_BITS-1:0] address_a,
    input  wire [WIDTH-1:0]        write_data_a,
    output wire [WIDTH-1:0]        read_data_a,
    input  wire                    enable_b,
    input  wire                    write_b,
    input  wire [ADDRESS_BITS-1:0] address_b,
    input  wire [WIDTH-1:0]        write_data_b,
    output wire [WIDTH-1:0]        read_data_b
);
    (* no_rw_check, ram_style = "block" *) reg [WIDTH-1:0] words [0:DEPTH-1];
    reg [WIDTH-1:0] word_a, word_b;

    generate
        if (HAS_IMAGE != 0) begin : image
            initial $readmemh(IMAGE, words);
        end
    endgenerate

    always @(posedge clk) if (enable_a) begin
        if (write_a) words[address_a] <= write_data_a;
        else word_a <= words[address_a];
    end
    always @(posedge clk) if (enable_b) begin
        if (write_b) words[address_b] <= write_data_b;
        else word_b <= words[address_b];
    end

    generate
        if (OUTPUT_REGISTER != 0) begin : registered
            reg [WIDTH-1:0] output_word_a, output_word_b;
            always @(posedge clk) begin
                output_word_a <= word_a;
                output_word_b <= word_b;
            end
            assign read_data_a = output_word_a;
            assign read_data_b = output_word_b;
        end else begin : direct
            assign read_data_a = word_a;
            assign read_data_b = word_b;
        end
    endgenerate
endmodule
