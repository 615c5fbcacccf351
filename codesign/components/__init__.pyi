from .block_ram import BlockRam, Scan, WriteMode, choose_shape
from .channel import Turns
from .component import ClockDomain, Component, Environment
from .display import VgaDisplay
from .fpga import ExternalMemory, Fpga, Granularity, PhaseUse, PreemptedError, Processor
from .link import ABANDONED, LINK_DOWN, Delivery, DeliveryOutcome, Ideal, Link, LinkErrors
from .robot import DifferentialDrive, Kinematics, MobileRobot, OmnidirectionalDrive, PointDrive
from .sensor import RadiusSensor, RaySensor
from .wired import Arbitration, Bus, Parity, Serial

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
