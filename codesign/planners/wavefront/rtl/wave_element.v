// A processing element of the wave: one node of the delay line for CELLS cells of a column, which take turns.
//
// Line, register and F, Z, P of the cells are in a memory. In each cycle the element reads the state of a cell, and
// writes the state after this step of the wave. All elements are at the same row of their cells. The outputs y of this
// step are in a ring of CELLS bits, so that the rows above and below are seen as well:
//
//   row j - 1   up: the bit that left the ring last; at the first cell the last bit of the element above
//   row j       ring[0]
//   row j + 1   down: ring[1]; at the last cell the first bit of the element below, as it was in this step
module wave_element #(
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter WAITS = 1,            // 1: the wave ends at a start, so that nobody asks for moving
    parameter SAFE = 0,
    parameter CELLS = 4,            // a power of two, 2 or more
    parameter CELL_BITS = 2,
    parameter BITS = 11,
    parameter OBSTACLE_BITS = 0,
    parameter COUNTER_BITS = 11,
    parameter FLAGS = 2,
    parameter WORD = 11
) (
    input  wire                    clk,
    input  wire                    load,
    input  wire [FLAGS-1:0]        flags_in,
    output wire [FLAGS-1:0]        flags,
    input  wire                    place,          // writes the loaded flags to the memory
    input  wire                    run,
    input  wire                    clear,          // the last step of the wave from the obstacles
    input  wire                    obstacle_pass,
    input  wire [COUNTER_BITS-1:0] counter,
    input  wire                    at_first,
    input  wire                    at_last,
    input  wire [CELL_BITS-1:0]    cell_number,
    input  wire [CELL_BITS-1:0]    read_cell,
    input  wire                    above,          // ring_end of the element above, first_bit of the one below
    input  wire                    below,
    input  wire [2:0]              left,           // column of the element on the left: down, middle, up
    input  wire [2:0]              right,
    input  wire                    above_open,
    input  wire                    below_open,
    input  wire                    left_open,
    input  wire                    right_open,
    output wire                    ring_end,
    output wire                    first_bit,
    output wire [2:0]              column,
    output wire                    open_end,
    output wire                    open_next,
    output wire                    open,
    output wire [WORD-1:0]         word,
    output wire                    moving
);
    localparam ENTRY = DIAGONAL - STRAIGHT;
    localparam REGISTERS = BITS + OBSTACLE_BITS;
    localparam LINE_AT = REGISTERS + FLAGS;
    localparam LATE_AT = LINE_AT + DIAGONAL;
    localparam STATE = LATE_AT + EXTRA;
    localparam P_AT = REGISTERS + (CORNER_CUTTING != 0 ? 0 : 1);

    wire pass = SAFE != 0 ? obstacle_pass : 1'b0;
    wire [STATE-1:0] state, next_state;
    ram_1w1r #(.WIDTH(STATE), .DEPTH(CELLS), .ADDRESS_BITS(CELL_BITS)) cells (
        .clk(clk), .write_enable(place | run), .write_address(cell_number), .write_data(next_state),
        .read_enable(1'b1), .read_address(read_cell), .read_data(state)
    );

    // The flags of the next row of cells, on their path through the array.
    reg [FLAGS-1:0] staged;
    always @(posedge clk) if (load) staged <= flags_in;
    assign flags = staged;
    wire f = place ? staged[0] : state[REGISTERS];
    wire z = place ? staged[1] : state[REGISTERS+1];
    assign next_state[REGISTERS] = f;
    assign next_state[REGISTERS+1] = z;

    // The rings: y of every cell in this step, and F where corners may not be cut.
    wire y_next;
    reg [CELLS-1:0] ring;
    reg previous, first;
    always @(posedge clk) begin
        if (place | run) ring <= {y_next, ring[CELLS-1:1]};
        previous <= ring[0];
        if (at_first) first <= ring[0];
    end
    wire up = at_first ? above : previous;
    wire down = at_last ? below : ring[1];
    wire y = ring[0];
    assign ring_end = ring[CELLS-1];
    assign first_bit = first;
    assign column = {down, y, up};

    // The node, as delay_line_node has it.
    wire straight_in = up | right[1] | down | left[1];
    wire diagonal_in;
    generate
        if (CORNER_CUTTING != 0) begin : cuts
            assign diagonal_in = right[0] | right[2] | left[2] | left[0];
            assign {open_end, open_next, open} = 3'b000;
        end else begin : keeps_corners
            reg [CELLS-1:0] open_ring;
            always @(posedge clk) if (place | run) open_ring <= {f, open_ring[CELLS-1:1]};
            wire open_up = at_first ? above_open : open_ring[CELLS-1] | pass;
            wire open_down = at_last ? below_open : open_ring[1] | pass;
            assign open_end = open_ring[CELLS-1] | pass;
            assign open_next = open_ring[1] | pass;
            assign open = open_ring[0] | pass;
            assign diagonal_in = (right[0] & right_open | left[0] & left_open) & open_up
                               | (right[2] & right_open | left[2] & left_open) & open_down;
        end
    endgenerate
    wire [DIAGONAL-1:0] line = state[LINE_AT +: DIAGONAL];
    wire [DIAGONAL-1:0] line_next;
    wire empty = place | clear;
    genvar stage;
    generate
        for (stage = 0; stage < DIAGONAL; stage = stage + 1) begin : line_bit
            wire incoming;
            if (stage == 0) begin : head
                assign incoming = diagonal_in;
            end else begin : behind
                assign incoming = line[stage-1];
            end
            if (stage == ENTRY) begin : joined
                assign line_next[stage] = ~empty & (incoming | straight_in);
            end else begin : alone
                assign line_next[stage] = ~empty & incoming;
            end
        end
    endgenerate
    assign next_state[LINE_AT +: DIAGONAL] = line_next;
    wire arrived_next;
    generate
        if (EXTRA > 0) begin : penalty
            wire p = place ? staged[2] : state[REGISTERS+2];
            wire [EXTRA:0] late_line = {state[LATE_AT +: EXTRA], line[DIAGONAL-1]};
            wire unused_late = late_line[EXTRA];
            wire [EXTRA-1:0] late_next = empty ? {EXTRA{1'b0}} : late_line[EXTRA-1:0];
            assign next_state[REGISTERS+2] = p;
            assign next_state[LATE_AT +: EXTRA] = late_next;
            assign word[P_AT] = state[REGISTERS+2];
            assign arrived_next = p & ~pass ? late_next[EXTRA-1] : line_next[DIAGONAL-1];
        end else begin : no_penalty
            assign arrived_next = line_next[DIAGONAL-1];
        end
    endgenerate

    // y of the next step; as a wave begins, that of its sources.
    generate
        if (SAFE != 0) begin : two_waves
            wire obstacles_next = place | pass & ~clear;
            assign y_next = f ? arrived_next | z & ~obstacles_next : obstacles_next & ~z;
        end else begin : one_wave
            assign y_next = f & (arrived_next | z);
        end
    endgenerate
    generate
        if (WAITS != 0) begin : no_silence
            assign moving = 1'b0;
        end else begin : silence
            assign moving = f & ~y & (straight_in | diagonal_in);
        end
    endgenerate

    // The registers.
    wire [BITS-1:0] potential = state[BITS-1:0];
    assign next_state[BITS-1:0] = place | pass ? {BITS{1'b0}} : y ? potential : counter[BITS-1:0];
    generate
        if (SAFE != 0) begin : obstacle
            wire [OBSTACLE_BITS-1:0] distance = state[BITS +: OBSTACLE_BITS];
            assign next_state[BITS +: OBSTACLE_BITS] = place ? {OBSTACLE_BITS{1'b0}}
                : y | ~pass ? distance : counter[OBSTACLE_BITS-1:0];
        end
        if (CORNER_CUTTING == 0) begin : shown
            assign word[REGISTERS] = state[REGISTERS];
        end
    endgenerate
    assign word[REGISTERS-1:0] = state[REGISTERS-1:0];

    // Inputs that other parameters need.
    wire unused = &{1'b0, above_open, below_open, left_open, right_open, state, clear, obstacle_pass, counter, line};
endmodule
