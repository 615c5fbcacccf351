// The decision (Girau et al. 2008, section 5.3): the triangle of a node h with the greatest (h - h')^2 + (h - h'')^2.
//
// Each triangle has one of N, S and one of E, W, so the greatest difference of each pair is chosen apart, and
//     |b - h| > |a - h|   <=>   (b - a) (a + b - 2 h) > 0:
// the signs of two serial subtractions, least significant digit first, no square. The direction goes towards a higher
// neighbour and away from a lower one. One axis: a is north or east, b south or west; ties go to a.
module harmonic_decision #(
    parameter DIGIT_BITS = 1
) (
    input  wire                  clk,
    input  wire                  first,   // the digits are the lowest ones
    input  wire [DIGIT_BITS-1:0] here,
    input  wire [DIGIT_BITS-1:0] a,
    input  wire [DIGIT_BITS-1:0] b,
    output wire                  second,  // b is chosen
    output wire                  rises,   // the chosen neighbour is higher
    output wire                  differs  // the chosen neighbour is not equal
);
    // Of each comparison: is the left side greater, are the sides unequal? The last digit that differs decides.
    reg b_over_a, b_unlike_a, total_over, total_unlike, a_over, a_unlike, b_over, b_unlike;
    reg carry, here_before;
    wire carry_in = carry & ~first;
    wire [DIGIT_BITS:0] sum = {1'b0, a} + {1'b0, b} + {{DIGIT_BITS{1'b0}}, carry_in};
    wire [DIGIT_BITS:0] doubled = {here, here_before & ~first};
    wire [DIGIT_BITS-1:0] total = sum[DIGIT_BITS-1:0], twice = doubled[DIGIT_BITS-1:0];
    always @(posedge clk) begin
        carry <= sum[DIGIT_BITS];
        here_before <= doubled[DIGIT_BITS];
        b_over_a <= b == a ? b_over_a & ~first : b > a;
        b_unlike_a <= b != a || (b_unlike_a && !first);
        total_over <= total == twice ? total_over & ~first : total > twice;
        total_unlike <= total != twice || (total_unlike && !first);
        a_over <= a == here ? a_over & ~first : a > here;
        a_unlike <= a != here || (a_unlike && !first);
        b_over <= b == here ? b_over & ~first : b > here;
        b_unlike <= b != here || (b_unlike && !first);
    end
    assign second = b_unlike_a && total_unlike && b_over_a == total_over;
    assign rises = second ? b_over : a_over;
    assign differs = second ? b_unlike : a_unlike;
endmodule
