"""Prints how many lamps were turned off over people: ``python -m tests.days.table --days 1000``.

First one day of the family home, then random days. Each random day is lived twice: with the light service of the thesis
and without policies, and with random apps and policies, where it must hold what the oracle says.
"""

import argparse
import sys
import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings
from tests.days.closed_rooms import closed_room_refusals
from tests.days.living import LivedDay, live
from tests.days.oracle import broken_chains, is_unseen, is_wish, issuers_of, unseen, unseen_open, violations
from tests.days.random_day import RandomDay, random_days
from tests.days.truth import is_off
from tests.thesis_light_service import THESIS_LIGHT_SERVICE

from homebot.log import configure_logging
from homebot.testing import Day

_HEADINGS = (
    "day",
    "days",
    "offs",
    "over somebody awake",
    "of them unseen",
    "nobody awake",
    "by people",
    "violations",
    "refused",
    "though nobody awake",
    "though nobody there",
    "broken chains",
)
_THESIS = "thesis's light service, no policies"
_JUDGED = "random apps, with policies"
_FAMILY = Path(__file__).parents[2] / "examples" / "houses" / "family.toml"
_GUARDED = {"time_zone": "UTC", "presence_guard": True}
_SHOWN = 100
"""Days after which the table so far is printed, as a thousand take long."""


def main() -> int:
    """Print the table; return 1 where a policy was violated or a chain is not complete."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--days", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--max-length", default="24h")
    options = parser.parse_args()
    configure_logging(level="error")
    counts = family()
    has_problem = lives(options.days, options.seed, options.max_length, counts)
    _print(counts)
    return 1 if has_problem else 0


def family() -> dict[str, Counter[str]]:
    """Live one day of the family home in several ways; return what happened in each."""
    day = RandomDay(Day(tomllib.loads(_FAMILY.read_text("utf-8"))), _GUARDED, {}, (), seed=1)
    found: dict[str, Counter[str]] = {}
    for name, apps in (
        ("thesis's light service", (THESIS_LIGHT_SERVICE,)),
        ("light service", ("light_service",)),
        ("lights out and follow me", ("lights_out", "follow_me")),
    ):
        for has_policies, how in ((False, "no policies"), (True, "presence guard")):
            counts = found[f"family: {name}, {how}"] = Counter()
            _add(counts, live(day, *apps, has_policies=has_policies))
    return found


def lives(days: int, number: int, max_length: str, counts: dict[str, Counter[str]]) -> bool:
    """Live random days and add them to *counts*; print each problem, and return whether there was any."""
    thesis, judged = (counts.setdefault(f"random: {name}", Counter()) for name in (_THESIS, _JUDGED))
    lived_days: set[str] = set()
    most = judged["days"] + days

    @settings(
        max_examples=2 * days,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(random_days(max_length=max_length))
    def one(day: RandomDay) -> None:
        if judged["days"] >= most or repr(day) in lived_days:
            return  # Hypothesis makes some examples twice
        lived_days.add(repr(day))
        _add(thesis, live(day, THESIS_LIGHT_SERVICE, has_policies=False))
        lived = live(day)
        violated, broken = violations(day, lived), broken_chains(lived)
        _add(judged, lived)
        judged.update(violations=len(violated), broken=len(broken), unknowable=len(unseen(lived)))
        judged.update(f"violates {one.policy}" for one in violated)
        _add_doors(judged, day, lived)
        if judged["days"] % _SHOWN == 0:
            _print(counts)
        if violated or broken:
            print(*violated, *broken, repr(day), sep="\n", file=sys.stderr, flush=True)

    while judged["days"] < most:
        seed(number)(one)()
        number += 1_000_000
    return judged["violations"] + judged["broken"] > 0


def _add(counts: Counter[str], lived: LivedDay) -> None:
    offs = [one for one in lived.commands if is_off(one)]
    issuers = issuers_of(lived)
    wishes = [one for one in offs if is_wish(one, issuers)]
    refused = [
        one.results[0].policy for one in lived.entries if one.kind == "outcome" and one.results[0].outcome == "refused"
    ]
    guarded = [
        lived.presence[one.command][lived.rooms[lived.names[one.device]]]
        for one in lived.entries
        if one.kind == "outcome" and one.results[0].policy == "presence_guard"
    ]
    counts.update(
        days=1,
        offs=len(offs),
        over=sum(1 for one in offs if one.awake and one not in wishes),
        unseen=sum(1 for one in offs if one.awake and is_unseen(one, lived) and one not in wishes),
        empty=sum(1 for one in offs if not one.awake and one not in wishes),
        wishes=len(wishes),
        guarded=sum(1 for _ in guarded),
        unneeded=sum(1 for awake, _ in guarded if not awake),
        alone=sum(1 for _, there in guarded if not there),
        commands=sum(1 for one in lived.entries if one.kind == "requested"),
        refused=len(refused),
    )
    counts.update(f"by {one}" for one in refused)


def _add_doors(counts: Counter[str], day: RandomDay, lived: LivedDay) -> None:
    """Count what the presence guard refused because of closed doors alone, and what was heated with a window open."""
    closed, heated = closed_room_refusals(day, lived), unseen_open(lived)
    counts.update(
        listed=bool(day.doors),
        closed=len(closed),
        closed_days=bool(closed),
        closed_awake=sum(1 for one in closed if one.awake),
        closed_there=sum(1 for one in closed if one.there),
        closed_sound=sum(1 for one in closed if one.is_sound),
        heated=len(heated),
        heated_unproven=sum(1 for one in heated if not one.is_ever_told_open),
    )


def _print(counts: Mapping[str, Counter[str]]) -> None:
    rows = [_HEADINGS, *(_row(name, one) for name, one in counts.items())]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADINGS))]
    for number, row in enumerate(rows):
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |")
        if not number:
            print("|" + "|".join("-" * (width + 2) for width in widths) + "|")
    total = counts[f"random: {_JUDGED}"]
    by = {name.removeprefix("by "): count for name, count in total.items() if name.startswith("by ")}
    refused = ", ".join(f"{count:,} by {name}" for name, count in sorted(by.items(), key=lambda one: -one[1]))
    violated = {name.removeprefix("violates "): count for name, count in total.items() if name.startswith("violates ")}
    print(f"\nviolated: {violated or 'no policy'}")
    print(f"\nover people whom no sensor told of, covers too: {total['unknowable']}")
    asleep = total["closed_there"] - total["closed_awake"]
    print(
        f"\nclosed doors alone: {total['closed']:,} refused in {total['closed_days']:,} of {total['listed']:,} days"
        f" with listed doors: {total['closed_awake']:,} over somebody awake, {asleep:,} over somebody asleep;"
        f" {total['closed_sound']:,} where they must be right"
    )
    unproven = f"{total['heated_unproven']:,} of them by a contact that never said open"
    print(f"\nheated while open though each contact said closed: {total['heated']:,}, {unproven}")
    print(f"\n{total['commands']:,} commands of random apps, {total['refused']:,} refused: {refused}\n", flush=True)


def _row(name: str, counts: Counter[str]) -> tuple[str, ...]:
    figures = [f"{counts[one]:,}" for one in ("days", "offs", "over", "unseen", "empty", "wishes")]
    of_policies = ("violations", "guarded", "unneeded", "alone", "broken")
    judged = [f"{counts[one]:,}" if name.endswith(_JUDGED) else "-" for one in of_policies]
    return (name, *figures, *judged)


if __name__ == "__main__":
    sys.exit(main())
