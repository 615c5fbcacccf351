"""ROS 2 bags: a run written as one, and a workload made of one.

The library rosbags reads and writes them, and is imported when it is used (``pip install 'hwsw-codesign[ros2]'``). No
ROS is needed. Bags have the MCAP storage of rosbag2; those with SQLite are read too.
"""

from codesign.bags.drawing import BagFacts, Choices, facts_of
from codesign.bags.export import BAG_KINDS, BagListener, export_bag
from codesign.bags.folder import check_new
from codesign.bags.obstacles import Rule
from codesign.bags.reading import read_bag
from codesign.bags.texts import file_name, goals_csv, latency, map_files, settings_of, workload_text
from codesign.bags.topics import Topics

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
