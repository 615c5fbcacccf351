"""Möller and Paschke (1998), held against the model, row by row."""
