"""Hardware/software co-design of robot path planners: the notebook face.

>>> import codesign
>>> result = codesign.simulate("virtex2-pci", "labyrinth")
>>> result.feasible
True

``simulate`` gives one result, ``explore`` a study with its front, and ``open_trace(file)`` looks into a run. A platform
or a workload is given as a shipped name, a file, YAML text, a dict, or loaded (``load_platform``, ``load_workload``).
Heavy modules load when a function needs them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

import lazy_loader

from codesign.ground.kernel_cache import provide_kernel_cache
from codesign.ground.notebooks import show_with
from codesign.version import __version__ as __version__

if TYPE_CHECKING:
    from codesign.face import explain, explore, load_platform, load_workload, open_trace, simulate

__all__ = ["explain", "explore", "load_platform", "load_workload", "open_trace", "simulate"]
__getattr__, __dir__, _ = lazy_loader.attach(__name__, submod_attrs={"face": __all__})

provide_kernel_cache()
show_with(lambda shown: str(import_module("codesign.views.report.notebooks").notebook_html(shown)))
