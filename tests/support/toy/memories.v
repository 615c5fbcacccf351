// Both shared memories with their words at the outputs, for tests of synthesis alone.
module memories #(
    parameter OUTPUT_REGISTER = 0
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        start,
    input  wire        in_data,
    input  wire        in_valid,
    output wire        in_ready,
    output wire [3:0]  phase,
    output wire        event_valid,
    output wire [3:0]  event_kind,
    output wire [17:0] event_data,
    output wire        done
);
    reg [9:0] read_address, write_address;
    reg [17:0] word;
    wire [17:0] one_port, port_a, port_b;

    always @(posedge clk) begin
        read_address <= {read_address[8:0], in_data};
        write_address <= {write_address[8:0], in_valid};
        word <= {word[16:0], in_data};
    end

    ram_1w1r #(.WIDTH(18), .DEPTH(1024), .ADDRESS_BITS(10), .OUTPUT_REGISTER(OUTPUT_REGISTER)) narrow (
        .clk(clk), .write_enable(start), .write_address(write_address), .write_data(word),
        .read_enable(1'b1), .read_address(read_address), .read_data(one_port)
    );
    ram_2rw #(.WIDTH(18), .DEPTH(1024), .ADDRESS_BITS(10), .OUTPUT_REGISTER(OUTPUT_REGISTER)) wide (
        .clk(clk), .enable_a(1'b1), .write_a(start), .address_a(write_address), .write_data_a(word),
        .read_data_a(port_a), .enable_b(1'b1), .write_b(1'b0), .address_b(read_address),
        .write_data_b(18'd0), .read_data_b(port_b)
    );

    assign in_ready = reset;
    assign phase = 4'd0;
    assign event_valid = start;
    assign event_kind = 4'd0;
    assign event_data = one_port ^ port_a ^ port_b;
    assign done = 1'b0;
endmodule
