"""What ``homebot run`` makes of its options and of the configuration, without running it."""

import logging
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.patience import PATIENCE
from tests.whole_house import WHOLE_HOUSE

from homebot.cli import main
from homebot.cli.commands.run import configuration
from homebot.cli.main import make_parser
from homebot.cli.serve import Watchdog
from homebot.config import Config
from homebot.errors import ConfigError
from homebot.house import World
from homebot.house.family import dialects
from homebot.runtime.plan import make_plan


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HOMEBOT_DOOR", raising=False)
    monkeypatch.delenv("HOMEBOT_DOOR_TOKEN", raising=False)


def config_of(*arguments: str) -> Config:
    return configuration(make_parser().parse_args(["run", *arguments]))[0]


def has_house(*arguments: str) -> bool:
    return house_of(*arguments) is not None


def house_of(*arguments: str) -> World | None:
    return configuration(make_parser().parse_args(["run", *arguments]))[1]


@WHOLE_HOUSE
def test_without_anything_it_is_the_family_house() -> None:
    config = config_of()
    assert config.home.name == "family"
    assert {*config.apps} == {"follow_me", "lights_out", "window_heating"}
    house = house_of()
    assert house is not None
    assert "kitchen_lamp" in house.devices
    assert house.time.pace == 60.0
    speech = {placed.dialect for placed in house.devices.values()}
    assert speech == {*dialects()}


@pytest.mark.parametrize("option", [("--house", "thesis"), ("--root", "home425")])
def test_the_thesis_house_is_named_or_found_by_its_root(option: tuple[str, str]) -> None:
    config = config_of(*option)
    assert config.home.name == "home425"
    assert config.gateways == {"mqtt": {"root": "home425"}}
    assert config.apps == {"light_service": {}}
    assert has_house(*option)


def test_a_broker_of_your_own_is_no_simulated_house() -> None:
    config = config_of("--mqtt", "mqtt://broker", "--root", "villa", "--act")
    assert config.gateways == {"mqtt": {"url": "mqtt://broker", "root": "villa", "act": True}}
    assert not has_house("--mqtt", "mqtt://broker")


def test_no_app_runs_in_a_real_house_unless_it_is_named() -> None:
    """The light service would switch off every lamp of it."""
    assert config_of("--mqtt", "mqtt://broker", "--root", "villa", "--act").apps == {}
    named = config_of("--mqtt", "mqtt://broker", "--act", "--app", "light_service")
    assert named.apps == {"light_service": {}}
    Path("homebot.toml").write_text('[gateways.mqtt]\nurl = "mqtt://broker"\n')
    assert config_of("--act").apps == {}


def test_devices_are_remembered_unless_they_are_simulated_or_nobody_wants_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    Path("homebot.toml").write_text('[home]\nname = "villa"\n[gateways.mqtt]\n[door]\nport = 0\n')
    assert main(["run", "--for", "0.01", "--ephemeral"]) == 0
    assert not (tmp_path / "data" / "homes").exists()
    assert main(["run", "--for", "0.01"]) == 0
    (file,) = tmp_path.glob("data/homes/*/index.sqlite")
    assert f'id = "{file.parent.name}"' in Path("homebot.toml").read_text()


def test_a_house_of_your_own_comes_in_the_place_of_the_thesis_house() -> None:
    Path("villa.toml").write_text('rooms.hall = {}\ndevices.lamp = { kind = "lamp", room = "hall" }\n')
    house = house_of("--house", "villa.toml")
    assert house is not None
    assert list(house.devices) == ["lamp"]
    Path("homebot.toml").write_text('[gateways.mqtt]\nroot = "villa"\n')
    assert has_house("--house", "villa.toml")


