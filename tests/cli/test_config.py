"""``homebot config check``: what it prints of a good file, and what it finds in a bad one before anything runs."""

import re
from pathlib import Path

import pytest

from homebot.cli import main

Text = pytest.CaptureFixture[str]

VILLA = """
[home]
name = "villa"

[gateways.mqtt]
url = "mqtt://broker.example"
user = "robot"
password_file = "password"

[gateways.garage]
class = "mqtt"
root = "garage"
act = true

[apps.light_service]

[door]
host = "0.0.0.0"
port = 9191
token_file = "token"
"""

GOLDEN = """\
homebot.toml is valid: home villa
  gateways:  mqtt (observing only), garage
  apps:      light_service
  rosbridge: 0.0.0.0:9191 (token required)
"""


def secret(name: str, content: bytes) -> None:
    Path(name).touch(mode=0o600)
    Path(name).write_bytes(content)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HOMEBOT_DOOR_TOKEN", raising=False)
    secret("password", b"s3cret\n")
    secret("token", b"hunter2\n")


def test_a_router_for_robots_is_told_with_who_may_log_in_and_what_is_missing(capsys: Text) -> None:
    token = '[door.tokens.rosie]\ntoken_file = "token"\nscope = ["robot: rosie"]\n'
    Path("homebot.toml").write_text(f'[ros]\nlisten = "tcp/127.0.0.1:7447"\n{token}')
    assert main(["config", "check"]) == 0
    users, nobody, rosie = capsys.readouterr().out.splitlines()[-3:]
    assert users == "  ROS 2:     tcp/127.0.0.1:7447; may log in: none"
    assert nobody.lstrip().startswith("no robot may log in at tcp/127.0.0.1:7447; that takes import = {NAME")
    assert rosie.lstrip() == "the token rosie is no login at tcp/127.0.0.1:7447: import of [ros] names no rosie"
    assert main(["doctor", "--offline"]) == 0
    assert "import of [ros] names no rosie" in capsys.readouterr().out


def test_a_good_file_is_told_in_four_lines(capsys: Text) -> None:
    Path("homebot.toml").write_text(VILLA)
    assert main(["config", "check"]) == 0
    assert capsys.readouterr().out == GOLDEN


@pytest.mark.parametrize("words", [("villa.toml",), ("--config", "villa.toml")])
def test_another_file_is_named_as_a_word_or_an_option(words: tuple[str, ...], capsys: Text) -> None:
    Path("villa.toml").write_text(VILLA)
    assert main(["config", "check", *words]) == 0
    assert capsys.readouterr().out == GOLDEN.replace("homebot.toml", "villa.toml")


def test_an_empty_file_is_a_home_with_nothing_in_it(capsys: Text) -> None:
    Path("empty.toml").write_text("")
    assert main(["config", "check", "--config", "empty.toml"]) == 0
    assert capsys.readouterr().out == (
        "empty.toml is valid: home home\n  gateways:  none\n  apps:      none\n  rosbridge: 127.0.0.1:9090\n"
    )


