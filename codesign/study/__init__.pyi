from .cluster import ClusterExecutor
from .designs import Design, StudyPoint, explain_run
from .document import study_schema
from .executor import Executor, ProcessExecutor, SerialExecutor
from .front import non_dominated
from .outcomes import Outcomes
from .reasons import ReasonCount
from .run import explore, load_study
from .space import DesignPoint, Space
from .store import Entry, EntryState, FileStore, MemoryStore, Store
from .study import Study
from .tally import Progress

__all__ = [
    "ClusterExecutor",
    "Design",
    "DesignPoint",
    "Entry",
    "EntryState",
    "Executor",
    "FileStore",
    "MemoryStore",
    "Outcomes",
    "ProcessExecutor",
    "Progress",
    "ReasonCount",
    "SerialExecutor",
    "Space",
    "Store",
    "Study",
    "StudyPoint",
    "explain_run",
    "explore",
    "load_study",
    "non_dominated",
    "study_schema",
]
