from .arbiter import Turns
from .block_ram import BlockRam, WriteMode, choose_shape
from .bus import Arbitration, Bus
from .component import ClockDomain, Component, Environment
from .delivery import ABANDONED, LINK_DOWN, Delivery, DeliveryOutcome
from .display import VgaDisplay
from .fpga import Fpga, Granularity, PhaseUse, PreemptedError
from .link import Ideal, Link
from .link_faults import LinkErrors
from .memory import ExternalMemory
from .motion import DifferentialDrive, Kinematics, OmnidirectionalDrive, PointDrive
from .processor import Processor
from .robot import MobileRobot
from .scan import Scan
from .sensor import RadiusSensor, RaySensor
from .serial import Parity, Serial

__all__ = [
    "ABANDONED",
    "LINK_DOWN",
    "Arbitration",
    "BlockRam",
    "Bus",
    "ClockDomain",
    "Component",
    "Delivery",
    "DeliveryOutcome",
    "DifferentialDrive",
    "Environment",
    "ExternalMemory",
    "Fpga",
    "Granularity",
    "Ideal",
    "Kinematics",
    "Link",
    "LinkErrors",
    "MobileRobot",
    "OmnidirectionalDrive",
    "Parity",
    "PhaseUse",
    "PointDrive",
    "PreemptedError",
    "Processor",
    "RadiusSensor",
    "RaySensor",
    "Scan",
    "Serial",
    "Turns",
    "VgaDisplay",
    "WriteMode",
    "choose_shape",
]