def test_the_address_is_that_of_the_environment_where_the_file_has_none(
    capsys: Text, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOMEBOT_DOOR", "127.0.0.1:9191")
    for text, port in (("", 9191), ("[door]\nport = 9292\n", 9292)):
        Path("homebot.toml").write_text(text)
        assert main(["config", "check"]) == 0
        assert f"  rosbridge: 127.0.0.1:{port}\n" in capsys.readouterr().out


def test_the_token_of_the_environment_counts_here_too(capsys: Text, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("homebot.toml").write_text('[door]\nhost = "0.0.0.0"\n')
    assert main(["config", "check"]) == 1
    assert "homebot.toml:2: door.host: 0.0.0.0 can be reached by others" in capsys.readouterr().err
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", "hunter2")
    assert main(["config", "check"]) == 0
    out = capsys.readouterr().out
    assert "token required" in out
    assert "hunter2" not in out


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[gateways.mqtt]\nstale_after = inf\n", "gateways.mqtt.stale_after: input should be a finite number, got inf"),
        (
            "[gateways.mqtt]\nclass = 5\n",
            "gateways.mqtt.class: must be a text, module:Class or a plug-in's name, got 5",
        ),
        ("[gateways.zigbee]\n", "gateways.zigbee: plug-in 'zigbee' is not installed (installed: "),
        ('[door]\nport = "9090"\n', "door.port: must be a whole number, without quotes, got '9090'"),
        (
            '[[control.quiet_hours]]\nstart = "22"\nend = "07:00"\ncommands = []\n',
            "control.quiet_hours.0.start: must be a time of day such as 07:00, got '22'",
        ),
        ("[control.rate_limit]\nchange = 5\n", "control.rate_limit.change: unknown key; did you mean changes?"),
        (
            '[gateways.m]\nclass = "json:JSONDecoder"\n',
            "gateways.m.class: json:JSONDecoder is not a Gateway; derive it",
        ),
        (
            '[gateways.mqtt]\n\n[discovery]\nprefer = ["mqqt"]\n',
            "discovery.prefer: there is no gateway 'mqqt'; did you mean mqtt?",
        ),
        (
            '[gateways.mqtt]\nconventions = ["knx"]\n',
            "gateways.mqtt: plug-in 'knx' is not installed (installed: ",
        ),
        (
            '[gateways.mqtt]\nurl = "mqtt://b"\nuser = "a"\npassword_file = "none"\n',
            "gateways.mqtt: password_file: none cannot be read: No such file or directory",
        ),
        (
            '[gateways.mqtt]\nurl = "mqtts://b"\nca_file = "none.pem"\n',
            "gateways.mqtt: ca_file: none.pem cannot be read: No such file or directory",
        ),
        ('[gateways.mqtt]\nurl = "mqtt://b"\nca_file = "token"\n', "gateways.mqtt: MQTT options: CA file and client"),
        ("[apps.discovery]\n", "apps.discovery: is the name of one of homebot's own nodes; choose another name"),
        ('[apps.mine]\nclass = "homebot.apps:App"\n', "apps.mine.class: homebot.apps:App lacks run()"),
        ('[apps.mine]\nclass = "my_odd_app:Odd"\n', "apps.mine.class: my_odd_app:Odd.Settings is not a pydantic model"),
        ("[apps.light_service]\ncolour = 1\n", "apps.light_service.colour: unknown key; known are none"),
        ('[door]\ntoken = "a"\ntoken_file = "token"\n', "door: give token or token_file, not both"),
        ('[door]\ntoken_file = "none"\n', "door.token_file: none cannot be read: No such file or directory"),
        ('[door]\ntoken_file = "empty"\n', "door.token_file: the first line of empty is empty"),
        ('[door]\ntoken_file = "binary"\n', "door.token_file: binary cannot be read: it is not UTF-8 text"),
        (
            '[door]\nhost = "127.0.0.1:9090"\n',
            "door.host: '127.0.0.1:9090' is no name or address; its",
        ),
        (
            '[door]\nallowed_origins = ["house.example"]\n',
            "door.allowed_origins: 'house.example' is no origin; write it like https://house.example",
        ),
        ('[door]\ntoken = ""\n', "door.token: value should have at least 1 item after validation, not 0"),
        ("[thing_directory]\n", "thing_directory: is gone; programs read and command the devices at the door"),
        (
            "[control]\nrate_limit = 5\n",
            "control.rate_limit: must be true, false or a table such as {changes = 30, seconds = 10}, got 5",
        ),
        (
            '[control]\npresence_guard = ["hall"]\n',
            "control.presence_guard: must be true, false or a table such as {absent_after = 1200}, got ['hall']",
        ),
        ("[control]\nwitnesses = 5\n", "control.witnesses: must be a table, as in [control.witnesses], got 5"),
        ("[control]\ninterlocks = [5]\n", "control.interlocks.0: must be a table, as in [[control.interlocks]], got 5"),
        (
            '[control.quiet_hours]\nend = "9:00"\n',
            "control.quiet_hours: must be an array of tables, each as in [[control.quiet_hours]], got {'end': '9:00'}",
        ),
        ('[apps.follow_me]\nrooms = "hall"\n', "apps.follow_me.rooms: must be an array, got 'hall'"),
        ("[places.devices]\n5 = 7\n", "places.devices.5: must be a table, as in [places.devices.5], got 7"),
        ('[places.devices]\n"Hall lamp" = 7\n', "places.devices.Hall lamp: must be a table, got 7"),
        ("[door]\nport = -1\n", "door.port: input should be greater than or equal to 0, got -1"),
    ],
)
def test_a_mistake_is_told_with_file_key_and_reason(capsys: Text, text: str, problem: str) -> None:
    secret("empty", b"\n")
    secret("binary", b"\xff")
    Path("my_odd_app.py").write_text(
        "from homebot.apps import App\n\nclass Odd(App):\n    Settings = dict\n    async def run(self): ...\n"
    )
    Path("homebot.toml").write_text(text)
    assert main(["config", "check"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.sub(r"toml:\d+:", "toml:", captured.err).startswith(f"homebot: homebot.toml: {problem}")
    assert captured.err.count("\n") == 1


def test_relative_paths_begin_at_the_folder_of_the_file(
    capsys: Text, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    Path("homebot.toml").write_text(VILLA)
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert main(["config", "check", "--config", "../homebot.toml"]) == 0
    Path("homebot.toml").write_text('[door]\ntoken_file = "token"\n')
    monkeypatch.chdir(tmp_path)
    assert main(["config", "check", "--config", "elsewhere/homebot.toml"]) == 1
    assert "door.token_file: elsewhere/token cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("mode", "code", "said"),
    [
        (0o600, 0, ""),
        (0o400, 0, ""),
        (0o644, 0, "token can be read by others; keep it to yourself: chmod 600 'token'"),
        (0o602, 1, "token can be written by others; keep it to yourself: chmod 600 'token'"),
    ],
)
def test_a_secret_that_others_can_change_is_refused_and_one_they_can_see_is_told(
    capsys: Text, mode: int, code: int, said: str
) -> None:
    """And it is said how to keep it to oneself; the secret is not."""
    Path("homebot.toml").write_text('[door]\ntoken_file = "token"\n')
    Path("token").chmod(mode)
    assert main(["config", "check"]) == code
    error = capsys.readouterr().err
    assert said in error
    assert error.count("chmod") == (1 if said else 0)  # the file is read to check it, and again to plan the run
    assert "hunter2" not in error


@pytest.mark.parametrize("place", ["homebot.toml", "."])
def test_a_configuration_that_others_can_change_is_refused(capsys: Text, place: str) -> None:
    Path("homebot.toml").write_text('[apps.mine]\nclass = "my_own_app:Mine"\n')
    Path("my_own_app.py").write_text("raise SystemExit('this was run')\n")
    Path(place).chmod(0o777)
    assert main(["config", "check"]) == 1
    error = capsys.readouterr().err
    assert "names the code that runs, so others must not be able to change it" in error
    assert "chmod go-w" in error
    assert "this was run" not in error


@pytest.mark.parametrize("place", [".", "my_own_app.py"])
def test_code_that_others_can_change_is_refused(
    capsys: Text, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    """From the working directory; the configuration may be anywhere."""
    (tmp_path / "code").mkdir()
    Path("homebot.toml").write_text('[apps.mine]\nclass = "my_own_app:Mine"\n')
    monkeypatch.chdir(tmp_path / "code")
    Path("my_own_app.py").write_text("raise SystemExit('this was run')\n")
    Path(place).chmod(0o777)
    assert main(["config", "check", "--config", "../homebot.toml"]) == 1
    error = capsys.readouterr().err
    assert "my_own_app:Mine' is not loaded from the working directory" in error
    assert "this was run" not in error


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[door]\nport = " + "9" * 5000 + "\n", "is invalid TOML: Exceeds the limit"),
        ("[door]\nport = " + "9" * 50 + "\n", "door.port: is a number of more than 64 bits"),
        ('[home]\nname = "a\\u0000b"\n', "home.name: contains the character U+0000, which is not allowed"),
        ('[door]\ntoken_file = "a\\u0000b"\n', "door.token_file: contains the character U+0000"),
        ('[apps."a\\u0000b"]\n', "apps.a\\u0000b: has the character U+0000 in its name"),
        (
            '[gateways.mqtt]\nconventions = ["a\\u0000b"]\n',
            "gateways.mqtt.conventions.0: contains the character U+0000",
        ),
        ("a = " + "[" * 5000, "is no"),
    ],
)
@pytest.mark.parametrize("command", [("config", "check", "--config"), ("run", "--for", "0.01", "--house")])
def test_what_no_configuration_can_hold_is_told_in_one_sentence(
    capsys: Text, text: str, problem: str, command: tuple[str, ...]
) -> None:
    Path("odd.toml").write_text(text)
    assert main([*command, "odd.toml"]) == 1
    error = re.sub(r"toml:\d+:", "toml:", capsys.readouterr().err)
    assert (
        error.startswith((f"homebot: odd.toml: {problem}", f"homebot: odd.toml {problem}"))
        or "is nested too deep" in error
    )
    assert error.count("\n") == 1
    assert len(error) < 500


def test_a_byte_order_mark_is_no_mistake(capsys: Text) -> None:
    """Some editors write one."""
    Path("homebot.toml").write_bytes(b'\xef\xbb\xbf[home]\nname = "villa"\n')
    assert main(["config", "check"]) == 0
    assert "home villa" in capsys.readouterr().out


def test_all_mistakes_are_told_at_once(capsys: Text) -> None:
    Path("homebot.toml").write_text(
        """
        [hoome]
        [home]
        nmae = "villa"
        [gateways.mqtt]
        url = "broker"
        act = "yes"
        root = "#"
        [apps.light_servce]
        [door]
        port = -1
        """
    )
    assert main(["config", "check"]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert [line.removeprefix("homebot: homebot.toml:").split(": ")[:2] for line in lines] == [
        ["4", "home.nmae"],
        ["2", "hoome"],
        ["11", "door.port"],
        ["6", "gateways.mqtt.url"],
        ["8", "gateways.mqtt.root"],
        ["7", "gateways.mqtt.act"],
        ["9", "apps.light_servce"],
    ]
    assert lines[0].endswith("unknown key; did you mean name or zone?")
    assert lines[1].endswith("unknown key; did you mean home?")
    assert "must not contain '#' or '+'" in lines[4]
    assert lines[6].endswith("did you mean light_service?")


def test_one_mistake_is_told_once(capsys: Text) -> None:
    Path("homebot.toml").write_text("home = " + "[" * 300 + "]" * 300 + "\n")
    assert main(["config", "check"]) == 1
    assert capsys.readouterr().err.count("\n") == 1
