// The states of the robots that one update unit computes (section III, the store of the robots' states).
//
// DEPTH = 1: registers. Otherwise memories of LUTs, with a port that writes and a port that reads without a clock.
module state_bank #(
    parameter WIDTH = 16,
    parameter DEPTH = 1,
    parameter ADDRESS_BITS = 1
) (
    input  wire                    clk,
    input  wire                    write_position,
    input  wire                    write_velocity,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [2*WIDTH-1:0]      write_data,
    input  wire [ADDRESS_BITS-1:0] read_address,
    output wire [2*WIDTH-1:0]      position,
    output wire [2*WIDTH-1:0]      velocity
);
    generate
        if (DEPTH == 1) begin : single
            reg [2*WIDTH-1:0] position_word, velocity_word;
            always @(posedge clk) begin
                if (write_position) position_word <= write_data;
                if (write_velocity) velocity_word <= write_data;
            end
            assign position = position_word;
            assign velocity = velocity_word;
            wire unused_addresses = &{1'b0, write_address, read_address};
        end else begin : several
            reg [2*WIDTH-1:0] positions [0:DEPTH-1];
            reg [2*WIDTH-1:0] velocities [0:DEPTH-1];
            always @(posedge clk) begin
                if (write_position) positions[write_address] <= write_data;
                if (write_velocity) velocities[write_address] <= write_data;
            end
            assign position = positions[read_address];
            assign velocity = velocities[read_address];
        end
    endgenerate
endmodule