def test_a_house_is_on_a_broker_of_your_own_only_if_the_command_line_names_both(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Real devices are there, perhaps: nothing is commanded without ``--act``, and no app runs that is not named."""
    Path("homebot.toml").write_text('[gateways.mqtt]\nurl = "mqtt://127.0.0.1:1"\n')
    assert main(["run", "--house", "thesis"]) == 1
    assert (
        "gateways: none uses the embedded broker; give that of the simulated house by --mqtt" in capsys.readouterr().err
    )
    Path("homebot.toml").unlink()
    named = config_of("--house", "thesis", "--mqtt", "mqtt://broker")
    assert named.gateways == {"mqtt": {"root": "home425", "url": "mqtt://broker"}}
    assert named.apps == {}
    assert has_house("--house", "thesis", "--mqtt", "mqtt://broker")


@WHOLE_HOUSE
def test_an_app_of_the_family_that_is_named_has_its_settings_on_another_broker() -> None:
    config = config_of("--house", "family", "--mqtt", "mqtt://broker", "--act", "--app", "lights_out")
    assert config.gateways["mqtt"] == {"root": "family", "stale_after": "10s", "url": "mqtt://broker", "act": True}
    assert config.apps == {"lights_out": {"quiet_after": "9s"}}


def test_apps_replace_the_default_and_keep_the_house() -> None:
    config = config_of("--app", "my_app:WindowLight", "--app", "light_service")
    assert config.apps == {"window_light": {"class": "my_app:WindowLight"}, "light_service": {}}
    assert has_house("--app", "my_app:WindowLight")


def test_two_classes_of_one_name_are_two_apps_and_one_given_twice_is_one() -> None:
    config = config_of("--app", "a:MyApp", "--app", "b:MyApp", "--app", "a:MyApp")
    assert config.apps == {"my_app": {"class": "a:MyApp"}, "my_app_2": {"class": "b:MyApp"}}


@pytest.mark.parametrize("table", ["mine:Mine", "mine.py:Mine", "./mine.py:Mine"])
def test_an_app_that_the_configuration_names_runs_once_where_its_file_is_named_too(table: str) -> None:
    Path("mine.py").write_text("from homebot import App\n\n\nclass Mine(App):\n    pass\n")
    Path("homebot.toml").write_text(f'[gateways.mqtt]\n[apps.night]\nclass = "{table}"\ncolour = "red"\n')
    expected = {"night": {"class": table, "colour": "red"}}
    assert config_of("--app", "mine.py").apps == config_of("--app", "mine:Mine").apps == expected


def test_an_app_in_a_file_has_the_settings_of_the_table_of_its_name() -> None:
    """As one that is loaded later; where an app of that name is installed, the table is its own."""
    Path("homebot.toml").write_text('[gateways.mqtt]\n[apps.mine]\ncolour = "red"\n[apps.follow_me]\n')
    expected = {"mine": {"class": "a:Mine", "colour": "red"}, "follow_me": {}, "follow_me_2": {"class": "a:FollowMe"}}
    assert config_of("--app", "a:Mine", "--app", "a:FollowMe").apps == expected


def test_a_file_in_the_folder_is_used_and_options_add_to_it() -> None:
    Path("homebot.toml").write_text(
        '[gateways.mqtt]\nurl = "mqtt://broker"\nstale_after = 5.0\n'
        '[apps.mine]\nclass = "my_app:Mine"\ncolour = "red"\n'
    )
    config = config_of("--act", "--app", "my_app:Mine", "--app", "light_service")
    assert config.gateways == {"mqtt": {"url": "mqtt://broker", "stale_after": 5.0, "act": True}}
    assert config.apps == {"mine": {"class": "my_app:Mine", "colour": "red"}, "light_service": {}}
    assert config.source == "homebot.toml and command line"
    assert config_of().source == "homebot.toml"
    assert not has_house()


def test_an_app_of_the_file_keeps_its_settings_when_it_is_named_again() -> None:
    Path("homebot.toml").write_text('[apps.light_service]\ncolour = "red"\n')
    assert config_of("--app", "light_service").apps == {"light_service": {"colour": "red"}}


@WHOLE_HOUSE
def test_the_door_is_where_the_option_says() -> None:
    assert config_of("--door", "127.0.0.1:7").door == {"host": "127.0.0.1", "port": 7}
    assert config_of("--door", "[::1]:7").door == {"host": "::1", "port": 7}
    assert config_of("--door", "ws://[::1]:7/").door == {"host": "::1", "port": 7}
    Path("homebot.toml").write_text("[door]\nport = 8\n")
    assert config_of("--door", "127.0.0.1:7").door == {"host": "127.0.0.1", "port": 7}


@WHOLE_HOUSE
def test_the_door_may_stand_before_the_command() -> None:
    """As it may before any other; it was ignored."""

    def door_of(*line: str) -> object:
        return configuration(make_parser(line).parse_args(line))[0].door

    assert door_of("--door", "127.0.0.1:7", "run") == {"host": "127.0.0.1", "port": 7}
    assert door_of("--door", "127.0.0.1:7", "run", "--door", "127.0.0.1:8") == {"host": "127.0.0.1", "port": 8}


@WHOLE_HOUSE
def test_the_variable_of_clients_does_not_move_a_door_whose_place_the_file_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Somebody who talks to another homebot from this shell starts this one where its file says."""
    monkeypatch.setenv("HOMEBOT_DOOR", "ws://127.0.0.1:7")
    assert config_of().door == {"host": "127.0.0.1", "port": 7}
    Path("homebot.toml").write_text('[door]\nscope = ["read"]\n')
    assert config_of().door == {"scope": ["read"], "host": "127.0.0.1", "port": 7}
    Path("homebot.toml").write_text("[door]\nport = 8\n")
    assert config_of().door == {"port": 8}
    Path("homebot.toml").write_text('[door]\nhost = "::1"\n')
    assert config_of().door == {"host": "::1"}


@WHOLE_HOUSE
def test_the_token_of_the_environment_counts_where_the_file_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", "hunter2")
    assert config_of().door == {"token": "hunter2"}
    Path("homebot.toml").write_text('[door]\ntoken_file = "token"\n')
    assert config_of().door == {"token_file": "token"}
    Path("homebot.toml").write_text('[door]\ntoken = "other"\n')
    assert config_of().door == {"token": "other"}
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", "")
    Path("homebot.toml").write_text("")
    assert config_of().door == {}


@pytest.mark.parametrize("given", ["apps/my-app.py", "apps/my-app.py:WindowLight"])
def test_an_app_in_a_file_is_named_by_the_file_as_for_a_replay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: str
) -> None:
    """As are its neighbours, which it imports."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "apps").mkdir()
    (tmp_path / "apps" / "neighbour_of_the_file.py").write_text("from homebot import App\n")
    (tmp_path / "apps" / "my-app.py").write_text(
        "from neighbour_of_the_file import App\n\n\nclass WindowLight(App):\n    async def run(self):\n        pass\n"
    )
    assert config_of("--app", given).apps == {"window_light": {"class": "apps/my-app.py:WindowLight"}}
    (app,) = make_plan(config_of("--app", given)).apps
    assert (app.name, app.kind.__qualname__) == ("window_light", "WindowLight")


def test_an_app_whose_class_makes_no_legal_node_name_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"command line: apps\.küche: "):
        config_of("--app", "my_app:Küche")


@pytest.mark.rooms("thesis")
@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--config", "missing.toml"], "homebot: missing.toml does not exist\n"),
        (["--house", "villa.toml"], "homebot: villa.toml does not exist\n"),
        (["--config", "."], "homebot: . cannot be read: Is a directory\n"),
        (["--app", "nosuch"], "homebot: command line: apps.nosuch: plug-in 'nosuch' is not installed (installed: "),
        (["--app", "json:JSONDecoder"], "apps.jsondecoder.class: json:JSONDecoder is not an App; derive it from"),
        (
            ["--app", "json:Nope"],
            "apps.nope.class: plug-in 'json:Nope' cannot be loaded: the module 'json' has no 'Nope'\n",
        ),
        (
            ["--app", "nosuch:App"],
            "apps.app.class: plug-in 'nosuch:App' cannot be loaded: the module 'nosuch' cannot be imported: Mod",
        ),
        (["--app", "nosuch.py"], "homebot: plug-in 'nosuch.py' cannot be loaded: there is no file nosuch.py\n"),
        (["--mqtt", "http://broker"], "homebot: command line: gateways.mqtt.url: MQTT address: it must start with m"),
        (["--root", "a/+"], "homebot: command line: gateways.mqtt.root: "),
        (["--door", "192.0.2.1:7"], "door.host: 192.0.2.1 can be reached by others, so it needs a token: give token_f"),
    ],
)
def test_what_cannot_be_run_is_one_clear_sentence(
    capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    assert main(["run", *arguments]) == 1
    err = capsys.readouterr().err
    assert problem in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--app", "my_app:"], "an app is a plug-in's name, module:Class, FILE.py or FILE.py:Class, got 'my_app:'"),
        (["--app", "my-app:App"], "got 'my-app:App'"),
        (["--app", ""], "got ''"),
        (["--app", "apps/light.txt"], "module:Class, FILE.py or FILE.py:Class, got 'apps/light.txt'"),
        (["--app", "my_app.py:"], "got 'my_app.py:'"),
        (["--for", "0"], "must be above 0, got '0'"),
        (["--for", "soon"], "'soon' is not a duration; write it like 90s, 8h or 1h30m (d, h, m, s, ms)"),
        (
            ["--door", "ws://127.0.0.1:9090/a"],
            "the door is HOST:PORT, ws:// or wss://HOST:PORT, got 'ws://127.0.0.1:9090/a'",
        ),
        (
            ["--door", "http://127.0.0.1:9090"],
            "the door is HOST:PORT, ws:// or wss://HOST:PORT, got 'http://127.0.0.1:9090'",
        ),
        (["--door", "ws://a:secret@127.0.0.1:9090"], "HOST:PORT, such as 127.0.0.1:9090 or [::1]:9090, got '…@127"),
        (
            ["--door", "ws://127.0.0.1"],
            "an address is HOST:PORT, such as 127.0.0.1:9090 or [::1]:9090, got '127.0.0.1'",
        ),
        (["--door", "127.0.0.1:9090/"], "an address is HOST:PORT"),
        (["--door", "[::1:9090"], "an address is HOST:PORT"),
        (["--door", "a:b:9090"], "an address is HOST:PORT"),
        (["--door", "99999"], "an address is HOST:PORT, such as 127.0.0.1:9090 or [::1]:9090, got '127.0.0.1:99999'"),
        (["--log-format", "xml"], "invalid choice: 'xml'"),
    ],
)
def test_a_wrong_option_is_a_matter_of_usage(
    capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["run", *arguments])
    assert caught.value.code == 2
    assert problem in capsys.readouterr().err


def test_a_service_with_wrong_tables_ends_for_good_and_names_all_mistakes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It ended with 1, so systemd started it for ever, and named the first."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOMEBOT_SERVICE", "1")
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\nulr = 1\n[apps.lights_out]\nquiet = 3\n")
    assert main(["run"]) == 2
    problems = capsys.readouterr().err.splitlines()
    assert [one.split(": ")[2] for one in problems] == ["gateways.mqtt.ulr", "apps.lights_out.quiet"]


def test_a_watchdog_that_was_not_needed_leaves_no_thread() -> None:
    with Watchdog() as watchdog:
        watchdog.start()
        watchdog.start()
    for thread in watchdog._threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    with Watchdog():
        pass


SIGNALLING_APP = """
import os
import signal
from homebot.apps import App


