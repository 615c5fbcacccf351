"""NSGA-II and TPE of Optuna 5 as searches. Optuna is imported when one of them is used: extra ``search``.

Every option that changes what a sampler does is named here, with its value: the defaults of several moved in the last
releases (4.9: most options of TPE deprecated; 5.0: ``constant_liar`` on, ``multivariate`` on for one objective and off
for several, no upper limit of ``gamma`` for several objectives, ``mutation`` new in NSGA-II, ``constraints_func``
deprecated for ``Trial.set_constraint``).

An axis with numbers or quantities in order is an integer, the place of its value. Any other is a category.
"""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from codesign.ground.errors import InputError
from codesign.inputs.axes import value_text
from codesign.inputs.exploration import POPULATION, STARTUP, Searching
from codesign.study.conditions import order_of
from codesign.study.constraints import Floats
from codesign.study.search import Problem, RandomSearch, Search
from codesign.study.space import Box

if TYPE_CHECKING:
    from types import ModuleType

    from optuna.samplers import BaseSampler
    from optuna.trial import Trial

    from codesign.study.space import Space

_TPE_BATCH = 10

_STEPS_BESIDE = 20
"""So many designs near a known one are looked at for a new one, before one is drawn from all."""


def nsga2(problem: Problem, searching: Searching) -> Search:
    """NSGA-II: Deb, Pratap, Agarwal and Meyarivan, IEEE Transactions on Evolutionary Computation 6(2), 2002.

    Raises:
        InputError: Optuna is not installed.
    """
    optuna = _optuna()
    population = searching.population or POPULATION
    sampler = optuna.samplers.NSGAIISampler(
        population_size=population,
        mutation=None,  # a mutated axis is drawn anew, all its values alike
        mutation_prob=None,  # 1 / axes
        crossover=optuna.samplers.nsgaii.UniformCrossover(swapping_prob=0.5),
        crossover_prob=0.9,
        swapping_prob=0.5,
        seed=searching.seed,
        constraints_func=None,  # deprecated in 5.0 for Trial.set_constraint
        elite_population_selection_strategy=None,  # constrained domination, then crowding distance
        child_generation_strategy=None,
        after_trial_strategy=None,
    )
    # A population crosses axes that all of its designs have. So each has a value of every axis; an axis that does not
    # exist for a design is a gene without effect.
    return OptunaSearch("nsga2", problem, sampler, population, searching.seed, every_axis=True)


def tpe(problem: Problem, searching: Searching) -> Search:
    """TPE: Bergstra, Bardenet, Bengio and Kégl, NIPS 2011; of several objectives Ozaki et al., GECCO 2020.

    Raises:
        InputError: Optuna is not installed.
    """
    optuna = _optuna()
    single = len(problem.objectives) == 1
    with warnings.catch_warnings():
        # ``group`` counts as experimental since 2.8.
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        sampler = optuna.samplers.TPESampler(
            n_startup_trials=searching.startup or STARTUP,
            n_ei_candidates=24,
            seed=searching.seed,
            multivariate=single,
            group=single and bool(problem.decisions.when),
            constant_liar=True,
            constraints_func=None,  # deprecated in 5.0 for Trial.set_constraint
            # Deprecated in 4.3 and 4.9, to be removed in 6.0: None is the one value that stays.
            consider_prior=None,
            prior_weight=None,
            consider_magic_clip=None,
            consider_endpoints=None,
            gamma=None,  # a tenth; at most 25 designs of one objective, without a limit of several
            weights=None,
            warn_independent_sampling=None,
        )
    return OptunaSearch("tpe", problem, sampler, _TPE_BATCH, searching.seed, every_axis=False)


