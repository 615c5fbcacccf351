"""Scenario ``drive``: one robot senses, plans, decides, drives, discovers and plans again.

Three processes share one ``Scene``. The world changes at its own times. The ``Pilot`` makes a turn of the control loop
every control period: the robot's scan goes to task ``load``, a decision (of planners that steer by a field) is asked
for at the robot's pose, and a command goes to the robot: a path, and how far it may go on it. The ``Replanner``
makes plans beside it when the pilot asks for one. Both queue for the components that they share.

The robot keeps itself safe. It may drive to the last point that is known to be free, and no farther than it could come
before it would miss an answer; without a newer command it stands there. A turn that has had no answer when its deadline
is over makes it brake at once. Where the true map still has something in its way that nobody could know of, it stands
before it, and a contact is counted; it is never inside.

Keeping the map (kernel ``occupancy_cell``, a unit a cell seen) and making a command (``way_following``) take what the
platform's processor costs them, and no time where it gives no cost. Assumed: the robot knows its pose exactly, looking
around takes no time, and clocks on board agree.
"""
