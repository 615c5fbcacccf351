"""Works that share most of what they compute go to one worker, and no worker is idle for that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np

import codesign
from codesign.study.budget import Budget
from codesign.study.evaluation import Pricer
from codesign.study.executor import ProcessExecutor
from codesign.study.explored import Explored
from codesign.study.partition import Affinity, Together, Work, parted
from codesign.study.pricing.machines import Specs
from codesign.study.space import Space
from codesign.study.work_queue import MOST_WAITING, Dealer

NO_SPECS = Specs({}, {}, 1)


def work(number: int, *affinity: int) -> Together:
    return Together(np.array([number], np.int64), {}, NO_SPECS, str(number), affinity or None)


def works(affinities: Iterable[int]) -> list[Together]:
    return [work(number, affinity) for number, affinity in enumerate(affinities)]


def place(drawn: Work | None) -> int:
    assert isinstance(drawn, Together)
    return int(drawn.numbers[0])


def test_works_of_one_affinity_go_to_the_slot_that_began_it() -> None:
    # The third work is of the affinity that A began, so B goes on with the fourth.
    dealer = Dealer(works([1, 2, 1, 3, 2, 1]))
    drawn = [(slot, place(dealer.draw(slot))) for slot in "ABBAAB"]
    assert drawn == [("A", 0), ("B", 1), ("B", 3), ("A", 2), ("A", 5), ("B", 4)]
    assert dealer.is_empty()


def test_an_idle_slot_takes_over_half_of_what_waits_for_another_one() -> None:
    dealer = Dealer(works([1] * 9))
    assert place(dealer.draw("A")) == 0
    assert place(dealer.draw("B")) == 5  # the last four of the eight that wait for A
    assert [place(dealer.draw(slot)) for slot in "AABBB"] == [1, 2, 6, 7, 8]
    assert [place(dealer.draw(slot)) for slot in "BA"] == [4, 3]
    assert dealer.draw("A") is dealer.draw("B") is None


def test_an_affinity_that_is_taken_over_stays_where_it_went() -> None:
    # A begins two affinities. Where B has nothing else to do it takes the larger one over, and its later works too.
    dealer = Dealer(works([1, 2, *[1, 1, 1, 2, 2, 2, 2] * 30]))
    assert [place(dealer.draw("A")) for _ in range(2)] == [0, 1]
    first = dealer.draw("B")
    assert isinstance(first, Together)
    slots = Counter(
        str(other.affinity) for other in (dealer.draw("B") for _ in range(20)) if isinstance(other, Together)
    )
    assert first.affinity is not None
    assert slots == {str(first.affinity): 20}


def test_no_more_works_wait_than_are_allowed() -> None:
    taken = []

    def lazily() -> Iterable[Work]:
        for each in works([1] * 1000):
            taken.append(each)
            yield each

    dealer = Dealer(lazily())
    dealer.draw("A")
    dealer.draw("B")
    assert len(taken) == 1 + MOST_WAITING


def test_every_work_is_dealt_once_whatever_the_slots_ask_for() -> None:
    chance = np.random.default_rng(1)
    for _ in range(50):
        dealer = Dealer(works(chance.integers(0, 7, 200).tolist()))
        dealt: list[int] = []
        while (drawn := dealer.draw(int(chance.choice(3, p=[0.8, 0.15, 0.05])))) is not None:
            if chance.random() < 0.1:
                dealer.put_back([drawn], int(chance.integers(3)))
            else:
                dealt.append(place(drawn))
        while (rest := next((each for slot in range(3) if (each := dealer.draw(slot)) is not None), None)) is not None:
            dealt.append(place(rest))
        assert sorted(dealt) == list(range(200))


def test_one_slot_has_the_works_in_their_order() -> None:
    dealer = Dealer(works([3, 1, 3, 2, 1]))
    assert [place(each) for each in dealer] == [0, 1, 2, 3, 4]


def test_what_comes_back_is_next_where_its_affinity_is() -> None:
    dealer = Dealer(works([1, 2, 1, 2]))
    first, _ = dealer.draw("A"), dealer.draw("B")
    assert first is not None
    dealer.put_back([first], "A")
    assert [place(dealer.draw(slot)) for slot in "BAA"] == [3, 0, 2]


def test_works_that_wait_are_not_begun_after_the_time() -> None:
    now = [0.0]
    budget = Budget(seconds=10.0, clock=lambda: now[0])
    dealer = Dealer(budget.within(works([1, 1, 1, 1, 2])), budget.late)
    assert [place(dealer.draw(slot)) for slot in "AB"] == [0, 4]
    now[0] = 11.0
    assert dealer.draw("A") is dealer.draw("B") is None
    assert (budget.used, budget.ended) == (2, "the time of 10 s was over")


def affinities_of(name: str) -> Counter[Affinity | None]:
    explored = Explored.of(codesign.load_platform("virtex4-pci"), codesign.load_workload(name))
    space = Space(explored.section.every_axis, "")
    each = parted(explored, space, np.arange(len(space)))
    return Counter(work.affinity for work in each if isinstance(work, Together))


def test_the_affinities_of_the_labyrinth_are_its_blocks_and_iterations() -> None:
    assert sorted(affinities_of("labyrinth").values()) == [18] * 49


def test_two_processes_compute_works_of_several_affinities_once_each() -> None:
    explored = Explored.of(codesign.load_platform("virtex4-pci"), codesign.load_workload(STAGES))
    space = Space(explored.section.every_axis, "")
    whole = list(parted(explored, space, np.arange(len(space))))
    came = list(ProcessExecutor(2).run(whole, Pricer(explored, space)))
    assert sorted(index for done in came for index in done.work.indices) == list(range(len(space)))
    assert all(done.together for done in came)


STAGES = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: maze, rows: 13, columns: 17, seed: 3}
  goals: [[0, 1]]
  starts: {count: 5, seed: 0}
  arrive: 0
mapping:
  relax: {component: fpga, block: [6, 8], iterations: 6, schedule: [7]}
  decide: {component: fpga}
explore:
  axes:
    relax.iterations: [1, 2, 4]
    relax.schedule: [[7], [7, 15], [7, 23], [15, 23]]
"""
