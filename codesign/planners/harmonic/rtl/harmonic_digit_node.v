// A node that takes digits of DIGIT_BITS bits a cycle: h <- (N + E + S + W) / 4, least significant digit first.
//
// The words are those of harmonic_node with digits in place of bits: the flag of a fixed node in the highest bit, then
// L digits. A precision of p bits has L = p / DIGIT_BITS digits, rounded up; the bits of the lowest digit below the p-th
// are 0. The mask keeps them so, since a value is cut off at p bits. A goal has 1 in the highest bit of its first digit.
//
//   slot             0    1    2    ..   L - 1    L          L + 1 (pre: the flag of the next pass is read)
//   stored           b_0  b_1  b_2  ..   b_L-1    -          flag
//   stream           b_0  b_1  b_2  ..   b_L-1    goal       0
//   sum              s_0  s_1  s_2  ..   s_L-1    s_L        0
//   written               h_0  h_1  ..   h_L-2    h_L-1      -          h_j: two bits of s_j+1 above the rest of s_j
//
// PIPELINE = 1 registers the stream and the digit that is written.
module harmonic_digit_node #(
    parameter DIGIT_BITS = 2,
    parameter PIPELINE = 0
) (
    input  wire                  clk,
    input  wire                  integer_slot,  // slots L and L + 1, when their words are stored's
    input  wire                  flag_slot,     // slot L + 1, when stored is the flag
    input  wire                  last,          // slot L + 1, when its digit is on the stream
    input  wire                  first,         // slot 0, when its digit is on the stream
    input  wire [DIGIT_BITS-1:0] mask,          // the bits of the digit that is written
    input  wire [DIGIT_BITS-1:0] stored,
    input  wire [DIGIT_BITS-1:0] north,
    input  wire [DIGIT_BITS-1:0] east,
    input  wire [DIGIT_BITS-1:0] south,
    input  wire [DIGIT_BITS-1:0] west,
    output wire [DIGIT_BITS-1:0] stream,
    output wire [DIGIT_BITS-1:0] written,       // for the memory of the node
    output wire [DIGIT_BITS-1:0] border,        // for a border memory: as on the stream
    output wire                  changed,       // during slot 0 of the next pass: some bit of the value changed
    output wire                  maximum        // at the same time: a free node, and no neighbour was greater
);
    localparam TOP = DIGIT_BITS - 1;

    reg fixed;
    reg [TOP:0] delay_1;
    wire [TOP:0] goal = {{TOP{1'b0}}, fixed & delay_1[TOP]};
    wire [TOP:0] emitted = integer_slot ? goal : stored & {DIGIT_BITS{~fixed}};

    always @(posedge clk) begin
        if (flag_slot) fixed <= stored[TOP];
        delay_1 <= stored & {DIGIT_BITS{~integer_slot}};
    end

    // The digits at the time of the sum: the stream, whether the node is fixed, and digit j of the old value beside s_j+1.
    wire held;
    wire [TOP:0] old;
    generate
        if (PIPELINE != 0) begin : streams
            reg fixed_before;
            reg [TOP:0] stream_digit, delay_2;
            always @(posedge clk) begin
                stream_digit <= emitted;
                fixed_before <= fixed;
                delay_2 <= delay_1;
            end
            assign stream = stream_digit;
            assign held = fixed_before;
            assign old = delay_2;
        end else begin : streams
            assign stream = emitted;
            assign held = fixed;
            assign old = delay_1;
        end
    endgenerate

    // Three adders: s = (N + E) + (S + W).
    reg carry_1, carry_2, carry_3;
    wire [TOP+1:0] north_east = {1'b0, north} + {1'b0, east} + {{DIGIT_BITS{1'b0}}, carry_1};
    wire [TOP+1:0] south_west = {1'b0, south} + {1'b0, west} + {{DIGIT_BITS{1'b0}}, carry_2};
    wire [TOP+1:0] sum = {1'b0, north_east[TOP:0]} + {1'b0, south_west[TOP:0]} + {{DIGIT_BITS{1'b0}}, carry_3};
    always @(posedge clk) begin
        carry_1 <= north_east[TOP+1] & ~last;
        carry_2 <= south_west[TOP+1] & ~last;
        carry_3 <= sum[TOP+1] & ~last;
    end

    // The division by 4 moves the sum by two bits.
    wire [TOP:0] quarter;
    generate
        if (DIGIT_BITS > 2) begin : shift
            reg [TOP-2:0] rest;
            always @(posedge clk) rest <= sum[TOP:2];
            assign quarter = {sum[1:0], rest};
        end else begin : shift
            assign quarter = sum[1:0];
        end
    endgenerate

    // A fixed node keeps its words.
    wire [TOP:0] result = quarter & mask;
    wire [TOP:0] next = held ? old : result;
    generate
        if (PIPELINE != 0) begin : writes
            reg [TOP:0] written_digit, border_digit;
            always @(posedge clk) begin
                written_digit <= next;
                border_digit <= result & {DIGIT_BITS{~held}};
            end
            assign written = written_digit;
            assign border = border_digit;
        end else begin : writes
            assign written = next;
            assign border = result & {DIGIT_BITS{~held}};
        end
    endgenerate

    // Stability: has a digit of the value changed?
    reg differs;
    always @(posedge clk) differs <= ~first & (differs | next != old);
    assign changed = differs;

    // Local maximum (section 4.1): no neighbour is greater. The last digit that differs is the highest one. A fixed node
    // counts as one with a greater neighbour.
    reg greater_north, greater_east, greater_south, greater_west;
    always @(posedge clk) begin
        greater_north <= held | (north == stream ? greater_north & ~first : north > stream);
        greater_east <= east == stream ? greater_east & ~first : east > stream;
        greater_south <= south == stream ? greater_south & ~first : south > stream;
        greater_west <= west == stream ? greater_west & ~first : west > stream;
    end
    assign maximum = ~(greater_north | greater_east | greater_south | greater_west);
endmodule
