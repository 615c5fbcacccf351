// The cycles of one expansion (Vacariu et al. 2008, Listing 1: pop, then north, south, west, east), from 0, the pop.
//
// A cell that is read in cycle t is known in cycle t + 2, as its memory has an output register. CYCLES is
//   14: each neighbour takes three cycles (read, wait, mark), and one port serves both.
//    9: each takes two. A mark takes the cycle between two reads, so one port is enough.
//    6: the four follow each other. Reads and marks have a port each.
//
// All outputs are registers. They belong to the cycle that the counter is in.
module breadth_first_schedule #(
    parameter CYCLES = 14
) (
    input  wire       clk,
    input  wire       run,
    input  wire       stop,
    output reg        read,
    output reg  [1:0] mark_side,
    output reg        mark,
    output reg        last,
    output reg  [3:0] next_move
);
    localparam [31:0] LAST = CYCLES - 1;
    reg [3:0] cycle;
    wire [3:0] ahead = run && !last ? cycle + 4'd1 : 4'd0;
    reg read_ahead, mark_ahead;
    reg [1:0] read_side, side_ahead;

    generate
        if (CYCLES == 14) begin : three_cycles
            always @* begin
                read_ahead = ahead == 4'd1 || ahead == 4'd4 || ahead == 4'd7 || ahead == 4'd10;
                mark_ahead = ahead == 4'd3 || ahead == 4'd6 || ahead == 4'd9 || ahead == 4'd12;
                if (ahead <= 4'd3) side_ahead = 2'd0;
                else if (ahead <= 4'd6) side_ahead = 2'd1;
                else if (ahead <= 4'd9) side_ahead = 2'd2;
                else side_ahead = 2'd3;
                read_side = side_ahead;
            end
        end else if (CYCLES == 9) begin : two_cycles
            always @* begin
                read_ahead = ahead == 4'd0 || ahead == 4'd2 || ahead == 4'd4 || ahead == 4'd6;
                mark_ahead = ahead == 4'd3 || ahead == 4'd5 || ahead == 4'd7 || ahead == 4'd8;
                case (ahead)
                    4'd2, 4'd5: side_ahead = 2'd1;
                    4'd4, 4'd7: side_ahead = 2'd2;
                    4'd6, 4'd8: side_ahead = 2'd3;
                    default: side_ahead = 2'd0;
                endcase
                read_side = side_ahead;
            end
        end else begin : pipelined
            always @* begin
                read_ahead = ahead <= 4'd3;
                read_side = ahead[1:0];
                mark_ahead = ahead >= 4'd2;
                side_ahead = ahead < 4'd2 ? 2'd0 : {ahead[2], ahead[0]};
            end
        end
    endgenerate

    // North, south, west, east: one of four bits.
    always @* next_move = 4'b1000 >> read_side;

    always @(posedge clk) begin
        cycle <= ahead;
        read <= read_ahead;
        mark <= run && !stop && mark_ahead;
        mark_side <= side_ahead;
        last <= run && !stop && ahead == LAST[3:0];
    end
endmodule
