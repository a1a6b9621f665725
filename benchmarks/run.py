"""Runs the benchmarks and prints one table each: ``python benchmarks/run.py [--quick] [NAME...]``.

It ends with 1 where an aim falls short, a peer is missing, or a benchmark fails, and says which.
``make bench`` sets everything up and calls this.
"""

from __future__ import annotations

import argparse
import importlib
import shutil
import subprocess
import sys
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from figures import keep_figures
from homebot.log import configure_logging
from machine import describe_machine
from plan import Plan
from report import SHORT, MissingPeerError, Report, print_report
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
    "ble_proxies",
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
    "waits",
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

WITH_HOME_ASSISTANT = frozenset({"graph_deliveries", "service_calls", "ingest", "states"})

WITH_EXTRAS = ("ble_proxies", "goals", "outcomes_networks", "machines", "waits", "discovery")
"""Those that need extras, which are not installed where start-up and memory are measured."""

UNMEASURED, FAILED = "not measured, at least in part", "failed, with the error above"

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
        if peer is None and not WITH_HOME_ASSISTANT.isdisjoint(options.names or BENCHMARKS):
            print(f"Home Assistant is not measured: no {options.home_assistant}; `make bench` installs it.")
        plan = Plan(
            quick=options.quick,
            home_assistant=peer,
            mosquitto=mosquitto,
            home_assistant_python=options.home_assistant if peer else None,
        )
        results = {
            name: _measured_by(options.extras, name, plan)
            if name in WITH_EXTRAS and options.extras is not None
            else _measured(name, plan)
            for name in options.names or BENCHMARKS
        }
    print(f"\n{time.perf_counter() - started:.0f} s{', --quick: a look, not a measurement' if options.quick else ''}")
    sys.exit("\n".join(_complaints(results)) or None)


def _measured(name: str, plan: Plan) -> list[str]:
    """Run one benchmark, and return what is wrong with it; a failure is printed, and the next one runs."""
    try:
        report: Report = importlib.import_module(FILES.get(name, name)).run(plan)
    except MissingPeerError as exc:
        print(f"\n## {name}\n\nNOT MEASURED: {exc}.")
        return [UNMEASURED]
    except Exception:  # noqa: BLE001  # whatever it is, the next one runs
        print(f"\n## {name} failed\n", file=sys.stderr)
        traceback.print_exc()
        return [FAILED]
    print_report(report)
    if not plan.quick:
        keep_figures(name, report)
    is_whole = not report.missing and (plan.home_assistant is not None or name not in WITH_HOME_ASSISTANT)
    return [*(() if is_whole else (UNMEASURED,)), *((SHORT,) if report.falls_short else ())]


def _measured_by(python: Path, name: str, plan: Plan) -> list[str]:
    """Run one benchmark with another Python, as :func:`_measured` does."""
    command = [str(python), __file__, *(["--quick"] if plan.quick else []), "--home-assistant", "", name]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    sys.stderr.write(done.stderr)
    return [what for what in (SHORT, UNMEASURED, FAILED) if f"{what}: {name}" in done.stderr] or (
        [FAILED] if done.returncode else []
    )


def _complaints(results: Mapping[str, list[str]]) -> Iterator[str]:
    for what in (SHORT, UNMEASURED, FAILED):
        if names := [name for name, found in results.items() if what in found]:
            yield f"{what}: {', '.join(names)}"


@contextmanager
def _home_assistant(python: Path) -> Iterator[Worker | None]:
    if not python.is_file():
        yield None
        return
    with worker("home_assistant_worker.py", python) as peer:
        yield peer


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Measure homebot side by side with its peers.")
    parser.add_argument("names", nargs="*", metavar="NAME", choices=[[], *BENCHMARKS], help=", ".join(BENCHMARKS))
    parser.add_argument("--quick", action="store_true", help="few rounds: a look, not a measurement")
    parser.add_argument(
        "--extras", type=Path, metavar="PYTHON", help=f"the Python with all extras, which runs {', '.join(WITH_EXTRAS)}"
    )
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
