// A cell around the tile: it emits from the time of its potential on, and no wave enters it.
//
// The counter is one ahead of the time, so that y rises with the time that the cell was given.
module halo_cell #(
    parameter BITS = 6
) (
    input  wire            clk,
    input  wire            take,
    input  wire            open_in,        // a free cell of the map
    input  wire            live_in,        // with a potential
    input  wire [BITS-1:0] potential_in,
    input  wire            count,
    input  wire [BITS-1:0] counter,
    output reg             open,
    output reg             live,
    output reg  [BITS-1:0] potential,
    output reg             y
);
    always @(posedge clk)
        if (take) begin
            open <= open_in;
            live <= live_in;
            potential <= potential_in;
            y <= 1'b0;
        end else if (count && live && potential == counter) y <= 1'b1;
endmodule
