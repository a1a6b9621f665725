"""What the command line says of options and commands that do not exist."""

import json

import pytest

from homebot.cli import main

Text = pytest.CaptureFixture[str]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("--verison", "homebot: unknown option --verison; did you mean --version?"),
        ("devices --jsno", "homebot devices: unknown option --jsno; did you mean --json?"),
        ("run --fro 2", "homebot run: unknown option --fro; did you mean --for?"),
        ("run --fro=2", "homebot run: unknown option --fro; did you mean --for?"),
        ("topic echo --onec /hello", "homebot topic echo: unknown option --onec; did you mean --once?"),
        ("topic list -x", "homebot topic list: unknown option -x; see `homebot topic list --help`"),
        ("devices extra", "homebot devices: unexpected argument 'extra'; see `homebot devices --help`"),
        ("device", "homebot: no command 'device'; did you mean devices?"),
        ("devcies", "homebot: no command 'devcies'; did you mean devices?"),
        ("lst", "homebot: no command 'lst'; did you mean devices?"),
        ("topic lst", "homebot topic: no command 'lst'; did you mean list?"),
        ("frobnicate", "homebot: no command 'frobnicate'; see `homebot --help`"),
    ],
)
def test_a_misspelt_command_or_option_is_named_with_what_was_meant(capsys: Text, line: str, problem: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(line.split())
    assert ended.value.code == 2
    assert capsys.readouterr() == ("", f"{problem}\n")


@pytest.mark.parametrize(("line", "shown"), [("", "homebot run "), ("topic", "homebot topic echo ")])
def test_without_a_command_the_help_is_shown(capsys: Text, line: str, shown: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(line.split())
    assert ended.value.code == 2
    out, err = capsys.readouterr()
    assert shown in out
    assert err == ""


@pytest.mark.parametrize(("word", "meant"), [("list", "devices"), ("status", "doctor"), ("log", "journal")])
def test_a_word_of_other_tools_is_understood(word: str, meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([word])
    assert f"no command '{word}'; did you mean {meant}?" in capsys.readouterr().err


def test_other_mistakes_are_shown_with_the_usage(capsys: Text) -> None:
    with pytest.raises(SystemExit):
        main(["show"])
    assert capsys.readouterr().err.endswith("homebot show: error: the following arguments are required: DEVICE\n")


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("identify light --seconds 0", "argument --seconds: must be from 5 to 600 seconds, got '0'\n"),
        ("verify lamp --seconds 11m", "argument --seconds: must be from 5 to 600 seconds, got '11m'\n"),
    ],
)
@pytest.mark.rooms("identify")
def test_a_number_out_of_range_is_refused_with_the_range(capsys: Text, line: str, problem: str) -> None:
    with pytest.raises(SystemExit):
        main(line.split())
    assert capsys.readouterr().err.endswith(problem)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (
            "--door 127.0.0.1:7 broker",
            "--door is for commands that connect to a running homebot; `homebot broker` does not",
        ),
        (
            "--door 127.0.0.1:7 config check",
            "--door is for commands that connect to a running homebot; `homebot config check` does not",
        ),
        (
            "--token-file token run",
            "--token-file is for commands that connect to a running homebot; `homebot run` does not; "
            "the configuration file has the tokens of its clients",
        ),
    ],
)
def test_an_option_that_the_command_does_not_use_is_refused(capsys: Text, line: str, problem: str) -> None:
    assert main(line.split()) == 2
    assert capsys.readouterr() == ("", f"homebot: {problem}\n")


def test_a_wrong_address_in_the_environment_is_told_as_such(capsys: Text, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was told as a wrong `--door`, which nobody had given."""
    monkeypatch.setenv("HOMEBOT_DOOR", "nowhere")
    assert main(["devices"]) == 1
    assert capsys.readouterr().err.startswith("homebot: environment: HOMEBOT_DOOR: an address is HOST:PORT")


@pytest.mark.parametrize(
    ("command", "extra", "modules"), [("mcp --door 9", "mcp", "mcp"), ("bag info day", "mcap", "mcap, yaml, zstandard")]
)
def test_without_the_extra_the_command_that_installs_it_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: str, extra: str, modules: str
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert main(command.split()) == 1
    told = f'homebot {command.split(maxsplit=1)[0]} needs {modules}; install it with: pip install "homebot[{extra}]"'
    assert capsys.readouterr().err == f"homebot: {told}\n"


@pytest.mark.parametrize(
    ("line", "code", "problem"),
    [
        ("devices --jsno --json", 2, "unknown option --jsno; did you mean --json?"),
        ("devcies --json", 2, "no command 'devcies'; did you mean devices?"),
        ("show --json", 2, "the following arguments are required: DEVICE"),
        ("devices --json --door localhost", 2, "argument --door: an address is HOST:PORT, such as 127.0.0.1:9090 …"),
        ("--door 127.0.0.1:1 replay x --json", 2, "--door is for commands that connect to a running homebot; …"),
        ("devices --json --door 127.0.0.1:1", 1, "no homebot is running on 127.0.0.1:1; start one with …"),
    ],
)
def test_under_json_an_error_is_an_object(capsys: Text, line: str, code: int, problem: str) -> None:
    try:
        ended = main(line.split())
    except SystemExit as exc:
        ended = int(str(exc.code))
    out, err = capsys.readouterr()
    said = json.loads(err)
    assert (ended, out, list(said)) == (code, "", ["error"])
    assert said["error"].startswith(problem.removesuffix("…"))
