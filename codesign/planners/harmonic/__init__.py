"""Block-synchronous harmonic control, the planner of Girau, Boumaza, Scherrer and Torres-Huitzil (2008)."""
