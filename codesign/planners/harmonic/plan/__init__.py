"""Block-synchronous harmonic control (Girau, Boumaza, Scherrer and Torres-Huitzil 2008)."""

from codesign.planners.harmonic.plan.arguments import Stage, StageEnd, VisitBatch
from codesign.planners.harmonic.plan.fixed_point import Field
from codesign.planners.harmonic.plan.relax import HarmonicPlan, VisitRecord, relax, stage_cost, work

__all__ = ["Field", "HarmonicPlan", "Stage", "StageEnd", "VisitBatch", "VisitRecord", "relax", "stage_cost", "work"]