class Signalling(App):
    async def run(self) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
"""


@pytest.fixture
def _logging_as_before() -> Iterator[None]:
    root = logging.getLogger()
    handlers = list(root.handlers)
    yield
    root.handlers[:] = handlers
    logging.captureWarnings(capture=False)


@pytest.mark.usefixtures("_logging_as_before")
def test_it_runs_for_the_time_it_is_given(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--house", "thesis", "--for", "0.2", "--door", "127.0.0.1:0"]) == 0
    assert "home425 is running" in capsys.readouterr().err


@pytest.mark.usefixtures("_logging_as_before")
def test_a_signal_that_comes_during_the_start_stops_it_at_once_and_the_handlers_are_as_before(
    capsys: pytest.CaptureFixture[str],
) -> None:
    before = signal.getsignal(signal.SIGTERM)
    Path("my_signalling_app.py").write_text(SIGNALLING_APP)
    assert main(["run", "--app", "my_signalling_app:Signalling", "--door", "127.0.0.1:0"]) == 0
    err = capsys.readouterr().err
    assert "stopping" in err
    assert "Traceback" not in err
    assert signal.getsignal(signal.SIGTERM) is before


def test_the_interpreter_does_not_look_for_garbage_in_a_whole_house_as_it_ends(tmp_path: Path) -> None:
    """That would take three seconds for 1,500 devices, in which whoever stops homebot kills it."""
    (tmp_path / "empty.toml").write_text('[home]\nname = "villa"\n')
    code = """
import atexit, gc, sys
atexit.register(lambda: print("frozen" if gc.get_freeze_count() else "not frozen"))
from homebot.cli import main
sys.exit(main())
"""
    options = ("run", "--config", "empty.toml", "--ephemeral", "--door", "127.0.0.1:0", "--for", "0.01")
    done = subprocess.run(
        [sys.executable, "-c", code, *options], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=120
    )
    assert done.stdout.splitlines()[-1] == "frozen"
