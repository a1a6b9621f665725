"""Runs the benchmarks and prints one table each: ``python benchmarks/run.py [--quick] [NAME...]``.

``make bench`` sets everything up and calls this.
"""

from __future__ import annotations

import argparse
import importlib
import shutil
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from homebot.log import configure_logging
from machine import describe_machine
from plan import Plan
from report import print_report
from worker import Worker, worker

BENCHMARKS = (
    "graph_deliveries",
    "service_calls",
    "gateway_load",
    "home_assistant_load",
    "round_trip",
    "broker_load",
    "broker_fixture",
    "start_up",
    "ingest",
    "zigbee_house",
    "what_asks",
    "states",
    "command_line",
    "walks",
    "places",
    "near",
    "goals",
    "identify",
    "habits",
    "command_cost",
    "outcomes",
    "outcomes_networks",
    "machines",
    "discovery",
    "left_on",
    "page",
)
FILES = {
    "discovery": "discovery_criteria",
    "outcomes": "command_outcomes",
    "outcomes_networks": "command_outcomes_networks",
}
"""The files of benchmarks that are called otherwise."""

HOME_ASSISTANT_PYTHON = Path(__file__).parent.parent / ".venv-bench-ha/bin/python"


def main() -> None:
    options = _parse()
    started = time.perf_counter()
    configure_logging(level="error")
    mosquitto = shutil.which("mosquitto") or shutil.which(
        "mosquitto", path="/usr/sbin:/usr/local/sbin:/opt/homebrew/sbin"
    )
    with _home_assistant(options.home_assistant) as peer:
        print(describe_machine(peer.greeting["version"] if peer else None, mosquitto))
        if peer is None:
            print(f"Home Assistant is not measured: no {options.home_assistant}; `make bench` installs it.")
        plan = Plan(
            quick=options.quick,
            home_assistant=peer,
            mosquitto=mosquitto,
            home_assistant_python=options.home_assistant if peer else None,
        )
        failed = [name for name in options.names or BENCHMARKS if not _measured(name, plan)]
    print(f"\n{time.perf_counter() - started:.0f} s{', --quick: a look, not a measurement' if options.quick else ''}")
    if failed:
        sys.exit(f"failed, with the error above: {', '.join(failed)}")


def _measured(name: str, plan: Plan) -> bool:
    """Run one benchmark; a failure is printed, and the next one runs."""
    try:
        print_report(importlib.import_module(FILES.get(name, name)).run(plan))
    except Exception:  # noqa: BLE001  # whatever it is, the next one runs
        print(f"\n## {name} failed\n", file=sys.stderr)
        traceback.print_exc()
        return False
    return True


@contextmanager
def _home_assistant(python: Path) -> Iterator[Worker | None]:
    if not python.exists():
        yield None
        return
    with worker("home_assistant_worker.py", python) as peer:
        yield peer


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Measure homebot side by side with its peers.")
    parser.add_argument("names", nargs="*", metavar="NAME", choices=[[], *BENCHMARKS], help=", ".join(BENCHMARKS))
    parser.add_argument("--quick", action="store_true", help="few rounds: a look, not a measurement")
    parser.add_argument(
        "--home-assistant",
        type=Path,
        default=HOME_ASSISTANT_PYTHON,
        metavar="PYTHON",
        help="the Python that has Home Assistant installed (default: %(default)s)",
    )
    return parser.parse_args()


if __name__ == "__main__":
    main()
