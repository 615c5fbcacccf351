// A node of the harmonic array (Girau et al. 2008, section 5.2): h <- (N + E + S + W) / 4, least significant bit first.
//
// Words of the node in its memory, most significant first: the flag of a fixed node, then p bits of its value. A goal
// is a fixed node with 1 in its highest bit, an obstacle one with 0. The value of a goal is 2^p: p zeros, then a 1.
//
//   slot             0    1    2    ..   p - 1    p          p + 1 (pre: the flag of the next pass is read)
//   stored           b_0  b_1  b_2  ..   b_p-1    -          flag
//   stream           b_0  b_1  b_2  ..   b_p-1    goal       0
//   sum              s_0  s_1  s_2  ..   s_p-1    s_p        s_p+1
//   written                    h_0  ..   h_p-3    h_p-2      h_p-1        h_i = s_i+2: the delay divides by 4
//
// PIPELINE = 1 registers the stream and the bit that is written: + 4 flip-flops.
module harmonic_node #(
    parameter PIPELINE = 0
) (
    input  wire clk,
    input  wire integer_slot,  // slots p and p + 1, when their words are stored's
    input  wire flag_slot,     // slot p + 1, when stored is the flag
    input  wire last,          // slot p + 1, when its bit is on the stream
    input  wire first,         // slot 0, when its bit is on the stream
    input  wire quiet,         // slots 0 and 1, when their bits are on the stream
    input  wire stored,
    input  wire north,
    input  wire east,
    input  wire south,
    input  wire west,
    output wire stream,
    output wire written,       // for the memory of the node
    output wire border,        // for a border memory: as on the stream
    output wire changed,       // during slot 0 of the next pass: some bit of the value changed
    output wire maximum        // at the same time: a free node, and no neighbour was greater
);
    reg fixed, delay_1, delay_2;
    wire emitted = integer_slot ? fixed & delay_1 : stored & ~fixed;

    always @(posedge clk) begin
        if (flag_slot) fixed <= stored;
        delay_1 <= stored & ~integer_slot;
        delay_2 <= delay_1;
    end

    // The bits at the time of the sum: the stream, whether the node is fixed, and bit i of the old value beside s_i+2.
    wire held, old;
    generate
        if (PIPELINE != 0) begin : streams
            reg stream_bit, fixed_before, delay_3;
            always @(posedge clk) begin
                stream_bit <= emitted;
                fixed_before <= fixed;
                delay_3 <= delay_2;
            end
            assign stream = stream_bit;
            assign held = fixed_before;
            assign old = delay_3;
        end else begin : streams
            assign stream = emitted;
            assign held = fixed;
            assign old = delay_2;
        end
    endgenerate

    // Three full adders: s = (N + E) + (S + W).
    reg carry_1, carry_2, carry_3;
    wire north_east = north ^ east ^ carry_1;
    wire south_west = south ^ west ^ carry_2;
    wire sum = north_east ^ south_west ^ carry_3;
    always @(posedge clk) begin
        if (last) begin
            carry_1 <= 1'b0;
            carry_2 <= 1'b0;
            carry_3 <= 1'b0;
        end else begin
            carry_1 <= (north & east) | (carry_1 & (north | east));
            carry_2 <= (south & west) | (carry_2 & (south | west));
            carry_3 <= (north_east & south_west) | (carry_3 & (north_east | south_west));
        end
    end

    // A fixed node keeps its words.
    wire next = held ? old : sum;
    generate
        if (PIPELINE != 0) begin : writes
            reg written_bit, border_bit;
            always @(posedge clk) begin
                written_bit <= next;
                border_bit <= sum & ~held;
            end
            assign written = written_bit;
            assign border = border_bit;
        end else begin : writes
            assign written = next;
            assign border = sum & ~held;
        end
    endgenerate

    // Stability: has a bit of the value changed?
    reg differs;
    always @(posedge clk) begin
        if (quiet) differs <= 1'b0;
        else differs <= differs | (next ^ old);
    end
    assign changed = differs;

    // Local maximum (section 4.1): no neighbour is greater. The last bit that differs is the highest one. A fixed node
    // counts as one with a greater neighbour.
    reg greater_north, greater_east, greater_south, greater_west;
    always @(posedge clk) begin
        greater_north <= held | (north == stream ? greater_north & ~first : north);
        greater_east <= east == stream ? greater_east & ~first : east;
        greater_south <= south == stream ? greater_south & ~first : south;
        greater_west <= west == stream ? greater_west & ~first : west;
    end
    assign maximum = ~(greater_north | greater_east | greater_south | greater_west);
endmodule