class OptunaSearch:
    """A sampler of Optuna behind the interface of searches.

    A design that it suggests again is told with the others, as what came of it before. A new one near it is then given
    to the sampler as its next suggestion. So a new design takes two trials at most.

    ``batch``: how many designs are asked for before any of them is told. ``every_axis``: whether a design is given
    values of axes that do not exist for it too.
    """

    endless = True
    excluded: tuple[Box, ...] = ()

    def __init__(
        self, name: str, problem: Problem, sampler: BaseSampler, batch: int, seed: int, *, every_axis: bool
    ) -> None:
        optuna = _optuna()
        self.name, self.batch = name, batch
        self._problem, self._every_axis = problem, every_axis
        self._genes = _Genes(problem.decisions)
        directions = ["maximize" if more else "minimize" for more in problem.maximise]
        level = optuna.logging.get_verbosity()
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._study = optuna.create_study(
            storage=optuna.storages.InMemoryStorage(), sampler=sampler, directions=directions
        )
        optuna.logging.set_verbosity(level)
        self._failed = optuna.trial.TrialState.FAIL
        self._generator = random.Random(seed)
        self._random = RandomSearch(problem, seed)
        self._known: dict[int, tuple[Floats, Floats] | None] = {}
        self._trials: list[tuple[Trial, int]] = []
        self.repeated = 0

    @property
    def complete(self) -> bool:
        """True if every design was asked for."""
        return len(self._known) == len(self._problem.decisions)

    def ask(self, count: int) -> list[int]:
        """So many new designs; fewer where no others are left."""
        self._trials = []
        asked: list[int] = []
        while len(asked) < min(count, self.batch) and not self.complete:
            asked.append(self._new())
            self._known[asked[-1]] = None
        return asked

    def _new(self) -> int:
        design = self._suggested()
        if design not in self._known:
            return design
        self.repeated += 1
        for reach in range(1, _STEPS_BESIDE + 1):
            if design not in self._known:
                break
            design = self._genes.beside(design, reach, self._generator)
        while design in self._known:
            design = self._random.ask(1)[0]
        self._study.enqueue_trial(self._genes.numbers(design))
        return self._suggested()

    def _suggested(self) -> int:
        trial = self._study.ask()
        design = self._genes.design(lambda axis: self._genes.suggested(trial, axis), self._every_axis)
        self._trials.append((trial, design))
        return design

    def tell(self, designs: Sequence[int], objectives: Floats, excess: Floats) -> None:
        """Tell the sampler; what a design breaks are its constraints, by their names."""
        self._known |= zip(designs, zip(objectives, excess, strict=True), strict=True)
        for trial, design in self._trials:
            known = self._known[design]
            assert known is not None, "what was asked for is told"
            values, amounts = known
            if np.isnan(amounts).any():
                self._study.tell(trial, state=self._failed)
                continue
            for name, amount in zip(self._problem.limits, amounts.tolist(), strict=True):
                trial.set_constraint(name, amount)
            # A design that breaks a limit is ranked by how far alone: what stands for its figures is not looked at.
            self._study.tell(trial, np.where(np.isnan(values), 0.0, values).tolist())


class _Genes:
    """The axes of a space as parameters of trials; an axis with one value is none."""

    def __init__(self, space: Space) -> None:
        self._space = space
        self._ordered = {axis for axis, values in space.axes.items() if order_of(axis, values)}
        self._allowed = {
            axis: {other: set(map(value_text, values)) for other, values in conditions.items()}
            for axis, conditions in space.when.items()
        }

    def design(self, number_of: Callable[[str], int], every_axis: bool) -> int:
        """The design of the numbers of values; they are asked for axis by axis, of all axes or of those that exist."""
        chosen: dict[str, Any] = {}
        for axis, values in self._space.axes.items():
            exists = all(
                other in chosen and value_text(chosen[other]) in texts
                for other, texts in self._allowed.get(axis, {}).items()
            )
            number = number_of(axis) if exists or every_axis else 0
            if exists:
                chosen[axis] = values[number]
        return self._space.index(chosen)

    def numbers(self, design: int) -> dict[str, int]:
        """The parameters of a design, by the axes that exist for it."""
        levels = self._space.levels(np.array([design]))
        return {axis: int(level[0]) for axis, level in levels.items() if level[0] >= 0}

    def beside(self, design: int, reach: int, generator: random.Random) -> int:
        """A design with another value of one axis: up to ``reach`` places away where the values are in order."""
        numbers = self.numbers(design)
        axis = generator.choice([axis for axis in numbers if len(self._space.axes[axis]) > 1])
        number, most = numbers[axis], len(self._space.axes[axis]) - 1
        near = range(max(0, number - reach), min(most, number + reach) + 1)
        places = near if axis in self._ordered else range(most + 1)
        numbers[axis] = generator.choice([place for place in places if place != number])
        return self.design(lambda axis: numbers.get(axis, 0), every_axis=False)

    def suggested(self, trial: Trial, axis: str) -> int:
        """The number of the value of an axis that is suggested for a trial."""
        count = len(self._space.axes[axis])
        if count == 1:
            return 0
        if axis in self._ordered:
            return trial.suggest_int(axis, 0, count - 1)
        return trial.suggest_categorical(axis, range(count))


def _optuna() -> ModuleType:
    """Optuna, imported.

    Raises:
        InputError: it is not installed, or is of another version.
    """
    hint = "pip install 'hwsw-codesign[search]'; random and bound need nothing more"
    try:
        import optuna
    except ImportError as missing:
        raise InputError("Optuna is not installed", "search", hint) from missing
    if int(optuna.__version__.split(".")[0]) != 5:
        raise InputError(f"Optuna {optuna.__version__} is not Optuna 5", "search", hint)
    return optuna
