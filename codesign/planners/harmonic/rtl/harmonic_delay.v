// A value, CYCLES later; 0 after a reset.
module harmonic_delay #(
    parameter BITS = 1,
    parameter CYCLES = 1
) (
    input  wire            clk,
    input  wire            reset,
    input  wire [BITS-1:0] value,
    output wire [BITS-1:0] later
);
    generate
        if (CYCLES == 0) begin : none
            assign later = value;
            wire unused = &{1'b0, clk, reset};
        end else begin : line
            reg [BITS*CYCLES-1:0] values;
            wire [BITS*(CYCLES+1)-1:0] all = {values, value};
            always @(posedge clk) values <= reset ? {(BITS * CYCLES){1'b0}} : all[BITS*CYCLES-1:0];
            assign later = all[BITS*CYCLES +: BITS];
        end
    endgenerate
endmodule
