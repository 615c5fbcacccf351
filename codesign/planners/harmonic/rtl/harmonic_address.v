// The read address of one kind of memory. Words of a block: BASE its flag, BASE + 1 its highest bit, ..
//
// During a pass of p bits (slots as in harmonic_node) it is BASE + p, .., BASE + 1, BASE, and then BASE of the next pass.
module harmonic_address #(
    parameter BITS = 10,
    parameter [BITS-1:0] ORIGIN = 0,  // BASE where the visited block is block 0
    parameter [BITS-1:0] STRIDE = 0   // from one block to the next
) (
    input  wire            clk,
    input  wire            home,      // block 0 follows
    input  wire            jump,      // the block at jump_base follows
    input  wire [BITS-1:0] jump_base,
    input  wire            wrap,      // the visited block is the last one
    input  wire            open,      // the next slot is the pre slot of a pass
    input  wire            advance,   // of the block that follows
    input  wire            pre,
    input  wire [BITS-1:0] precision,
    output reg  [BITS-1:0] address
);
    reg [BITS-1:0] base, next_base;

    always @(posedge clk) begin
        if (home) next_base <= ORIGIN;
        else if (jump) next_base <= jump_base + ORIGIN;
        else next_base <= wrap ? ORIGIN : base + STRIDE;
        if (open && advance) base <= next_base;
        if (open) address <= advance ? next_base : base;
        else address <= (pre ? base : address) + (pre ? precision : {BITS{1'b1}});
    end
endmodule
