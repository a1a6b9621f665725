"""Print how well causes are known, by kind and play: ``python -m tests.control.timeline.truth_table --seeds 10``."""

import argparse
import asyncio
import logging
import sys
from collections.abc import Sequence

from tests.control.conftest import opened_home
from tests.control.timeline.plays_table import PLAYS, score_of
from tests.control.timeline.simulated_house import Tables, Truth
from tests.control.timeline.simulated_kinds import KINDS, Kind, Play, mixed

from homebot.support.virtual_time import VirtualTimeLoop

OLD_KINDS = Kind("old kinds together", mixed, hand_every=100.0)

_SHARES: tuple[tuple[Truth, str], ...] = (
    ("person", "person"),
    ("person", "unknown"),
    ("device", "device"),
    ("program", "program"),
)

_HEADINGS = (
    f"{'kind (aim)':27}",
    "commands",
    "sent over a person (0)",
    "told person and none (5 %)",
    "persons named",
    "unknown",
    "devices told so",
    "programs told so",
    "persons told command (0)",
    "or device (0)",
    "two answers (0)",
    "held again (all)",
    "missed aims",
)


def play(kind: Kind, seeds: Sequence[int]) -> Tables:
    """Return what was told in the houses of a kind."""
    tables = Tables()
    for seed in seeds:
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            runner.run(Play(kind, seed, tables).run(opened_home))
    return tables


def row(name: str, tables: Tables, failures: Sequence[str]) -> str:
    """Return the figures as a row of the table."""
    told = tables.count
    cells = (
        name,
        f"{tables.commands:,}",
        tables.overridden.total(),
        f"{tables.wrong_persons:.1%}" if told(told="person") else "-",
        *(f"{tables.share(truth, cause):.0%}" if told(truth=truth) else "-" for truth, cause in _SHARES),
        told(truth="person", told="command") + told(truth="person", told="transition"),
        told(truth="person", told="device") + told(truth="person", told="program"),
        f"{tables.seen['two answers']} of {tables.seen['asked']:,}",
        f"{tables.seen['held again']} of {tables.seen['cuts']}",
        "; ".join(failures) or "none",
    )
    texts = (f"{cell!s:{len(heading)}}" for cell, heading in zip(cells, _HEADINGS, strict=True))
    return "| " + " | ".join(texts) + " |"


def main(words: Sequence[str] | None = None) -> int:
    """Play the kinds, and print a table; return 1 if an aim is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10, help="how many seeds")
    parser.add_argument("--first", type=int, default=0, help="the first of them")
    parser.add_argument("--kind", default="", help="the kinds and plays that contain this text")
    parser.add_argument("--notes", action="store_true", help="print what was wrong, and all that was told")
    given = parser.parse_args(words)
    logging.disable()
    seeds = range(given.first, given.first + given.seeds)
    kinds = [kind for kind in (OLD_KINDS, *KINDS) if given.kind in kind.name]
    print("| " + " | ".join(_HEADINGS) + " |")
    is_missed, total = False, Tables()
    for kind in kinds:
        tables = play(kind, seeds)
        failures = kind.failures(tables, len(seeds))
        is_missed |= bool(failures)
        print(row(kind.name, tables, failures), flush=True)
        total.add(tables)
        if given.notes:
            print(tables.text(), *tables.notes, sep="\n")
    print(row("all kinds", total, []))
    for name in (name for name in PLAYS if given.kind in name):
        score = score_of(name, seeds)
        missed = PLAYS[name].missed(score)
        is_missed |= bool(missed)
        for what, asked in score.asked.items():
            share = f"{score.so[what]:,} of {asked:,}"
            print(f"| {name:42} | {what:42} | {share:>16} | {'missed' if what in missed else 'none'} |", flush=True)
        if given.notes:
            print(*score.failures, sep="\n")
    return int(is_missed)


if __name__ == "__main__":
    sys.exit(main())
