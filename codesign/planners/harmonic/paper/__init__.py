"""Girau, Boumaza, Scherrer and Torres-Huitzil (2008), held against the model, row by row."""
