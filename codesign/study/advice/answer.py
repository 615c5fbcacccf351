"""The answer: what each board comes to, which suffices at the least cost, and why the cheaper ones do not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

from more_itertools import map_reduce
from pydantic import Field

from codesign.ground.units import counted
from codesign.study.advice.candidates import Board, Candidate
from codesign.study.advice.certainty import (
    Certainty,
    Judged,
    input_power,
    may_suffice,
    mean_power,
    number_text,
    shortfalls_of,
)
from codesign.study.advice.motion import Driven, Motion
from codesign.study.advice.needs import Goal, Needs, Where
from codesign.study.advice.search import COUNTS, Extent, Findings, Tried, order
from codesign.study.advice.trials import Shortfall, Trial
from codesign.system import catalog
from codesign.system.results.model import ResultModel


class Design(ResultModel):
    """A design on a board, and what it comes to."""

    planner: str = Field(description="name of the planner")
    style: str = Field(description="architecture style of the planning task")
    placement: Where = Field(
        description="fabric: all on the FPGA; host: all on a processor; split: a task is on another component"
    )
    mapping: dict[str, dict[str, Any]] = Field(description="the mapping of its workload")
    settings: dict[str, str] = Field(description="axes of the platform that are set, such as fpga.clock")
    trial: Trial = Field(description="what it comes to")
    rate_hz: float | None = Field(description="plans a second: 1 / the time of a plan; None where it was not run")
    mean_power_w: float | None = Field(
        description="mean power of the components of the board at the rate that is asked for, W"
    )
    input_power_w: float | None = Field(
        description="mean power at the input of the whole board at that rate, W; None where it declares none"
    )
    binds: str = Field(description="the limit that is nearest, or the one that is passed by most")
    binds_share: float | None = Field(description="the share of that limit; None where there is no number")


class BoardAdvice(ResultModel):
    """A board with its best design: the simplest that suffices, or else the one that is nearest to it."""

    board: str = Field(description="name of the platform")
    price_usd: float | None = Field(description="its price, USD; None where the platform declares none")
    price_low_usd: float | None = Field(description="the least price inside its interval, USD; None where it has none")
    price_high_usd: float | None = Field(description="the greatest, USD")
    idle_w: float = Field(description="power of its components while no plan is computed, W")
    suffices: bool = Field(description="whether a design on it meets every need")
    design: Design | None = Field(description="its best design; None where no planner has a style for it")
    fastest: Design | None = Field(
        description="its fastest design whose plans serve, whatever the other needs; None where none serves"
    )
    margin: float | None = Field(description="rate over the rate that is asked for; None where it was not run")
    shortfalls: tuple[Shortfall, ...] = Field(description="the needs that its best design does not meet")
    perhaps: str = Field(
        description="of a board that does not suffice: why a design on it may, inside the intervals; empty: none does"
    )
    searched: Extent = Field(description="its designs, by what became of them")
    under: str | None = Field(
        default=None,
        description="the computer beside it, where its best design leaves its chip without work: the two are one row",
    )
    workload: str | None = Field(default=None, description="the file of its best design, where it was written")
    command: str | None = Field(default=None, description="the command that runs its best design, where it was written")
    circuit: Design | None = Field(
        default=None,
        description="with --write, its best circuit that was found: it fits and its plans serve, whatever the needs",
    )
    circuit_shortfalls: tuple[Shortfall, ...] = Field(
        default=(), description="the needs that this circuit does not meet"
    )
    circuit_workload: str | None = Field(
        default=None, description="the file of this circuit; that of the best design where it is the circuit"
    )
    circuit_command: str | None = Field(default=None, description="the command that runs this circuit")
    rtl_command: str | None = Field(default=None, description="the command that writes this circuit as Verilog")
    no_rtl: str = Field(default="", description="why hwsw rtl refuses this circuit; empty: it does not")
    mission_platform: str | None = Field(default=None, description="the file of the board with a robot, for a mission")
    mission_workload: str | None = Field(
        default=None, description="the file of its best design in a mission from the first start"
    )
    mission_command: str | None = Field(default=None, description="the command that simulates the mission")
    no_mission: str = Field(default="", description="why no mission was written; empty: one was, or none was asked for")


class Proof(ResultModel):
    """What the statement rests on that no cheaper board suffices, or where none suffices, that none does."""

    state: Literal["proved", "at own values", "not proved"] = Field(
        description="proved: every design of them fails at every value inside the intervals; at own values: each fails"
        " at the figures' own values; not proved: the budget ended before all were looked at, or a planner failed"
    )
    boards: int = Field(description="how many boards it is about")
    searched: Extent = Field(description="their designs, by what became of them")
    beyond: tuple[str, ...] = Field(
        description="designs that are not searched, by planner and style: nothing is said of them"
    )


class Advice(ResultModel):
    """The answer to a question about boards."""

    schema_version: Literal[1] = Field(default=1, description="version of this form")
    question: str = Field(description="the question as it was understood, in a sentence")
    verdict: str = Field(description="the answer in a sentence")
    driving: str = Field(description="the speed with the recommended board, or else the fastest; empty: not asked")
    certainty: Certainty | None = Field(
        description="how sure it is that the recommended design meets the needs; None where none does"
    )
    witness: str | None = Field(
        description="of the boards that cost less, or of all where none suffices, the one whose figures have to change"
        " least for it to suffice; None where there is none"
    )
    witness_certainty: Certainty | None = Field(
        description="how sure it is that the best design of the witness does not suffice; None where none was run"
    )
    cheapest: Judged | None = Field(
        description="how sure it is, by the intervals of the prices, that no dearer board costs less than the"
        " recommended one; None where none suffices or it has no price"
    )
    proof: Proof = Field(description="what the statement about cheaper boards rests on")
    needs: Needs = Field(description="what was asked for")
    goals: tuple[Goal, ...] = Field(description="the goals")
    cell_m: float | None = Field(description="side of a cell, m; None where the map does not say it")
    rows: int = Field(description="rows of the map that is planned on")
    columns: int = Field(description="columns of the map that is planned on")
    free_cells: int = Field(description="free cells of it")
    reach: float | None = Field(
        description="share of the free cells of the map from which a path across the sides of cells leads to a goal"
    )
    starts: int = Field(description="starts that a plan is judged by")
    recommended: str | None = Field(description="the board that is recommended; None where none suffices")
    boards: tuple[BoardAdvice, ...] = Field(
        description="every board: those that suffice first, by price where it is known, then by mean power"
    )
    driven: dict[str, Driven] = Field(
        description="by board, the speed that the robot may drive with its design; without those that cannot serve"
    )
    not_searched: tuple[str, ...] = Field(description="boards with designs that were not looked at, and how many")
    remarks: tuple[str, ...] = Field(description="what a reader must know besides")
    simulated: int = Field(description="designs that were simulated for this question")
    kept: int = Field(description="designs that were taken from the cache")
    command: str | None = Field(description="the command that shows the run of the recommended design")


def advice_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw advise --json`` prints."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Advice.model_json_schema(mode="serialization")}


def judged(boards: Sequence[Board], findings: Findings, needs: Needs) -> tuple[list[BoardAdvice], dict[str, Candidate]]:
    """The advice on every board, best first, and the candidate of its best design by its name."""
    advice, best = [], {}
    for board in boards:
        tried = findings.tried[board.name]
        chosen = min(tried, key=lambda each: order(each, board, needs), default=None)
        if chosen is not None:
            best[board.name] = chosen[0]
        why = f"it has no design {needs.only}" if needs.only else "no planner has a style for its components"
        if findings.extent(board.name).designs:
            why = "none of its designs was searched within the budget"
        each = _of_board(board, chosen, tried, needs, why, findings.extent(board.name))
        if board.name in findings.excluded:
            # Its designs were not searched, so nothing is said of them but the need that none of them meets.
            each = each.model_copy(update={"shortfalls": findings.excluded[board.name][:1]})
        advice.append(each)
    return sorted(advice, key=cost_order), best


def cost_order(board: BoardAdvice) -> tuple[bool, bool, float, float, str]:
    """Those that suffice first; then those with a price, the cheapest first; then by mean power."""
    power = board.design.mean_power_w if board.design is not None else None
    price = board.price_usd
    return not board.suffices, price is None, price or 0.0, power or board.idle_w, board.board


def cheaper_than(recommended: BoardAdvice, boards: Sequence[BoardAdvice]) -> list[BoardAdvice]:
    """The boards that cost less than the recommended one, the dearest first.

    By price where both declare one. Where the recommended board declares none, by mean power.
    """

    def cost(board: BoardAdvice) -> float | None:
        if recommended.price_usd is not None:
            return board.price_usd
        design = board.design
        return board.idle_w if design is None or design.mean_power_w is None else design.mean_power_w

    limit = cost(recommended)
    costs = [(value, board) for board in boards if (value := cost(board)) is not None]
    cheaper = [(value, board) for value, board in costs if limit is not None and value < limit]
    return [board for _, board in sorted(cheaper, key=lambda each: -each[0])]


def driven_with(boards: Sequence[BoardAdvice], motion: Motion | None) -> dict[str, Driven]:
    """By board, the speed that the robot may drive with its design, where that fits and its plans serve."""
    trials = {board.board: board.design.trial for board in boards if board.design is not None}
    return {
        name: motion.driven(trial.time_s, trial.time_low_s, trial.time_high_s)
        for name, trial in trials.items()
        if motion is not None and trial.time_s is not None and not trial.shortfalls
    }


def met_alone(boards: Sequence[Board], findings: Findings, needs: Needs) -> dict[str, tuple[str, ...]]:
    """For each need, the boards with a design that fits, serves, and meets this need, whatever the others are."""
    asked = {"rate": True, "power": needs.power_w is not None, "price": needs.price_usd is not None}
    never = {"refused", "fit", "arrive"}
    return {
        need: tuple(
            board.name
            for board in boards
            if any(
                not {need, *never} & {short.need for short in shortfalls_of(trial, board, needs)}
                for _, trial in findings.tried[board.name]
            )
        )
        for need, is_asked in asked.items()
        if is_asked
    }


def _of_board(
    board: Board, chosen: Tried | None, tried: Sequence[Tried], needs: Needs, why: str, searched: Extent
) -> BoardAdvice:
    """``why`` the board has no design, where it has none."""
    serving = [each for each in tried if each[1].time_s is not None and not each[1].shortfalls]
    fastest = min(serving, key=lambda each: each[1].time_s or 0.0, default=None)
    ordered = sorted(tried, key=lambda each: order(each, board, needs))
    design = None if chosen is None else design_of(chosen, board, needs)
    short = (Shortfall(need="refused", name=why),) if chosen is None else shortfalls_of(chosen[1], board, needs)
    least, most = board.price_interval_usd or (None, None)
    return BoardAdvice(
        board=board.name,
        price_usd=board.price_usd,
        price_low_usd=least,
        price_high_usd=most,
        idle_w=board.idle_w,
        suffices=not short,
        design=design,
        fastest=None if fastest is None else design_of(fastest, board, needs),
        margin=None if design is None or design.rate_hz is None else design.rate_hz / needs.rate_hz,
        shortfalls=short,
        perhaps="" if not short else next(filter(None, (may_suffice(each[1], board, needs) for each in ordered)), ""),
        searched=searched,
        under=_under(board, None if chosen is None else chosen[0]),
    )


def _under(board: Board, chosen: Candidate | None) -> str | None:
    """The computer beside a board whose chip has no part in a design; None where it has, or where there is none."""
    sold = board.platform.board
    if sold is None or sold.beside is None or chosen is None or chosen.placement != "host":
        return None
    return sold.beside


def proof_of(
    winner: BoardAdvice | None, boards: Sequence[BoardAdvice], findings: Findings
) -> tuple[Proof, list[BoardAdvice]]:
    """What the statement about the cheaper boards, or about all where none suffices, rests on; and these boards."""
    about = list(boards) if winner is None else cheaper_than(winner, boards)
    extents = [board.searched for board in about]
    counts = {key: sum(getattr(each, key) for each in extents) for key in COUNTS}
    complete = all(each.complete for each in extents)
    sure = complete and all(findings.surely(board.board) and not board.perhaps for board in about)
    state: Literal["proved", "at own values", "not proved"] = (
        "not proved" if not complete else "proved" if sure else "at own values"
    )
    searched = Extent(designs=sum(counts.values()), complete=complete, **counts)
    met = {(each.planner, each.style) for board in about for each in findings.settled[board.board]}
    left_out = map_reduce(sorted(met), lambda each: catalog.architectures()[each].beyond, " ".join)
    beyond = tuple(f"{', '.join(styles)}: {what}" for what, styles in left_out.items() if what)
    return Proof(state=state, boards=len(about), searched=searched, beyond=beyond), about


def cheapest(winner: BoardAdvice, advice: Sequence[BoardAdvice], boards: Sequence[Board]) -> Judged | None:
    """How sure it is that no board that costs more by its own price may suffice and cost less than the winner.

    A board whose price has the winner's in it, as that is the computer beside it, costs more at any price.
    """
    price, low, high = winner.price_usd, winner.price_low_usd, winner.price_high_usd
    if price is None or low is None or high is None:
        return None
    above = {board.name for board in boards if winner.board in (board.prices or {})}
    dearer = [each for each in advice if each.board not in above and price < (each.price_usd or 0.0)]
    may = [each for each in dearer if (each.price_low_usd or 0.0) < high]
    may = [each for each in may if each.suffices or each.perhaps or not each.searched.complete]
    price_of: dict[str, Any] = {"need": "price", "value": price, "low": low, "high": high, "unit": "USD"}
    if not may:
        return Judged(state="holds", text="", **price_of)
    nearest = min(may, key=lambda each: (not each.suffices, each.price_usd))
    at = nearest.price_usd if nearest.price_usd is not None and nearest.price_usd <= high else None
    text = f"whether it is the cheapest depends on its price ({_ends(winner)})"
    text += "" if at is None else f", and changes at {number_text(at)} USD"
    text += f": {nearest.board} {'suffices too' if nearest.suffices else 'may suffice'} ({_ends(nearest)})"
    text += f", and {counted(len(may) - 1, 'board')} more may cost less" if len(may) > 1 else ""
    return Judged(state="depends", name=f"{winner.board}'s board.price", changes_at=at, text=text, **price_of)


def _ends(board: BoardAdvice) -> str:
    return f"{number_text(board.price_low_usd or 0.0)} to {number_text(board.price_high_usd or 0.0)} USD"


def distance(board: BoardAdvice) -> float:
    """The factor by which figures of a board have to change for its best design to suffice; one not known: by none."""
    return max((1.0 if short.is_unknown else short.ratio for short in board.shortfalls), default=1.0)


def design_of(tried: Tried, board: Board, needs: Needs) -> Design:
    """A design and what it comes to."""
    candidate, trial = tried
    binds, share = _binding(trial, shortfalls_of(trial, board, needs), board, needs)
    return Design(
        planner=candidate.planner.name,
        style=candidate.style.style,
        placement=candidate.placement,
        mapping={task: dict(mapped) for task, mapped in candidate.mapping.items()},
        settings=dict(candidate.settings),
        trial=trial,
        rate_hz=None if trial.time_s is None else 1 / max(trial.time_s, 1e-12),
        mean_power_w=mean_power(trial, board, needs),
        input_power_w=input_power(trial, board, needs),
        binds=binds,
        binds_share=share,
    )


def _binding(trial: Trial, short: Sequence[Shortfall], board: Board, needs: Needs) -> tuple[str, float | None]:
    """The limit that is passed by most; where none is, the one that is nearest."""
    if short:
        worst = max(short, key=lambda shortfall: shortfall.ratio)
        return worst.need if worst.need != "fit" else worst.name, _finite(worst.ratio)
    shares = {}
    if trial.time_s is not None:
        shares["rate"] = trial.time_s / needs.period_s
    power = input_power(trial, board, needs)
    if needs.power_w and power is not None:
        shares["power"] = power / needs.power_w
    if needs.price_usd and board.price_usd is not None:
        shares["price"] = board.price_usd / needs.price_usd
    if trial.fullest is not None:
        shares[trial.fullest.resource] = trial.fullest.share
    nearest = max(shares, key=lambda name: shares[name])
    return nearest, shares[nearest]


def _finite(ratio: float) -> float | None:
    return ratio if math.isfinite(ratio) else None
