// The directions halfway between those of the array of velocities, in the first octant: cosine (low half) and sine.
module direction_bounds #(
    parameter WIDTH = 16,
    parameter ADDRESS_BITS = 3,
    parameter IMAGE = "bounds.hex"
) (
    input  wire [ADDRESS_BITS-1:0]  address,
    output wire signed [WIDTH-1:0] cosine,
    output wire signed [WIDTH-1:0] sine
);
    reg [2*WIDTH-1:0] bounds [0:(1<<ADDRESS_BITS)-1];
    initial $readmemh(IMAGE, bounds);
    wire [2*WIDTH-1:0] bound = bounds[address];
    assign cosine = bound[WIDTH-1:0];
    assign sine = bound[2*WIDTH-1:WIDTH];
endmodule
