"""The ten changes that newcomers make most, each as a toy in the files that its row of the page names and in no other.

All toys stand in one copy of the tree: they do not know of each other. What each is asked afterwards is what a user of
the tree would ask.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import pytest
from places import ROOT
from recipes import Recipe

Edits = Mapping[str, tuple[tuple[str, str], ...]]
"""File → (mark, text) pairs: the text goes in front of the mark."""


@dataclass(frozen=True)
class Toy:
    """A row of the page, what is put into its files, and a script with what it prints."""

    row: str
    script: str
    printed: str
    edits: Edits = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)


def shipped(path: str, name: str, new: str) -> str:
    """A shipped file under another name."""
    return (ROOT / path).read_text(encoding="utf-8").replace(f"name: {name}\n", f"name: {new}\n")


PART = """kind: part
name: TOY-1
family: GW1N
description: A toy
resources:
  slices: {value: 4320, status: assumed, source: "a toy"}
  lut4: {value: 8640, status: assumed, source: "a toy"}
  flip_flops: {value: 6480, status: assumed, source: "a toy"}
  block_rams: {value: 26, status: assumed, source: "a toy"}
  multipliers: {value: 20, status: assumed, source: "a toy"}
block_ram:
  shapes: [[2048, 9], [1024, 18]]
power:
  static: {value: 0.01 W, status: assumed, source: "a toy"}
  dynamic: {value: 0.125 uW, status: assumed, source: "a toy"}
speed_grades:
  "-5":
    block_ram_clock: {value: 150 MHz, status: assumed, source: "a toy"}
"""

HOST = """kind: host
name: toy-host
description: A toy
clock: {value: 1 GHz, status: assumed, source: "a toy"}
costs_of:
  host: cortex-a53
  factor: {value: 2, status: assumed, source: "a toy"}
power:
  busy: {value: 2 W, status: assumed, source: "a toy"}
  idle: {value: 1 W, status: assumed, source: "a toy"}
"""

READER = '''
def parse_runs(content: bytes, where: str) -> OccupancyGrid:
    """A map of run lengths, free cells first: ``RUNS 2 1`` is one row of two free cells and an obstacle."""
    free: list[bool] = []
    for place, length in enumerate(content.split()[1:]):
        free += [place % 2 == 0] * int(length)
    return OccupancyGrid(np.array([free]), source=where)
'''

SEARCH = '''

class Backwards(RandomSearch):
    """All designs, the last one first."""

    name = "backwards"

    def __init__(self, problem: Problem, seed: int) -> None:
        super().__init__(problem, seed)
        self._order = [*range(self._size - 1, -1, -1)]
'''

GENERATOR = '''def stripes(rows: int, columns: int) -> OccupancyGrid:
    """Every third column an obstacle, but for its first cell."""
    rows, columns = _size(rows, columns)
    free = np.ones((rows, columns), dtype=np.bool_)
    free[1:, 2::3] = False
    return OccupancyGrid(free, source=f"stripes({rows=}, {columns=})")


'''

GENERATOR_MODEL = '''class StripesMap(_Sized):
    """Stripes."""

    generate: Literal["stripes"] = Field(description="Stripes.")


'''

STEP_KEY = """    mirrored: bool = Field(default=False, description="Turns the map's columns around.")
"""

ENTRY_OF_REPORTS = """TOY = Tool(
    "Toy",
    marks=("^TOY SLICES",),
    head=lambda _text: {"version": "1"},
    kinds=(Kind("", lambda text: counted(text, rows(text, r"TOY (SLICES) (\\d+)"), {"slices": ({"SLICES": 1.0},)})),),
)

"""

REQUEST = '''class Greet(Request):
    """Greet NAME."""

    name: str = argument()
    loud: bool = option("Say it loudly.")


'''

GREETING = '''"""Command greet."""

from __future__ import annotations

import click

from codesign.cli.requests import Greet


def greet(asked: Greet) -> None:
    """Greet somebody."""
    click.echo(f"hello {asked.name}{'!' if asked.loud else ''}")
'''

FAN = '''class Fan(Component):
    """A fan that blows all the time."""

    turns = 1200


'''

FAN_MAKER = """def _fan(environment: Any, name: str, _spec: Any, _by_name: Any, listeners: Any) -> components.Component:
    from codesign.components.component import Fan

    return Fan(environment, name, listeners)


