"""The topics of a bag that are read: named, or chosen by type and namespace.

The rule, for what is not named:

1. A *namespace* holds a topic with the usual name and type of odometry, a command, a goal or a plan. The robot's one
   is the one that is asked for, or else the outermost. Namespaces beside each other are two robots, and refused.
2. A namespace inside of the robot's that has a usual topic of the robot's once more is another robot's.
3. A topic of the robot lies in its namespace at any depth, or directly in a namespace around it (where one was asked
   for: only the map and the transforms), and not in another robot's namespace. It has a type of its role; a goal has
   ``goal`` in its name, and no plan or map is local or a costmap.
4. The usual name comes first, the nearest to the robot's namespace; then a topic that ends with it; then any other.
   Several that are alike are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import itemgetter

from more_itertools import map_reduce

from codesign.ground.errors import InputError, nearest, printable
from codesign.views.bags import library

NOTHING = "none"
"""The name that leaves a topic out."""


@dataclass(frozen=True)
class Role:
    """The role of a topic: its usual name, its types, words that its name needs, words that it must not have."""

    usual: str
    types: tuple[str, ...]
    needs: str = ""
    never: tuple[str, ...] = ()

    def fits(self, topic: str, kind: str) -> bool:
        """True if a topic may have the role."""
        last = topic.rsplit("/", 1)[-1]
        return kind in self.types and self.needs in last and not any(word in topic for word in self.never)


ROLES = {
    "map": Role("map", (library.OCCUPANCY_GRID,), "", ("costmap", "local_")),
    "tf": Role("tf", (library.TF_MESSAGE,)),
    "tf_static": Role("tf_static", (library.TF_MESSAGE,), "tf_static"),
    "scan": Role("scan", (library.LASER_SCAN,)),
    "odom": Role("odom", (library.ODOMETRY,)),
    "goal": Role("goal_pose", (library.POSE_STAMPED,), "goal"),
    "plan": Role("plan", (library.PATH,), "", ("local_",)),
    "command": Role("cmd_vel", (library.TWIST, library.TWIST_STAMPED)),
}
_SHARED = ("map", "tf", "tf_static")
_TELLING = ("odom", "command", "goal", "plan")


@dataclass(frozen=True)
class Topics:
    """The names of the topics that are read; None: chosen, ``none``: not read.

    ``base``: the frame of the robot; None: the one that the odometry names. ``namespace``: the robot's; None:
    found.
    """

    map: str | None = None
    tf: str | None = None
    tf_static: str | None = None
    scan: str | None = None
    odom: str | None = None
    goal: str | None = None
    plan: str | None = None
    command: str | None = None
    base: str | None = None
    namespace: str | None = None


@dataclass(frozen=True)
class Chosen:
    """The topics of a bag, by role: ``names`` of all that are read, the usual name of one that the bag has not.

    ``unread``: topics that fit a role and are not read.
    """

    names: Mapping[str, str]
    unread: tuple[str, ...]
    namespace: str

    def __getitem__(self, role: str) -> str:
        return self.names[role]


def choose_topics(wanted: Topics, present: Mapping[str, str], where: str) -> Chosen:
    """The topics that are read. ``present``: the type of each topic with a message.

    Raises:
        InputError: a named topic or namespace is not there, a type is wrong, or several topics fit alike.
    """
    wanted = replace(wanted, **{role: _named(wanted, role, present, where) for role in ROLES})
    space, others = _robot(wanted, present, where)
    names, unread = {}, []
    for role, rule in ROLES.items():
        named = getattr(wanted, role)
        fitting = [topic for topic, kind in present.items() if rule.fits(topic, kind)]
        if role == "tf":
            fitting = [topic for topic in fitting if not ROLES["tf_static"].fits(topic, present[topic])]
        around = role in _SHARED or wanted.namespace is None
        own = [topic for topic in fitting if _belongs(topic, space, others, around)]
        names[role] = named or _best(role, own, space, where) or f"{space}/{rule.usual}"
        if role not in (*_SHARED, "plan"):
            unread += [topic for topic in fitting if topic != names[role]]
        kind = present.get(names[role])
        if kind is not None and kind not in rule.types:
            what = f"topic {printable(names[role])} has messages of {printable(kind)}"
            raise InputError(what, where, f"accepted: {' or '.join(rule.types)}; name another topic")
    return Chosen(names, tuple(sorted(set(unread) - set(names.values()))), space)


def _named(wanted: Topics, role: str, present: Mapping[str, str], where: str) -> str | None:
    name: str | None = getattr(wanted, role)
    if name is None or name in present:
        return name
    if name == NOTHING:
        return f"/{ROLES[role].usual} (left out)"
    near = nearest(name, present)
    hint = f"did you mean {printable(near)}?" if near else f"topics: {_listed(present)}"
    if role != "map":
        hint += f"; {option_of(role)} {NOTHING} leaves it out"
    raise InputError(f"has no topic {printable(name)}", where, hint)


def _robot(wanted: Topics, present: Mapping[str, str], where: str) -> tuple[str, list[str]]:
    """The namespace of the robot, and the namespaces of other robots."""
    telling: list[tuple[str, str]] = []
    for role in _TELLING:
        for topic, kind in present.items():
            space, last = topic.rsplit("/", 1) if "/" in topic else ("", topic)
            if last == ROLES[role].usual and kind in ROLES[role].types:
                telling.append((space, role))
    spaces = map_reduce(telling, itemgetter(0), itemgetter(1), set)
    if wanted.namespace is not None:
        robot = "/" + wanted.namespace.strip("/")
        robot = "" if robot == "/" else robot
        if not any(topic.startswith(f"{robot}/") for topic in present):
            found = ", ".join(printable(space) or "/" for space in sorted(spaces)[:12]) or "none"
            what = f"has no topic in the namespace {printable(robot)}"
            raise InputError(what, where, f"namespaces of robots: {found}")
    else:
        open_roles = {role for role in _TELLING if getattr(wanted, role) is None}
        asked = [space for space, roles in spaces.items() if roles & open_roles]
        robot = min(asked, key=lambda space: space.count("/") if space else -1, default="")
        beside = [space for space in asked if not _inside(space, robot)]
        if beside:
            listed = ", ".join(printable(space) for space in sorted([robot, *beside])[:12])
            what = f"has topics of several robots: {listed}"
            raise InputError(what, where, f"name one: --namespace {printable(robot)}")
    own = spaces.get(robot, set())
    return robot, [
        space
        for space, roles in spaces.items()
        if space != robot and (roles & own or not _inside(space, robot)) and not _inside(robot, space)
    ]


def _inside(space: str, outer: str) -> bool:
    return f"{space}/".startswith(f"{outer}/")


def _belongs(topic: str, space: str, others: list[str], around: bool) -> bool:
    parent = topic.rsplit("/", 1)[0] if "/" in topic else ""
    if any(_inside(parent, other) for other in others):
        return False
    return _inside(parent, space) or (around and _inside(space, parent))


def _best(role: str, topics: list[str], space: str, where: str) -> str | None:
    """The topic that comes first, or None without any.

    Raises:
        InputError: several come first.
    """
    usual = ROLES[role].usual

    def rank(topic: str) -> tuple[int, int]:
        parent, last = topic.rsplit("/", 1) if "/" in topic else ("", topic)
        if last == usual and _inside(space, parent):
            return 0, len(space) - len(parent)
        return (1 if last == usual else 2), 0

    first = min(map(rank, topics), default=None)
    alike = sorted(topic for topic in topics if rank(topic) == first)
    if len(alike) > 1:
        what = f"has {len(alike)} topics that may be read as {usual}: {_listed(alike)}"
        raise InputError(what, where, f"name one: {option_of(role)} {printable(alike[0])}")
    return alike[0] if alike else None


def option_of(role: str) -> str:
    """The option that names the topic of a role.

    >>> option_of("tf_static")
    '--tf-static-topic'
    """
    return f"--{role.replace('_', '-')}-topic"


def _listed(topics: Mapping[str, str] | list[str]) -> str:
    return ", ".join(printable(topic) for topic in sorted(topics)[:12])
