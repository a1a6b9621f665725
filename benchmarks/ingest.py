"""A house of Zigbee lamps at start: configs that a Mosquitto kept, until all lamps are known.

Each figure is of a process of its own, which begins before its first connection, so that nothing is warm. A process
before them leaves compiled modules, as an installation does.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench_ingest import seed
from mosquitto import mosquitto
from plan import Plan
from report import Aim, Comparison, MissingPeerError, Report, compare, megabytes, seconds
from rounds import Samples

__all__ = ["run"]

HOMEBOT = "homebot, gateway and directory"
HOME_ASSISTANT = "Home Assistant, MQTT integration"
BARE = "aiomqtt + pydantic + dict"

FEWEST = 1000

FIGURES: dict[str, tuple[Callable[[dict[str, Any]], float], Callable[[float], str], Aim | None]] = {
    "until all are known": (lambda answer: answer["seconds"], seconds, Aim("at most", 1 / 5)),
    "processor time each": (lambda answer: answer["cpu"] / answer["found"], lambda cpu: f"{1e3 * cpu:.3f} ms", None),
    "processor time each, start included": (
        lambda answer: answer["process"] / answer["found"],
        lambda cpu: f"{1e3 * cpu:.3f} ms",
        None,
    ),
    "memory": (lambda answer: answer["memory"], megabytes, None),
}


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    comparisons: list[Comparison] = []
    notes: list[str] = []
    with tempfile.TemporaryDirectory() as compiled:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for count, rounds in ((FEWEST, 3), (10_000, 1)) if not plan.quick else ((FEWEST, 1),):
            comparisons += _measured(plan, count, rounds, notes, environment)
    return Report("ingest: retained discovery configs, until every lamp is known", comparisons, notes)


def _measured(plan: Plan, count: int, rounds: int, notes: list[str], environment: dict[str, str]) -> list[Comparison]:
    assert plan.mosquitto is not None
    answers: dict[str, list[dict[str, Any]]] = {}
    with mosquitto(plan.mosquitto) as port:
        seed(port, count)
        contenders = list(_contenders(plan).items())
        for _, command in contenders if count == FEWEST else ():
            _ask(command, port, count, environment)
        for number in range(rounds):
            for name, command in contenders[:: -1 if number % 2 else 1]:
                if (answer := _ask(command, port, count, environment)) is not None:
                    if answer["found"]:
                        answers.setdefault(name, []).append(answer)
                    if answer["found"] != count:
                        notes.append(f"{name} knew {answer['found']:,} of {count:,} lamps in the end.")
    answers = {name: given for name, given in answers.items() if len(given) == rounds}
    lines: list[Comparison] = []
    for what, (figure, show, aim) in FIGURES.items():
        samples: Samples = {name: [figure(one) for one in given] for name, given in answers.items()}
        pairs = [(HOMEBOT, HOME_ASSISTANT, aim)]
        if what != "memory":  # the bare loop's is less than what its imports took at their peak
            pairs.append((HOMEBOT, BARE, None))
        lines += compare(f"{count:,} lamps: {what}", samples, pairs, show)
    return lines


def _contenders(plan: Plan) -> dict[str, list[str]]:
    here = Path(__file__).parent
    contenders = {
        HOMEBOT: [sys.executable, str(here / "ingest_homebot.py")],
        BARE: [sys.executable, str(here / "ingest_bare.py")],
    }
    if plan.home_assistant_python is not None:
        contenders[HOME_ASSISTANT] = [str(plan.home_assistant_python), str(here / "ingest_home_assistant.py")]
    return contenders


def _ask(command: list[str], port: int, count: int, environment: dict[str, str]) -> dict[str, Any] | None:
    """Return what a worker found; None where it could not run, which it tells on standard error."""
    done = subprocess.run(
        [*command, str(port), str(count)], stdout=subprocess.PIPE, text=True, check=False, env=environment
    )
    if done.returncode:
        return None
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer
