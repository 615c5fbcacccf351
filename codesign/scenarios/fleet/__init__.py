"""Scenario ``fleet``: n robots with an FPGA each, and a line that takes all coordinates to a display.

In an update every robot decides on its own FPGA, all from the same state, in as many cycles as its own candidates
and trials take. The state is common, so all wait for the last one; how they come to know it the paper does not say,
and here it takes no time. Then the coordinates of all robots are one message to the component that draws them
("the co-ordinates of all the robots are being transmitted through an on-board serial port", Dubey et al. 2013, section
VI): the first robot's board sends it, the one that the platform file declares.

Planner and timing run in step: each update's time follows from its own candidates and trials, and the state that the
next one is decided from follows from that time.

- ``real_time``: the robots drive in the time of the simulation. An update begins with a time step. One that is decided
  within it acts in that step, as the planner assumes and as the paper has it. One that takes longer is missed and acts
  late: the robots drive on with the velocities that they have until the end of the time step in which the last of
  them has decided, and only then take the new ones, in one more step. The next update begins after that. Nobody waits
  for the line: while it has not taken over a message, later ones are skipped.
- ``free_running``: the robots are simulated by the boards themselves, as in the paper's test bed, so they stand still
  while the boards decide, and every update takes them one time step on. An update begins once all have decided the one
  before and its message stands in the line's FIFO. So the robots' clock is not that of the boards:
  ``FleetFigures.robots_ps`` is the one and ``span_ps`` the other.

A run that is stopped reaches up to the end of the last update that was over. FPGAs beyond the first are no components
of the platform; they tell nobody anything.
"""
