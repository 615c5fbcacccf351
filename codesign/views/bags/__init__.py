"""ROS 2 bags: a run written as one, and a workload made of one.

The library rosbags reads and writes them, and is imported when it is used (``pip install 'hwsw-codesign[ros2]'``). No
ROS is needed. Bags have the MCAP storage of rosbag2; those with SQLite are read too.
"""

from codesign.views.bags.drawing import (
    BagFacts,
    Choices,
    facts_of,
    file_name,
    goals_csv,
    latency,
    map_files,
    settings_of,
    workload_text,
)
from codesign.views.bags.export import BAG_KINDS, BagListener, check_new, export_bag
from codesign.views.bags.obstacles import Rule
from codesign.views.bags.reading import Topics, read_bag

__all__ = [
    "BAG_KINDS",
    "BagFacts",
    "BagListener",
    "Choices",
    "Rule",
    "Topics",
    "check_new",
    "export_bag",
    "facts_of",
    "file_name",
    "goals_csv",
    "latency",
    "map_files",
    "read_bag",
    "settings_of",
    "workload_text",
]
