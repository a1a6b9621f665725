"""A recorded time again: the same with the same apps, and what a changed app, setting or policy changes."""

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from tests.replay.recorded_days import diff_of, evening_flat, family, recorded, replayed, texts
from tests.sizes import NIGHTLY, nightly, size
from tests.whole_house import WHOLE_HOUSE

import homebot.apps.lights_out
from homebot.config import HomeSettings, parse_config
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.recording.lines import RecordingHeader
from homebot.recording.recording import Recording
from homebot.replay.replay import replay_config

pytestmark = [pytest.mark.slow, pytest.mark.rooms("recording")]

EVERY_APP = ("light_service", "lights_out", "window_heating", "follow_me")
EVENING_APPS = ("lights_out", "follow_me")
NO_TIME = Time(sec=0, nanosec=0)
START, LENGTH = ("2026-01-01", "24h") if NIGHTLY else ("2026-01-01 06:00", "4h")


@pytest.fixture(autouse=True)
def in_utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Texts have times of the computer's zone."""
    with monkeypatch.context() as patch:
        patch.setenv("TZ", "UTC")
        time.tzset()
        yield
    time.tzset()


@pytest.fixture(scope="module")
def evening() -> Recording:
    return recorded(evening_flat(), EVENING_APPS, "2h", start="2026-01-01 18:00")


@WHOLE_HOUSE
@pytest.mark.no_cover
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=nightly)])
def test_the_same_apps_give_the_same_commands_in_a_day_of_the_family_home(seed: int) -> None:
    recording = recorded(family(seed), EVERY_APP, LENGTH, start=START, seed=seed)
    diff = diff_of(recording)
    assert texts(recording, diff) == []
    assert diff.same > size(15, 100)


@WHOLE_HOUSE
def test_a_recording_of_a_run_has_all_of_it(evening: Recording) -> None:
    assert evening.lost == 0
    assert evening.ends_at == pytest.approx(2 * 3600, abs=1)
    assert [one.name for one in evening.header.apps] == list(EVENING_APPS)
    assert all(one.result is not None for one in evening.commands)
    assert {one.command.issuer for one in evening.commands} == {"/lights_out", "/follow_me"}


@WHOLE_HOUSE
def test_the_same_apps_give_the_same_commands(evening: Recording) -> None:
    diff = diff_of(evening)
    assert texts(evening, diff) == []
    assert diff.same == len(evening.commands)


@WHOLE_HOUSE
def test_a_changed_line_is_told_by_exactly_the_commands_that_it_changes(evening: Recording, tmp_path: Path) -> None:
    """The app waits five minutes, and not 21, so its commands come 16 minutes earlier; others stay."""
    source = Path(homebot.apps.lights_out.__file__).read_text("utf-8")
    changed = tmp_path / "my_lights_out.py"
    changed.write_text(source.replace("quiet_after: Seconds = 1260.0", "quiet_after: Seconds = 300.0"))
    assert texts(evening, diff_of(evening, [str(changed)])) == GOLDEN
    assert texts(evening, diff_of(evening, tables={"apps": {"lights_out": {"quiet_after": 300.0}}})) == GOLDEN


GOLDEN = """\
+ 2026-01-01 18:06:06  hall_lamp  off  lights_out, because hall_motion reported clear
- 2026-01-01 18:22:06  hall_lamp  off  lights_out, because hall_motion reported clear
+ 2026-01-01 19:06:05  study_lamp  off  lights_out, because study_motion reported clear
+ 2026-01-01 19:06:10  hall_lamp  off  lights_out, because hall_motion reported clear
- 2026-01-01 19:22:05  study_lamp  off  lights_out, because study_motion reported clear
- 2026-01-01 19:22:10  hall_lamp  off  lights_out, because hall_motion reported clear
+ 2026-01-01 19:36:05  kitchen_lamp  off  lights_out, because kitchen_motion reported clear
+ 2026-01-01 19:36:06  hall_lamp  off  lights_out, because hall_motion reported clear
- 2026-01-01 19:52:05  kitchen_lamp  off  lights_out, because kitchen_motion reported clear
- 2026-01-01 19:52:06  hall_lamp  off  lights_out, because hall_motion reported clear
""".splitlines()


@WHOLE_HOUSE
def test_two_app_files_with_classes_of_one_name_are_replayed_each_in_its_place(
    tmp_path: Path, evening: Recording
) -> None:
    """As `homebot run --app lights_out.py --app follow_me.py` records them, if both call their class MyApp."""
    files = {}
    for name, kind in (("lights_out", "LightsOut"), ("follow_me", "FollowMe")):
        source = Path(homebot.apps.lights_out.__file__).with_name(f"{name}.py").read_text("utf-8")
        files[name] = tmp_path / f"mine_{name}.py"
        files[name].write_text(source.replace(f"class {kind}(", "class MyApp("))
    apps = [one.model_copy(update={"kind": f"mine_{one.name}:MyApp"}) for one in evening.header.apps]
    mine = replace(evening, header=evening.header.model_copy(update={"apps": tuple(apps)}))
    diff = diff_of(mine, [str(files["follow_me"]), str(files["lights_out"])])
    assert texts(mine, diff) == []
    assert diff.same == len(mine.commands)
    changed = files["lights_out"].rename(tmp_path / "changed.py")  # it is in the place of what no other file is
    diff = diff_of(mine, [str(files["follow_me"]), str(changed)])
    assert texts(mine, diff) == []
    with pytest.raises(UsageError, match="changed:MyApp may replace mine_follow_me:MyApp or mine_lights_out"):
        diff_of(mine, [str(changed)])


@WHOLE_HOUSE
def test_a_policy_that_refuses_is_named(evening: Recording) -> None:
    """Quiet hours keep the app from turning lamps on; those that it turned off were never on in truth, and stay."""
    rules = {"quiet_hours": [{"start": "00:00", "end": "23:59", "commands": ["turn on lights"]}]}
    diff = diff_of(evening, tables={"control": rules})
    assert {(one.kind, one.given.command.issuer) for one in diff.different} == {("gone", "/follow_me")}
    assert all(one.refused.startswith("quiet_hours: ") for one in diff.different)
    assert len(diff.different) == sum(one.command.issuer == "/follow_me" for one in evening.commands)


@WHOLE_HOUSE
def test_an_app_that_was_not_recorded_gives_added_commands_which_succeed(evening: Recording) -> None:
    found = replayed(evening, ["homebot.apps.light_service:LightService"])
    assert found.issuers == ("/light_service",)
    diff = diff_of(evening, ["homebot.apps.light_service:LightService"])
    assert {one.kind for one in diff.different} == {"added"}
    assert diff.same == 0


def test_a_replay_is_at_the_place_and_in_the_zone_of_the_recording() -> None:
    """A configuration that is given with it wins, key by key."""
    home = '{"zone": "Europe/Berlin", "latitude": 52.5, "longitude": 13.4}'
    header = RecordingHeader(format=2, version="1", home="villa", started_at=NO_TIME, home_table=home)
    recording = Recording(header)
    assert replay_config(recording).home == HomeSettings(
        name="villa", zone="Europe/Berlin", latitude=52.5, longitude=13.4
    )
    tables: dict[str, object] = {"home": {"zone": "Asia/Tokyo"}, "discovery": {"prefer": ["mqtt"], "max_devices": 9}}
    given = parse_config(tables, "homebot.toml")
    assert replay_config(recording, (), given).discovery == {"max_devices": 9}
    assert replay_config(recording, (), given).home == HomeSettings(
        name="villa", zone="Asia/Tokyo", latitude=52.5, longitude=13.4
    )
