"""Scenario ``fleet``: n robots with an FPGA each, and a line that takes all coordinates to a display.

In an update every robot decides on its own FPGA, in as many cycles as its own candidates and trials take. All decide
from the same state, so all wait for the last one. The paper does not say how they exchange that state; here it takes no
time. Then one message takes the coordinates of all robots to the component that draws them ("the co-ordinates of all
the robots are being transmitted through an on-board serial port", Dubey et al. 2013, section VI). The board of the
first robot sends it: the one that the platform file declares.

Planner and timing run in step: the time of an update follows from its own candidates and trials, and the state from
which the next update is decided follows from that time.

- ``real_time``: the robots drive in the time of the simulation. An update begins with a time step. An update that is
  decided within that step acts in it, as the planner and the paper assume. An update that takes longer is missed and
  acts late: the robots keep their velocities until the end of the time step in which the last of them has decided.
  Then they take the new velocities, in one more step, and the next update begins after that. No robot waits for the
  line: while it has not taken over a message, later ones are skipped.
- ``free_running``: the robots are simulated by the boards themselves, as in the paper's test bed, so they stand still
  while the boards decide, and every update moves them by one time step. An update begins once all have decided the
  update before it and its message is in the line's FIFO. So the robots' clock is not the clock of the boards:
  ``FleetFigures.robots_s`` is the one and ``span_s`` the other.

The figures of a run that is stopped reach up to the end of its last complete update. FPGAs beyond the first are no
components of the platform and make no records.
"""
