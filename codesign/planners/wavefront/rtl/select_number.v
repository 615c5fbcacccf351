// The lines that select one of COUNT words: line i is high where the number is i.
//
// It is a module of its own so that synthesis decodes a number once, not again in front of every bit of the words.
module select_number #(
    parameter COUNT = 8,
    parameter NUMBER_BITS = 3
) (
    input  wire [NUMBER_BITS-1:0] number,
    output wire [COUNT-1:0]       lines
);
    genvar line;
    generate
        for (line = 0; line < COUNT; line = line + 1) begin : decoded
            localparam [31:0] OWN = line;
            assign lines[line] = number == OWN[NUMBER_BITS-1:0];
        end
    endgenerate
endmodule
