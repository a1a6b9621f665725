"""How surely and how soon the device in view is identified without a stated least effect: of 8 lamps, unless said."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from statistics import median, quantiles
from typing import Final

from plan import Plan
from report import Report, verdict

sys.path.append(str(Path(__file__).parents[1]))
from tests.features.identify.rooms import Rooms, identify

__all__ = ["run"]

ROOMS: Final = 60
SURE: Final = 0.99
WRONG: Final = 0.0
UNSURE: Final = 0.0
HEADINGS: Final = ("rooms", "right", "wrong with certainty", "median", "p95", "aim", "")
KINDS: Final = (
    ("up to 0.4 s late", Rooms(), SURE, 24.0),
    ("up to 2 s late", Rooms(late=2.0), SURE, 40.0),
    ("reflections up to half of the effect", Rooms(reflections=0.5), 0.95, 35.0),
    ("less noise", Rooms(noise=0.1), SURE, 24.0),
    ("none in view", Rooms(is_in_view=False), UNSURE, 65.0),
    ("the light jumps by ten times the effect", Rooms(jump=10.0), 0.85, 35.0),
    ("3 lamps", Rooms(count=3), SURE, 24.0),
    ("32 lamps", Rooms(count=32), UNSURE, 65.0),
    ("one lamp, in view", Rooms(count=1), SURE, 24.0),
    ("one lamp, not in view", Rooms(count=1, is_in_view=False), 0.8, 24.0),
    ("two alike", Rooms(twin=1.0), UNSURE, 65.0),
    ("noise of half the effect", Rooms(noise=0.5), UNSURE, 65.0),
    ("fades of 5 s", Rooms(late=0.0, fade=5.0), UNSURE, 65.0),
    ("steps of half the effect", Rooms(step=0.5), SURE, 35.0),
    ("steps of the effect", Rooms(step=1.0), UNSURE, 65.0),
)


def run(plan: Plan) -> Report:
    count = plan.count(ROOMS)
    rows: list[tuple[str, ...]] = [HEADINGS]
    for name, kind, least, longest in KINDS:
        found = [identify(replace(kind, least=0.0), seed) for seed in range(count)]
        right, wrong = (
            sum(ones) / count for ones in zip(*((one.is_right, one.is_wrong) for one in found), strict=True)
        )
        spent = [one.seconds for one in found]
        figures = f"{right:.1%}", f"{wrong:.1%}", f"{median(spent):.0f} s", f"{quantiles(spent, n=20)[-1]:.0f} s"
        is_met = right >= least and wrong <= WRONG and median(spent) <= longest
        aim = f">= {least:.0%}, {WRONG:.0%}, <= {longest:g} s"
        rows.append((name, *figures, aim, verdict(is_met)))
    return Report(f"Identify: {count} rooms each", (), (), rows)
