"""Writes the pages of ``docs/reference`` from the models, records, commands and docstrings that they describe.

``make docs`` runs it. ``tests/docs/test_reference.py`` makes the pages again and compares them with the committed ones.
"""
