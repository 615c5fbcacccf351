"""Dubey, Pradhan, Krishna and Roy Chowdhury (2013), held against the model, row by row."""
