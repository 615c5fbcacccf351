// A memory of two bits a cell: the search writes and reads it, and a display may look at it.
//
// SHOWN = 0: no display. The search has a port to write and a port to read.
// SHOWN = 1: the search writes or reads on one port, the display reads on the other (section 3.1.1, VGA controller).
//            The search writes and reads at one address, which is read_address.
// SHOWN = 2: the display has a copy of its own, which is written with the original.
module breadth_first_memory #(
    parameter ADDRESS_BITS = 14,
    parameter SHOWN = 0
) (
    input  wire                    clk,
    input  wire                    write_enable,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [1:0]              write_data,
    input  wire                    read_enable,
    input  wire [ADDRESS_BITS-1:0] read_address,
    output wire [1:0]              read_data,
    input  wire [ADDRESS_BITS-1:0] shown_address,
    output wire [1:0]              shown_data
);
    generate
        if (SHOWN == 1) begin : shared
            ram_2rw #(.WIDTH(2), .DEPTH(1 << ADDRESS_BITS), .ADDRESS_BITS(ADDRESS_BITS), .OUTPUT_REGISTER(1)) ram (
                .clk(clk),
                .enable_a(write_enable || read_enable), .write_a(write_enable), .address_a(read_address),
                .write_data_a(write_data), .read_data_a(read_data),
                .enable_b(1'b1), .write_b(1'b0), .address_b(shown_address),
                .write_data_b(2'd0), .read_data_b(shown_data)
            );
            wire unused = &{1'b0, write_address};
        end else begin : own
            ram_1w1r #(.WIDTH(2), .DEPTH(1 << ADDRESS_BITS), .ADDRESS_BITS(ADDRESS_BITS), .OUTPUT_REGISTER(1)) ram (
                .clk(clk),
                .write_enable(write_enable), .write_address(write_address), .write_data(write_data),
                .read_enable(read_enable), .read_address(read_address), .read_data(read_data)
            );
        end
        if (SHOWN == 2) begin : copy
            ram_1w1r #(.WIDTH(2), .DEPTH(1 << ADDRESS_BITS), .ADDRESS_BITS(ADDRESS_BITS), .OUTPUT_REGISTER(1)) ram (
                .clk(clk),
                .write_enable(write_enable), .write_address(write_address), .write_data(write_data),
                .read_enable(1'b1), .read_address(shown_address), .read_data(shown_data)
            );
        end
        if (SHOWN == 0) begin : unseen
            assign shown_data = 2'd0;
            wire unused = &{1'b0, shown_address};
        end
    endgenerate
endmodule
