// The node of Hassoun and Sanghvi (1990), with which the paper compares its own: eight adders and eight comparators.
//
//   p_i = min(p_i, min over neighbours j of p_j + w_ji)      (equation 3)
//
// Every node updates in every cycle. Infinity is the largest value of a register; a sum has one bit more, so that
// infinity plus a delay is above every potential. A penalised node adds its own delay to the least sum.
module adder_node #(
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter CHAIN = 0,
    parameter BITS = 11,
    parameter OBSTACLE_BITS = 0,
    parameter FLAGS = 2,
    parameter WORD = 11
) (
    input  wire              clk,
    input  wire              load,
    input  wire [FLAGS-1:0]  flags_in,
    output wire [FLAGS-1:0]  flags,
    input  wire              begin_pass,        // sources to 0, all others to infinity
    input  wire              update,
    input  wire              obstacle_pass,
    input  wire [4*BITS-1:0] straight,          // p of N, E, S, W
    input  wire [4*BITS-1:0] diagonal,          // p of NE, SE, SW, NW
    input  wire [3:0]        beside,            // open of N, E, S, W
    input  wire              shift,
    input  wire [WORD-1:0]   word_in,
    output wire [WORD-1:0]   word,
    output wire              open,
    output wire [BITS-1:0]   p,
    output wire              changes
);
    localparam SUM = (BITS > 7 ? BITS : 7) + 1;
    localparam F_AT = BITS + OBSTACLE_BITS;
    localparam P_AT = F_AT + (CORNER_CUTTING != 0 ? 0 : 1);
    localparam [31:0] STRAIGHT_STEP = STRAIGHT, DIAGONAL_STEP = DIAGONAL;

    wire pass = SAFE != 0 ? obstacle_pass : 1'b0;

    // F and Z, and P of penalised nodes.
    wire f;
    reg z;
    always @(posedge clk) if (load) z <= flags_in[1];
    generate
        if (CHAIN != 0 && CORNER_CUTTING == 0) begin : f_in_chain
            reg f_bit;
            always @(posedge clk)
                if (load) f_bit <= flags_in[0];
                else if (shift) f_bit <= word_in[F_AT];
            assign f = f_bit;
        end else begin : f_alone
            reg f_bit;
            always @(posedge clk) if (load) f_bit <= flags_in[0];
            assign f = f_bit;
        end
    endgenerate
    assign flags[1:0] = {z, f};
    assign open = f | pass;

    // Eight adders. Without corner cutting a diagonal sum counts only where both nodes beside the step are free.
    wire [3:0] closed;
    generate
        if (CORNER_CUTTING != 0) begin : cuts
            assign closed = 4'b0000;
        end else begin : keeps_corners
            assign closed = ~{beside[0] & beside[3], beside[2] & beside[3], beside[2] & beside[1], beside[0] & beside[1]};
        end
    endgenerate
    wire [8*SUM-1:0] sums;
    genvar side;
    generate
        for (side = 0; side < 4; side = side + 1) begin : adder
            assign sums[side*SUM +: SUM] =
                {{SUM-BITS{1'b0}}, straight[side*BITS +: BITS]} + STRAIGHT_STEP[SUM-1:0];
            assign sums[(4+side)*SUM +: SUM] =
                {SUM{closed[side]}} | ({{SUM-BITS{1'b0}}, diagonal[side*BITS +: BITS]} + DIAGONAL_STEP[SUM-1:0]);
        end
    endgenerate

    // Seven comparators find the least sum, the eighth compares it with the node's own potential.
    wire [4*SUM-1:0] pairs;
    wire [2*SUM-1:0] fours;
    generate
        for (side = 0; side < 4; side = side + 1) begin : pair
            assign pairs[side*SUM +: SUM] = sums[2*side*SUM +: SUM] < sums[(2*side+1)*SUM +: SUM]
                ? sums[2*side*SUM +: SUM] : sums[(2*side+1)*SUM +: SUM];
        end
        for (side = 0; side < 2; side = side + 1) begin : four
            assign fours[side*SUM +: SUM] = pairs[2*side*SUM +: SUM] < pairs[(2*side+1)*SUM +: SUM]
                ? pairs[2*side*SUM +: SUM] : pairs[(2*side+1)*SUM +: SUM];
        end
    endgenerate
    wire [SUM-1:0] least = fours[SUM-1:0] < fours[2*SUM-1:SUM] ? fours[SUM-1:0] : fours[2*SUM-1:SUM];
    wire [SUM:0] entered;
    generate
        if (EXTRA > 0) begin : penalty
            localparam [31:0] LONGER = EXTRA;
            reg p_bit;
            if (CHAIN != 0) begin : p_in_chain
                always @(posedge clk)
                    if (load) p_bit <= flags_in[2];
                    else if (shift) p_bit <= word_in[P_AT];
            end else begin : p_alone
                always @(posedge clk) if (load) p_bit <= flags_in[2];
            end
            assign flags[2] = p_bit;
            assign word[P_AT] = p_bit;
            assign entered = {1'b0, least} + (p_bit & ~pass ? LONGER[SUM:0] : {SUM+1{1'b0}});
        end else begin : no_penalty
            assign entered = {1'b0, least};
        end
    endgenerate

    reg [BITS-1:0] register;
    assign p = register;
    assign changes = open & (entered < {{SUM+1-BITS{1'b0}}, register});
    wire source = pass ? ~f & ~z : f & z;
    generate
        if (CHAIN != 0) begin : chained
            always @(posedge clk)
                if (begin_pass) register <= {BITS{~source}};
                else if (shift) register <= word_in[BITS-1:0];
                else if (update & changes) register <= entered[BITS-1:0];
        end else begin : addressed
            always @(posedge clk)
                if (begin_pass) register <= {BITS{~source}};
                else if (update & changes) register <= entered[BITS-1:0];
        end
        if (SAFE != 0 && CHAIN == 0) begin : obstacle
            // p^d is kept as the second pass begins; the pass counts as the first until then.
            reg [OBSTACLE_BITS-1:0] obstacle_register;
            always @(posedge clk) if (begin_pass) obstacle_register <= register[OBSTACLE_BITS-1:0];
            assign word[BITS +: OBSTACLE_BITS] = obstacle_register;
        end
        if (CORNER_CUTTING == 0) begin : shown
            assign word[F_AT] = f;
        end
    endgenerate
    assign word[BITS-1:0] = register;

    // Inputs that other parameters need.
    wire unused = &{1'b0, beside, shift, word_in, entered, obstacle_pass};
endmodule
