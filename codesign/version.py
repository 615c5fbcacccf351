"""The version of the package, which results, traces and files of the package name."""

__version__ = "0.1.0"
