// The decision (Girau et al. 2008, section 5.3): the triangle of a node h with the greatest (h - h')^2 + (h - h'')^2.
//
// Each triangle has one of N, S and one of E, W, so the greatest difference of each pair is chosen apart, and
//     |b - h| > |a - h|   <=>   (b - a) (a + b - 2 h) > 0:
// the signs of two serial subtractions, least significant bit first, no square. The direction goes towards a higher
// neighbour and away from a lower one. One axis: a is north or east, b south or west; ties go to a.
module harmonic_decision (
    input  wire clk,
    input  wire first,    // the bits are the lowest ones
    input  wire here,
    input  wire a,
    input  wire b,
    output wire second,   // b is chosen
    output wire rises,    // the chosen neighbour is higher
    output wire differs   // the chosen neighbour is not equal
);
    // Of each comparison: is the left side greater, are the sides unequal? The last bit that differs decides.
    reg b_over_a, b_unlike_a, total_over, total_unlike, a_over, a_unlike, b_over, b_unlike;
    reg carry, here_before;
    wire carry_in = carry & ~first;
    wire total = a ^ b ^ carry_in;
    wire twice = here_before & ~first;
    always @(posedge clk) begin
        carry <= (a & b) | (carry_in & (a | b));
        here_before <= here;
        b_over_a <= b == a ? b_over_a & ~first : b;
        b_unlike_a <= b != a || (b_unlike_a && !first);
        total_over <= total == twice ? total_over & ~first : total;
        total_unlike <= total != twice || (total_unlike && !first);
        a_over <= a == here ? a_over & ~first : a;
        a_unlike <= a != here || (a_unlike && !first);
        b_over <= b == here ? b_over & ~first : b;
        b_unlike <= b != here || (b_unlike && !first);
    end
    assign second = b_unlike_a && total_unlike && b_over_a == total_over;
    assign rises = second ? b_over : a_over;
    assign differs = second ? b_unlike : a_unlike;
endmodule
