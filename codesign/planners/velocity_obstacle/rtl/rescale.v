// A product in the format of its result, rounded to nearest, halves up: floor(product / 2^SHIFT + 1/2).
//
// That is the product without its last SHIFT bits, plus the highest bit of those.
module rescale #(
    parameter IN = 32,
    parameter SHIFT = 16,
    parameter OUT = 16
) (
    input  wire signed [IN-1:0]  product,
    output wire signed [OUT-1:0] result
);
    localparam WIDE = (IN > SHIFT + OUT) ? IN : SHIFT + OUT;

    wire signed [WIDE-1:0] extended;
    generate
        if (WIDE > IN) begin : wider
            assign extended = {{(WIDE - IN) {product[IN-1]}}, product};
        end else begin : same
            assign extended = product;
        end
        if (SHIFT > 0) begin : rounded
            assign result = extended[SHIFT+OUT-1:SHIFT] + {{(OUT - 1) {1'b0}}, extended[SHIFT-1]};
        end else begin : exact
            assign result = extended[OUT-1:0];
        end
    endgenerate
    wire unused_bits = &{1'b0, extended};
endmodule
