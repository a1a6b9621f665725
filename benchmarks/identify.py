"""How surely and how soon the device in view is identified, in simulated rooms: of 8 lamps, unless said."""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median, quantiles
from typing import Final

from plan import Plan
from report import Report, verdict

sys.path.append(str(Path(__file__).parents[1]))
from tests.features.identify.rooms import Rooms, identify

__all__ = ["run"]

ROOMS: Final = 400
SURE: Final = 0.99
WRONG: Final = 0.001
HEADINGS: Final = ("rooms", "right", "wrong with certainty", "median", "p95", "aim", "")
KINDS: Final = (
    ("up to 0.4 s late", Rooms(), SURE, 20.0),
    ("up to 2 s late", Rooms(late=2.0), SURE, 35.0),
    ("strong reflections", Rooms(reflections=0.5), 0.97, 20.0),
    ("less noise", Rooms(noise=0.1), SURE, 20.0),
    ("none in view", Rooms(is_in_view=False), SURE, 35.0),
    ("the light jumps by ten times the effect", Rooms(jump=10.0), SURE, 20.0),
    ("3 lamps", Rooms(count=3), SURE, 14.0),
    ("32 lamps", Rooms(count=32), SURE, 35.0),
    ("one lamp, in view", Rooms(count=1), SURE, 14.0),
    ("one lamp, not in view", Rooms(count=1, is_in_view=False), SURE, 14.0),
)


def run(plan: Plan) -> Report:
    count = plan.count(ROOMS)
    rows: list[tuple[str, ...]] = [HEADINGS]
    for name, kind, least, longest in KINDS:
        found = [identify(kind, seed) for seed in range(count)]
        right, wrong = (
            sum(ones) / count for ones in zip(*((one.is_right, one.is_wrong) for one in found), strict=True)
        )
        spent = [one.seconds for one in found]
        figures = f"{right:.1%}", f"{wrong:.1%}", f"{median(spent):.0f} s", f"{quantiles(spent, n=20)[-1]:.0f} s"
        is_met = right >= least and wrong <= WRONG and median(spent) <= longest
        aim = f">= {least:.0%}, <= {WRONG:.1%}, <= {longest:g} s"
        rows.append((name, *figures, aim, verdict(is_met)))
    return Report(f"Identify: {count} rooms each", (), (), rows)
