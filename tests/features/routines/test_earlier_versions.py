"""Recordings of earlier versions name classes by the modules that they were in."""

from homebot.features.routines.routine import Routine
from homebot.recording.lines import RecordedApp
from homebot.replay.replay_apps import app_tables


def test_a_recorded_routine_is_replayed() -> None:
    recorded = RecordedApp(name="hall", kind="homebot.routines.routine:Routine", settings="{}")
    assert app_tables([recorded], (), {}) == {"hall": {"class": f"{Routine.__module__}:Routine"}}
