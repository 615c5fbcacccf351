"""Architecture styles: how a planner is laid out on a component, and the laws of what that costs.

A law is a small pure function with its source. Styles are found through the entry-point group
``codesign.architectures``; each entry point is a sequence of objects that satisfy
:class:`codesign.architectures.interface.Architecture`.
"""
