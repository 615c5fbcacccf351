"""Scenario ``drive``: one robot senses, plans, decides, drives, discovers and plans again.

Three processes share one ``Scene``. The world changes at its own times. The ``Pilot`` makes a turn of the control loop
every control period. In a turn the robot's scan goes to task ``load``, planners that steer by a field decide at the
robot's pose, and a command goes to the robot: a path, and how far it may go on it. The ``Replanner`` makes plans beside
the turns when the pilot asks for one. Both queue for the components that they share.

The robot keeps itself safe. It may drive to the last point that is known to be free, and no farther than it could come
before it would miss an answer. Without a newer command it stands there. It brakes at once where a turn has
no answer at its deadline. Where the true map has an obstacle on its path that nothing on board could know of, the robot
stands before it, and a contact is counted. It is never inside an obstacle.

Two kernels cost what the platform's processor declares: keeping the map (``occupancy_cell``, a unit a cell
seen) and making a command (``way_following``). Assumed: the robot knows its pose exactly, looking around takes no time,
and clocks on board agree.
"""
