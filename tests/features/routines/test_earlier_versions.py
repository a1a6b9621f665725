"""Recordings and exported apps of earlier versions name classes by the modules that they were in."""

from homebot.features.routines.routine import Routine
from homebot.features.routines.routine_app import RoutineApp
from homebot.recording.lines import RecordedApp
from homebot.replay.replay_apps import app_tables
from homebot.routines import routine_app


def test_a_recorded_routine_is_replayed_and_an_exported_app_finds_its_base() -> None:
    recorded = RecordedApp(name="hall", kind="homebot.routines.routine:Routine", settings="{}")
    assert app_tables([recorded], (), {}) == {"hall": {"class": f"{Routine.__module__}:Routine"}}
    assert routine_app.RoutineApp is RoutineApp
