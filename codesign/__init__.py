"""Hardware/software co-design of robot path planners."""

__version__ = "0.1.0"
