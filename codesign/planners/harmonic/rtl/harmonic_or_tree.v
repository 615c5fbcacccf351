// The OR of INPUTS bits, GROUP bits to a register, STAGES stages; the last stage has a register where REGISTERED = 1.
module harmonic_or_tree #(
    parameter INPUTS = 72,
    parameter GROUP = 256,
    parameter REGISTERED = 0
) (
    input  wire              clk,
    input  wire [INPUTS-1:0] bits,
    output wire              any
);
    localparam GROUPS = (INPUTS + GROUP - 1) / GROUP;

    genvar index;
    generate
        if (GROUPS == 1) begin : root
            if (REGISTERED != 0) begin : registered
                reg any_bit;
                always @(posedge clk) any_bit <= |bits;
                assign any = any_bit;
            end else begin : direct
                assign any = |bits;
                wire unused = &{1'b0, clk};
            end
        end else begin : branch
            reg [GROUPS-1:0] parts;
            for (index = 0; index < GROUPS; index = index + 1) begin : groups
                localparam SIZE = index < GROUPS - 1 ? GROUP : INPUTS - (GROUPS - 1) * GROUP;
                always @(posedge clk) parts[index] <= |bits[GROUP * index +: SIZE];
            end
            harmonic_or_tree #(
                .INPUTS(GROUPS),
                .GROUP(GROUP),
                .REGISTERED(REGISTERED)
            ) rest (
                .clk(clk),
                .bits(parts),
                .any(any)
            );
        end
    endgenerate
endmodule