"""

FAN_MODEL = '''class FanComponent(AnyComponent):
    """A fan."""

    type: Literal["fan"] = Field(description="A fan.")
    blades: int = Field(description="a toy")


'''

TOYS = [
    Toy(
        "a part",
        "from codesign.inputs import load_part; print(load_part('TOY-1-5').resources['slices'].value)",
        "4320",
        files={"platforms/parts/TOY-1.yaml": PART},
    ),
    Toy(
        "a host",
        "from codesign.inputs.files import shipped_files\n"
        "from codesign.inputs import load_platform\n"
        "print(sum('toy-host' in str(file) for file in shipped_files()))",
        "1",
        files={"platforms/hosts/toy-host.yaml": HOST},
    ),
    Toy(
        "a unit",
        "from codesign.ground.units import Dimension, parse_quantity; print(parse_quantity('2 d', Dimension.TIME))",
        str(2 * 24 * 3600 * 10**12),
        edits={"ground/units.py": ((" h 3600e12", " d 86400e12"),)},
    ),
    Toy(
        "a map format",
        "import pathlib; from codesign.maps import read_map\n"
        "pathlib.Path('toy.runs').write_bytes(b'RUNS 2 1 1')\n"
        "print(read_map('toy.runs').free.tolist())",
        "[[True, True, False, True]]",
        edits={
            "maps/images.py": (("", READER),),
            "maps/prepare.py": (
                ("parse_image, read_ros", "parse_runs, "),
                (
                    "    if is_image(content) or",
                    '    if content.startswith(b"RUNS "):\n        return parse_runs(content, where)\n',
                ),
            ),
        },
    ),
    Toy(
        "a generator of maps",
        "map = {'generate': 'stripes', 'rows': 4, 'columns': 6}\n"
        "problem = {'map': map, 'goals': [[0, 5]], 'starts': [[3, 0]]}\n"
        "from codesign.inputs.problem import ProblemSpec\n"
        "print(type(ProblemSpec.model_validate(problem).map).__name__)\n"
        "from codesign.maps import generate\n"
        "print(generate('stripes', rows=2, columns=3).free.tolist())",
        "StripesMap\n[[True, True, True], [True, True, False]]",
        edits={
            "maps/generate.py": (("GENERATORS: Mapping", GENERATOR), ('"empty": empty}', '"stripes": stripes, ')),
            "inputs/map_spec.py": (
                ("MAPS: dict[str", GENERATOR_MODEL),
                ('    "empty": EmptyMap,\n', '    "stripes": StripesMap,\n'),
                (" | EmptyMap, WrapValidator(_choose_map)", " | StripesMap"),
            ),
        },
    ),
    Toy(
        "a step of maps, such as cropping",
        "from codesign.inputs.map_spec import EmptyMap, FileMap\n"
        "import numpy as np; from codesign.maps import OccupancyGrid; from codesign.maps.prepare import prepare\n"
        "spec = EmptyMap(generate='empty', rows=2, columns=2, mirrored=True)\n"
        "print(prepare(OccupancyGrid(np.array([[True, False]])), spec.steps).free.tolist())",
        "[[False, True]]",
        edits={
            "maps/prepare.py": (
                ("\n\ndef read_prepared(", "    mirrored: bool = False\n"),
                (
                    "    if steps.inflate is not None:\n",
                    "    if steps.mirrored:\n        grid = replace(grid, free=grid.free[:, ::-1])\n",
                ),
            ),
            "inputs/map_spec.py": (
                ("    resolution: Length | None = Field(", STEP_KEY),
                ("inflate=self.inflate, downsample", "mirrored=self.mirrored, "),
            ),
        },
    ),
    Toy(
        "an objective or a constraint",
        "import codesign\n"
        "result = codesign.simulate('virtex4-pci', 'labyrinth')\n"
        "print(result.figure('pins'))\n"
        "from codesign.inputs.exploration import Exploration\n"
        "explore = {'axes': {'fpga.clock': ['100 MHz', '120 MHz']}, 'objectives': ['pins'],"
        " 'constraints': [{'figure': 'pins', 'at_most': 2}]}\n"
        "workload = codesign.load_workload('labyrinth').model_copy(update={'explore': Exploration(**explore)})\n"
        "study = codesign.explore('virtex4-pci', workload, workers=1)\n"
        "print(study.points[0].feasible, study.points[0].result.figure('pins'))",
        "3.0\nFalse 3.0",
        edits={
            "ground/figures.py": (
                (
                    '        _count("local_maxima"',
                    '        ResultFigure("pins", "", "a toy", value=lambda result: 3.0),\n',
                ),
            )
        },
    ),
    Toy(
        "a figure in a result",
        "import codesign\n"
        "result = codesign.simulate('virtex4-pci', 'labyrinth')\n"
        "from codesign.views.report import result_tables\n"
        "print(result.time.holiday_s, 'public holidays' in str([table.rows for table in result_tables(result)]))",
        "4.0 True",
        edits={
            "system/results/result.py": (
                (
                    "    first_plan_s: float",
                    '    holiday_s: float = Field(title="public holidays", description="a toy")\n',
                ),
            ),
            "system/outcome.py": (("        first_plan_s=answer.answered", "        holiday_s=4.0,\n"),),
        },
    ),
    Toy(
        "a figure of a plan's quality",
        "import codesign\n"
        "result = codesign.simulate('virtex4-pci', 'labyrinth')\n"
        "from codesign.views.report import result_tables\n"
        "print(result.quality.bends, 'bends of paths' in str([table.rows for table in result_tables(result)]))",
        "5 True",
        edits={
            "planners/interface.py": (
                (
                    "    optimal_length_mean: Annotated[",
                    '    bends: Annotated[int | None, Field(title="bends of paths", description="a toy")] = None\n',
                ),
            ),
            "planners/harmonic/plan/planner.py": (("        local_maxima=int(", "        bends=5,\n"),),
        },
    ),
    Toy(
        "a column in the report",
        "import codesign\n"
        "from codesign.inputs.exploration import Exploration\n"
        "from codesign.views.report import study_table\n"
        "explore = Exploration(axes={'fpga.clock': ['100 MHz', '120 MHz']}, objectives=['studs'])\n"
        "workload = codesign.load_workload('labyrinth').model_copy(update={'explore': explore})\n"
        "table = study_table(codesign.explore('virtex4-pci', workload, workers=1))\n"
        "print([column.name for column in table.columns if 'stud' in column.name], len(table.rows))",
        "['stud count'] 2",
        edits={
            "ground/figures.py": (
                (
                    '        _count("wrong_cells"',
                    '        ResultFigure("studs", "", "a toy", "stud count", value=lambda result: 1.0),\n',
                ),
            )
        },
    ),
    Toy(
        "an architecture style",
        "import codesign\n"
        "workload = codesign.load_workload('breadth-first-java')\n"
        "mapping = {'search': workload.mapping['search'].model_copy(update={'style': 'software_toy'})}\n"
        "workload = workload.model_copy(update={'mapping': mapping})\n"
        "result = codesign.simulate('pentium4-java', workload)\n"
        "print(result.style, result.feasible)",
        "software_toy True",
        edits={
            "planners/breadth_first/styles/__init__.py": (
                (
                    '    Software("software", CELL_KERNEL),',
                    '    Software("software_toy", "breadth_first_java_cell"),\n',
                ),
            )
        },
    ),
    Toy(
        "a kernel that a host is timed by",
        "from codesign.hardware.calibrate.host_costs import all_probes; print('toy_cell' in all_probes())",
        "True",
        edits={"planners/breadth_first/styles/software.py": (("CELL_KERNEL: _", '"toy_cell": _breadth_first, '),)},
    ),
    Toy(
        "a rule over conditions",
        "import numpy as np; from codesign.inputs.aggregate import WORDS\n"
        "from codesign.study.aggregation import aggregated\n"
        "print('widest' in WORDS, aggregated('widest', np.array([3.0, 1.0, 9.0]), False))",
        "True 8.0",
        edits={
            "inputs/aggregate.py": (
                ('"median")\n\n\nclass Quantile', '"widest", '),
                ('"median"]\nRule =', '"widest", '),
            ),
            "study/aggregation.py": (
                (
                    '    if rule == "median":',
                    '    if rule == "widest":\n        return np.asarray(values.max(axis=-1) - values.min(axis=-1))\n',
                ),
            ),
        },
    ),
    Toy(
        "a report of another tool",
        "import pathlib; from codesign.hardware.calibrate.reports import read_report\n"
        "pathlib.Path('toy.rpt').write_text('TOY SLICES 12')\n"
        "report = read_report(pathlib.Path('toy.rpt')); print(report.tool, report.used['slices'].value)",
        "Toy 12.0",
        edits={
            "hardware/calibrate/reports/__init__.py": (("VIVADO\n", "TOY, "), ("VIVADO, ISE, QUARTUS", "TOY, ")),
            "hardware/calibrate/reports/tools.py": (("# --- Quartus:", ENTRY_OF_REPORTS),),
        },
    ),
    Toy(
        "a part that is placed",
        "from codesign.hardware.rtl.place import DEVICES; print(DEVICES['LFE5U-45F'].options)",
        "45k",
        edits={"hardware/rtl/place.py": (('    "LFE5U-85F": _ecp5(', '    "LFE5U-45F": _ecp5("45k", "CABGA381"),\n'),)},
    ),
    Toy(
        "a CLI command",
        "from click.testing import CliRunner; from codesign.cli import main as hwsw\n"
        "print(CliRunner().invoke(hwsw, ['greet', 'Ada', '--loud']).output)\n"
        "print(CliRunner().invoke(hwsw, ['--help']).output)",
        "hello Ada!",
        edits={
            "cli/requests.py": (
                ("COMMANDS = {", REQUEST),
                ('    "map": Command(Map', '    "greet": Command(Greet, "greet:greet", "Greet somebody."),\n'),
            )
        },
        files={"cli/greet.py": GREETING},
    ),
    Toy(
        "a platform, a workload",
        "import codesign; result = codesign.simulate('toy-board', 'toy-job')\n"
        "print(result.platform, result.workload, result.feasible)",
        "toy-board toy-job True",
        files={
            "platforms/toy-board.yaml": shipped("platforms/virtex2pro.yaml", "virtex2pro", "toy-board"),
            "workloads/toy-job.yaml": shipped("workloads/breadth-first.yaml", "breadth-first", "toy-job"),
        },
    ),
    Toy(
        "a law for a clock",
        "import codesign; result = codesign.simulate('nexys2', 'robots-2')\n"
        "print(result.clock.limit.value, result.feasible)",
        "10000000 False",
        edits={
            "planners/velocity_obstacle/styles/timing.py": (
                ("    limit = Figure(\n        value=min(CLOCK, ram)", "    ram = 10_000_000\n"),
            )
        },
    ),
    Toy(
        "a figure of a mission",
        "import sys; from codesign.cli import main\n"
        "limit = ('--set', 'workload.scenario.limit=15 s', '--no-levers', '-v')\n"
        "sys.argv = ['hwsw', 'run', 'arty-a7', 'office-breadth-first', *limit]\n"
        "main()",
        "songs sung",
        edits={
            "system/results/mission.py": (
                ("    contacts: int", '    songs: int = Field(default=0, title="songs sung", description="a toy")\n'),
            ),
            "system/scenarios/drive/scenario.py": (("        turns=log.turns,", "        songs=7,\n"),),
        },
    ),
    Toy(
        "a kind of component",
        "import yaml, pathlib, codesign\n"
        "board = yaml.safe_load(pathlib.Path('platforms/virtex4-pci.yaml').read_text())\n"
        "board['components']['fan'] = {'type': 'fan', 'blades': 3}\n"
        "print(codesign.simulate(board, 'labyrinth').utilisation['fan'])",
        "0.0",
        edits={
            "components/component.py": (("", FAN),),
            "tests/kinds/test_components.py": (('"robot": "tests/system', '"fan": "this toy", '),),
            "inputs/components.py": (("COMPONENTS: dict[str, type", FAN_MODEL),),
            "system/assemble.py": (
                ("_BUILD: Mapping[type", FAN_MAKER),
                ("    ProcessorComponent: _processor,\n}", "    FanComponent: _fan,\n"),
                ("    FpgaComponent,\n    MemoryComponent,", "    FanComponent,\n"),
            ),
        },
    ),
    Toy(
        "a tool of hardware",
        "from codesign.hardware.rtl.tools import TOOLS, MissingToolError, command_of\n"
        "print(command_of('toysim'), MissingToolError('toysim').hint)",
        "None install it: apt-get install toysim",
        edits={
            "hardware/rtl/tools.py": (
                (
                    '    "iverilog": Tool(',
                    '    "toysim": Tool(programs=("toysim",), install="apt-get install toysim"),\n',
                ),
            )
        },
    ),
    Toy(
        "a key of a platform",
        "from codesign.inputs.components import FpgaComponent\n"
        "print(FpgaComponent.model_fields['colour'].description)\n"
        "from codesign.inputs import json_schema; print('colour' in str(json_schema('platform')))",
        "a toy\nTrue",
        edits={
            "inputs/components.py": (
                (
                    "    calibration: Name | None = Field(",
                    '    colour: str = Field(default="green", description="a toy")\n',
                ),
            )
        },
    ),
    Toy(
        "a key of a workload",
        "from codesign.inputs.problem import ProblemSpec; print(ProblemSpec.model_fields['weather'].default)",
        "sunny",
        edits={
            "inputs/problem.py": (
                ("    task: Task = Field(", '    weather: str = Field(default="sunny", description="a toy")\n'),
            )
        },
    ),
    Toy(
        "a parameter of a planner",
        "import codesign; platform, workload = 'virtex2pro', codesign.load_workload('breadth-first')\n"
        "print(codesign.simulate(platform, workload).parameters)",
        "toy_bits",
        edits={
            "planners/breadth_first/plan/parameters.py": (
                (
                    "    external_cycles: int = Field(",
                    '    toy_bits: int = Field(default=7, ge=1, description="a toy")\n',
                ),
            )
        },
    ),
    Toy(
        "a search of a space",
        "import codesign; from codesign.study.budget import Budget\n"
        "study = codesign.explore('virtex4-pci', 'labyrinth', search='backwards', budget=Budget(points=2))\n"
        "print(study.search.traces[0].designs)",
        "[3527, 3526]",
        edits={
            "study/search.py": (("", SEARCH),),
            "study/search_run.py": (
                ("from codesign.study.search import", "from codesign.study.search import Backwards\n"),
                (
                    '    "bound": lambda',
                    '    "backwards": lambda problem, searching: Backwards(problem, searching.seed),\n',
                ),
            ),
            "inputs/exploration.py": (('"bound"]', '"backwards", '),),
        },
    ),
]


@pytest.fixture(scope="module")
def trees(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Toy], Recipe]:
    """The one tree with all toys in it, as the recipe of any of them."""
    folder = tmp_path_factory.mktemp("tree")
    made = {}
    for toy in TOYS:
        made[toy.row] = recipe = Recipe(folder, toy.row)
        for name, changes in toy.edits.items():
            recipe.edit(name, *changes)
        for name, text in toy.files.items():
            recipe.write(name, text)
    return lambda toy: made[toy.row]


@pytest.mark.parametrize("toy", TOYS, ids=lambda toy: toy.row)
def test_a_toy_finds_its_places(toy: Toy) -> None:
    """Else a toy that ``make test`` does not run would break in silence."""
    for name, changes in toy.edits.items():
        path = next(path for path in (ROOT / name, ROOT / "codesign" / name) if path.exists())
        text = path.read_text(encoding="utf-8")
        assert [mark for mark, _ in changes if mark and text.count(mark) != 1] == []


@pytest.mark.slow
@pytest.mark.parametrize("toy", TOYS, ids=lambda toy: toy.row)
def test_a_toy_of_a_row_works_in_the_files_of_the_row(toy: Toy, trees: Callable[[Toy], Recipe]) -> None:
    assert toy.printed in trees(toy).python("-c", toy.script)
