"""Girau, Boumaza, Scherrer and Torres-Huitzil (2008) beside the model, row by row."""
