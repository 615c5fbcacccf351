// A node of the delay line (Moeller and Paschke 1998, Figure 2): the time at which the wave comes is the potential.
//
// The wave enters the line from the diagonal neighbours at its head, and from the straight ones so far behind that
// STRAIGHT flip-flops are left. So it leaves after DIAGONAL or STRAIGHT cycles:
//
//   diagonal -> [ ] -> OR -> [ ] -> [ ] -> arrived -> AND F -> OR Z -> y
//                      ^
//   straight ----------'
//
// y stays 1: a source sends for ever, so every line stays full. So the register needs no lock: it takes the counter
// until y is 1, and then holds the time of the arrival.
module delay_line_node #(
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,            // cycles more to enter a penalised node; 0: none is penalised
    parameter CORNER_CUTTING = 1,
    parameter WAITS = 1,            // 1: the wave ends at a start, so that nobody asks for moving
    parameter SAFE = 0,             // 1: a first wave from the obstacles, for p^d
    parameter CHAIN = 0,            // 1: registers form a chain for the read-out, and p^d is read out before p^t
    parameter BITS = 11,            // of the register
    parameter OBSTACLE_BITS = 0,    // of the register of p^d; 0: none
    parameter COUNTER_BITS = 11,
    parameter FLAGS = 2,            // loaded bits: F, Z, and where nodes are penalised P
    parameter WORD = 11             // read-out: register, p^d, F (where corners may not be cut), P
) (
    input  wire                    clk,
    input  wire                    load,
    input  wire [FLAGS-1:0]        flags_in,
    output wire [FLAGS-1:0]        flags,
    input  wire                    clear,
    input  wire                    run,
    input  wire                    obstacle_pass,
    input  wire [COUNTER_BITS-1:0] counter,
    input  wire [3:0]              straight,       // y of N, E, S, W
    input  wire [3:0]              diagonal,       // y of NE, SE, SW, NW
    input  wire [3:0]              beside,         // open of N, E, S, W
    input  wire                    shift,
    input  wire [WORD-1:0]         word_in,
    output wire [WORD-1:0]         word,
    output wire                    open,
    output wire                    y,
    output wire                    moving
);
    localparam ENTRY = DIAGONAL - STRAIGHT;
    localparam KEEPS = SAFE != 0 && CHAIN == 0;
    localparam F_AT = BITS + OBSTACLE_BITS;
    localparam P_AT = F_AT + (CORNER_CUTTING != 0 ? 0 : 1);

    wire pass = SAFE != 0 ? obstacle_pass : 1'b0;

    // F, Z and P: a word of nodes at a time moves through the array. F = 0 and Z = 1: outside of the map.
    wire f, z;
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
    reg z_bit;
    always @(posedge clk) if (load) z_bit <= flags_in[1];
    assign z = z_bit;
    assign flags[1:0] = {z, f};
    assign open = f | pass;

    // The OR gates. Without corner cutting a diagonal input waits for both nodes beside the step.
    wire straight_in = |straight;
    wire diagonal_in;
    generate
        if (CORNER_CUTTING != 0) begin : cuts
            assign diagonal_in = |diagonal;
        end else begin : keeps_corners
            assign diagonal_in = (diagonal[0] & beside[1] | diagonal[3] & beside[3]) & beside[0]
                               | (diagonal[1] & beside[1] | diagonal[2] & beside[3]) & beside[2];
        end
    endgenerate

    // The delay line.
    reg [DIAGONAL-1:0] line;
    genvar stage;
    generate
        for (stage = 0; stage < DIAGONAL; stage = stage + 1) begin : flip_flop
            wire incoming;
            if (stage == 0) begin : head
                assign incoming = diagonal_in;
            end else begin : behind
                assign incoming = line[stage-1];
            end
            if (stage == ENTRY) begin : joined
                always @(posedge clk) line[stage] <= clear ? 1'b0 : incoming | straight_in;
            end else begin : alone
                always @(posedge clk) line[stage] <= clear ? 1'b0 : incoming;
            end
        end
    endgenerate

    // A penalised node has a longer line (section "Conclusion"); the wave from the obstacles knows no penalty.
    wire arrived;
    generate
        if (EXTRA > 0) begin : penalty
            reg p_bit;
            reg [EXTRA-1:0] late;
            if (CHAIN != 0) begin : p_in_chain
                always @(posedge clk)
                    if (load) p_bit <= flags_in[2];
                    else if (shift) p_bit <= word_in[P_AT];
            end else begin : p_alone
                always @(posedge clk) if (load) p_bit <= flags_in[2];
            end
            if (EXTRA == 1) begin : one_more
                always @(posedge clk) late <= clear ? 1'b0 : line[DIAGONAL-1];
            end else begin : several
                always @(posedge clk) late <= clear ? {EXTRA{1'b0}} : {late[EXTRA-2:0], line[DIAGONAL-1]};
            end
            assign flags[2] = p_bit;
            assign word[P_AT] = p_bit;
            assign arrived = p_bit & ~pass ? late[EXTRA-1] : line[DIAGONAL-1];
        end else begin : no_penalty
            assign arrived = line[DIAGONAL-1];
        end
    endgenerate

    // y = arrived and F, or Z. In the wave from the obstacles every node is free, and obstacles are the sources.
    assign y = f ? arrived | z & ~pass : pass & ~z;

    // The wave is still on its way to this node.
    generate
        if (WAITS != 0) begin : no_silence
            assign moving = 1'b0;
        end else begin : silence
            assign moving = f & ~y & (straight_in | diagonal_in);
        end
    endgenerate

    // The register, and p^d beside it unless it was read out before p^t.
    reg [BITS-1:0] register;
    generate
        if (CHAIN != 0) begin : chained
            always @(posedge clk)
                if (load) register <= {BITS{1'b0}};
                else if (shift) register <= word_in[BITS-1:0];
                else if (run & ~y) register <= counter[BITS-1:0];
        end else begin : addressed
            always @(posedge clk)
                if (load | pass) register <= {BITS{1'b0}};
                else if (run & ~y) register <= counter[BITS-1:0];
        end
        if (KEEPS) begin : obstacle
            reg [OBSTACLE_BITS-1:0] obstacle_register;
            always @(posedge clk)
                if (load) obstacle_register <= {OBSTACLE_BITS{1'b0}};
                else if (run & pass & ~y) obstacle_register <= counter[OBSTACLE_BITS-1:0];
            assign word[BITS +: OBSTACLE_BITS] = obstacle_register;
        end
        if (CORNER_CUTTING == 0) begin : shown
            assign word[F_AT] = f;
        end
    endgenerate
    assign word[BITS-1:0] = register;

    // Inputs that other parameters need.
    wire unused = &{1'b0, beside, shift, word_in, straight, counter, line};
endmodule
