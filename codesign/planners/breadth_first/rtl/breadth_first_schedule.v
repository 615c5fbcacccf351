// The cycles of one expansion (Vacariu et al. 2008, Listing 1: pop, then north, south, west, east).
//
// A cell that is read in cycle t is known in cycle t + 2, as its memory has an output register. CYCLES is
//   14: each neighbour takes three cycles (read, wait, mark), and one port serves both.
//    9: each takes two. A mark takes the cycle between two reads, so one port is enough.
//    6: the four follow each other. Reads and marks have a port each.
module breadth_first_schedule #(
    parameter CYCLES = 14
) (
    input  wire [3:0] cycle,
    output reg        read,
    output reg  [1:0] read_side,
    output reg        mark,
    output reg  [1:0] mark_side,
    output wire       last
);
    localparam [31:0] LAST = CYCLES - 1;
    assign last = cycle == LAST[3:0];

    generate
        if (CYCLES == 14) begin : three_cycles
            always @* begin
                read = cycle == 4'd1 || cycle == 4'd4 || cycle == 4'd7 || cycle == 4'd10;
                mark = cycle == 4'd3 || cycle == 4'd6 || cycle == 4'd9 || cycle == 4'd12;
                if (cycle <= 4'd3) mark_side = 2'd0;
                else if (cycle <= 4'd6) mark_side = 2'd1;
                else if (cycle <= 4'd9) mark_side = 2'd2;
                else mark_side = 2'd3;
                read_side = mark_side;
            end
        end else if (CYCLES == 9) begin : two_cycles
            always @* begin
                read = cycle == 4'd0 || cycle == 4'd2 || cycle == 4'd4 || cycle == 4'd6;
                mark = cycle == 4'd3 || cycle == 4'd5 || cycle == 4'd7 || cycle == 4'd8;
                case (cycle)
                    4'd2, 4'd5: mark_side = 2'd1;
                    4'd4, 4'd7: mark_side = 2'd2;
                    4'd6, 4'd8: mark_side = 2'd3;
                    default: mark_side = 2'd0;
                endcase
                read_side = mark_side;
            end
        end else begin : pipelined
            always @* begin
                read = cycle <= 4'd3;
                read_side = cycle[1:0];
                mark = cycle >= 4'd2;
                mark_side = cycle < 4'd2 ? 2'd0 : {cycle[2], cycle[0]};
            end
        end
    endgenerate
endmodule
