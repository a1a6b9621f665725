"""A ``homebot run`` with an app of every misbehaviour: the house goes on, and the doctor names each."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.shell import publish_raw
from tests.system.own_time import own_time_until_end
from tests.system.test_run import CUT_OFF_WITHIN, SETTINGS, STOPS_WITHIN, Run
from tests.turns import slowness

from homebot.cli.serve import EXIT_AFTER

pytestmark = pytest.mark.system

MODULE = "tests.system.hostile_apps"
ROOT = Path(__file__).parents[2]

MISBEHAVIOURS = {
    "Raiser": "raiser  crashed",
    "CancelsTask": "cancels_task  crashed",
    "CancelsItself": "cancels_itself  crashed",
    "Exits": "exits  crashed",
    "ExitsInTask": "event loop  called exit",
    "RaisesGeneratorExit": "raises_generator_exit  crashed",
    "RaisesAtStart": "raises_at_start  crashed",
    "BadHandler": "bad_handler  the handler of /hostile failed",
    "BadTimer": "bad_timer  the timer of 0.5 s failed",
    "BadService": "bad_service  the handler of /bad_service failed",
    "Blocks": "event loop  was blocked",
}


def ask(run: Run, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "homebot", "--door", f"127.0.0.1:{run.port}", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        env=SETTINGS,
        check=False,
    )


def test_no_app_is_the_end_of_the_house_and_the_doctor_names_each(tmp_path: Path) -> None:
    apps = [word for name in (*MISBEHAVIOURS, "ReturnsEarly") for word in ("--app", f"{MODULE}:{name}")]
    run = Run(tmp_path, "--app", "light_service", *apps, PYTHONPATH=str(ROOT))
    try:
        run.until("returns_early ended")
        run.until("roomlights405 → off")
        assert ask(run, "service", "call", "/bad_service").returncode == 1
        run.until("cancels_task crashed 5 times within a minute and will not be restarted")
        run.until("the event loop runs again; it was blocked for")
        doctor = ask(run, "doctor")
        squeezed = [" ".join(line.split()) for line in doctor.stdout.splitlines()]
        for words in MISBEHAVIOURS.values():
            assert any(line.startswith(" ".join(words.split())) for line in squeezed), (words, doctor.stdout)
        (given_up,) = (line for line in squeezed if line.startswith("cancels_task"))
        assert given_up.endswith("; now given up")
        assert doctor.stdout.endswith("problems found, the worst above\n")
        assert doctor.returncode == 1

        publish_raw(f"127.0.0.1:{run.port}", "home425/lights/roomlights405/in", "on")
        run.until("roomlights405 → off")
    finally:
        code = run.stop()
    assert code == 1, run.text  # it says so: a part was given up
    assert "Traceback" in run.text
    assert "\x1b" not in run.text


def test_an_app_that_does_not_end_is_named_and_left_behind_in_time(tmp_path: Path) -> None:
    run = Run(tmp_path, "--app", f"{MODULE}:ClingsOn", PYTHONPATH=str(ROOT))
    run.until("running the app clings_on")
    assert run.stop(within=CUT_OFF_WITHIN) == 0
    assert "the app clings_on did not end in 3 s: " in run.text
    assert "(run) swallows its cancellation" in run.text


def test_a_signal_ends_it_in_time_also_where_no_handler_of_python_runs(tmp_path: Path) -> None:
    assert EXIT_AFTER < STOPS_WITHIN
    run = Run(tmp_path, "--app", f"{MODULE}:BlocksInC", PYTHONPATH=str(ROOT))
    assert run.end() == 1
    assert "not everything stopped in time; exiting anyway" in run.text


def test_a_log_that_nobody_reads_holds_nobody_up_and_tells_what_is_missing_when_it_is_read_again(
    tmp_path: Path,
) -> None:
    run = Run(tmp_path, "--app", "light_service", "--app", f"{MODULE}:Prints", PYTHONPATH=str(ROOT))
    run.until("roomlights405 → off")
    lost = 0
    while not lost:  # nobody reads the log meanwhile
        done = ask(run, "doctor", "--counts")
        assert done.returncode == 1 or "all is well" in done.stdout
        lost = int(re.findall(r"log lines lost +(\d+)", done.stdout)[0])
    assert ask(run, "devices").returncode == 0
    publish_raw(f"127.0.0.1:{run.port}", "home425/lights/roomlights405/in", "on")
    run.until("lines of the log were lost here, because they were not read in time")
    run.until("nobody reads this either")
    assert run.stop() == 0


def test_a_log_that_nobody_reads_does_not_keep_it_from_ending(tmp_path: Path) -> None:
    run = Run(tmp_path, "--app", f"{MODULE}:Prints", PYTHONPATH=str(ROOT))
    run.until("running the app prints")
    run.process.send_signal(signal.SIGTERM)
    assert own_time_until_end(run.process) < STOPS_WITHIN * slowness()
    assert run.process.wait(120) == 0
    assert run.process.stderr is not None
    run.process.stderr.close()
