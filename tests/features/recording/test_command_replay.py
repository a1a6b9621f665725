"""What `homebot replay` says of a file that it cannot use: one sentence, and the exit code 2."""

import gzip
from pathlib import Path

import pytest

from homebot.cli import main
from homebot.messages import Time
from homebot.recording.lines import LostLines, RecordedApp, RecordingEnd, RecordingHeader, RecordingLine, line_text

HEADER = RecordingHeader(format=2, version="1", home="home", started_at=Time(sec=1_767_225_600, nanosec=0))
WHOLE = "".join(
    f"{line_text(RecordingLine(at, message))}\n"
    for at, message in ((0.0, HEADER), (1.0, LostLines(count=0)), (2.0, RecordingEnd()))
).encode()
ENDS_EARLY = "homebot: the recording ends early: "
CUT = "ends in the middle of a line: the copy is incomplete, or homebot was killed while it wrote; "
REPAIRED = "head -n 2 > whole.jsonl` keeps the complete lines"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def damaged(compressed: bytes) -> bytes:
    """*compressed* with another byte in its middle."""
    middle = len(compressed) // 2
    return compressed[:middle] + bytes([compressed[middle] ^ 0xFF]) + compressed[middle + 1 :]


CASES: dict[str, tuple[str, bytes | None, str]] = {
    "missing": ("day", None, "day cannot be read: No such file or directory"),
    "empty": ("day", b"", "day is empty, and not a recording"),
    "toml": ("day", b"[home]\n", "day is not a recording: its first line is no header"),
    "binary": ("day", b"\xff\xfe\n", "day is not a recording: its first line is no header"),
    "quotes": ("day", b"{'recording'}\n", "day is not a recording: its first line is no header"),
    "object": ("day", b"{}\n", "day is not a recording: its first line is no header; `homebot record` makes one"),
    "json": (
        "day",
        b'{"recording": 1}\n',
        "day, line 1: must be a JSON object with the fields 'at', 'kind' and 'message'",
    ),
    "bytes": ("day", WHOLE.replace(b"home", b"\xff"), "day, line 1: is not UTF-8 text"),
    "brace": ("day", WHOLE.replace(b"}\n", b"\n"), "day, line 1: is not JSON: Expecting ',' delimiter at character"),
    "newer": (
        "day",
        WHOLE.replace(b'"format":2', b'"format":3'),
        "field 'message.format': is 3, but this homebot reads up to 2: replay it with a newer homebot",
    ),
    "century": (
        "day",
        WHOLE.replace(b'"at":1.000000', b'"at":3000000000.0'),
        "day, line 2: field 'at': must be a number of seconds within 366 days, got '3000000000.0'",
    ),
    "cut": ("day", WHOLE[:-3], f"day {CUT}`cat day | {REPAIRED}"),
    "line": ("day", WHOLE.replace(b'"count"', b'"cuont"'), "day, line 2: field 'message': "),
    "plain": ("day.gz", WHOLE, "day.gz is damaged, or not compressed, and its name ends in .gz"),
    "cut_gz": ("day.gz", gzip.compress(WHOLE)[:-1], f"day.gz {CUT}`zcat day.gz | head -n 3 > whole.jsonl`"),
    "damaged_gz": ("day.gz", damaged(gzip.compress(WHOLE * 1000)), "day.gz"),
}


@pytest.mark.parametrize(
    ("name", "content", "said"),
    CASES.values(),
    ids=CASES,
)
def test_a_file_that_is_no_whole_recording_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], name: str, content: bytes | None, said: str
) -> None:
    if content is not None:
        (folder / name).write_bytes(content)
    assert main(["replay", name, "--diff"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("homebot: ")
    assert said in err
    assert err.count("\n") == 1


def test_a_recording_without_its_end_is_replayed_and_said_to_end_early(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "whole").write_bytes(WHOLE)
    assert main(["replay", "whole", "--diff"]) == 0
    assert capsys.readouterr() == ("no difference: 0 commands are the same\n", "")
    (folder / "cut").write_bytes(b"".join(WHOLE.splitlines(keepends=True)[:2]))
    assert main(["replay", "cut", "--diff"]) == 0
    assert capsys.readouterr().err == f"{ENDS_EARLY}homebot or the recorder stopped before its end\n"


@pytest.mark.parametrize(("options", "said"), [([], "; --log shows where\n"), (["--log"], "\n")])
def test_the_app_that_crashes_is_told_and_how_to_see_where(
    folder: Path, capsys: pytest.CaptureFixture[str], options: list[str], said: str
) -> None:
    (folder / "day").write_bytes(WHOLE)
    (folder / "mine.py").write_text(
        "from homebot import App\n\n\nclass Mine(App):\n    async def run(self):\n        raise ValueError('odd')\n"
    )
    assert main(["replay", "day", "--app", "mine.py", *options]) == 0
    assert f"homebot: mine crashed: ValueError: odd{said}" in capsys.readouterr().err


def recording_of(app: RecordedApp) -> bytes:
    """A whole recording of a run of *app*."""
    header = line_text(RecordingLine(0, HEADER.model_copy(update={"apps": (app,)}))).encode()
    return b"\n".join([header, *WHOLE.split(b"\n")[1:]])


@pytest.mark.parametrize(
    "kind",
    [
        "./evil.py:Evil",
        "evil:Evil",
        "homebot.replay.replay_gateway:ReplayGateway",
        "homebot.apps.light_service:App",
        "light_service",
    ],
)
def test_code_that_a_recording_names_is_not_run(folder: Path, capsys: pytest.CaptureFixture[str], kind: str) -> None:
    """Of its classes only the apps of installed plug-ins are loaded; others are run if the user names them."""
    (folder / "evil.py").write_text(
        "from pathlib import Path\n\nfrom homebot import App\n\nPath('was_run').touch()\n\n\n"
        "class Evil(App):\n    async def run(self):\n        pass\n"
    )
    (folder / "day").write_bytes(recording_of(RecordedApp(name="evil", kind=kind)))
    assert main(["replay", "day", "--diff"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"runs no code that only a recording names: evil ({kind}); name each" in err
    assert not (folder / "was_run").exists()
    assert main(["replay", "day", "--app", "evil.py", "--diff"]) == 0
    assert (folder / "was_run").exists()


def test_a_recording_of_an_installed_app_is_replayed_as_it_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    app = RecordedApp(name="mine", kind="homebot.apps.light_service:LightService")
    (folder / "day").write_bytes(recording_of(app))
    assert main(["replay", "day", "--diff"]) == 0
    assert capsys.readouterr() == ("no difference: 0 commands are the same\n", "")
    assert main(["replay", "day"]) == 0
    assert capsys.readouterr() == ("", "homebot: no app gave a command; --app names another\n")


def test_an_older_format_and_fields_of_a_newer_homebot_are_read(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Format 1 is format 2 without three kinds of lines."""
    (folder / "old").write_bytes(WHOLE.replace(b'"format":2', b'"format":1'))
    (folder / "new").write_bytes(
        WHOLE.replace(b'"count"', b'"newer":{"a":[1]},"count"').replace(b'"at"', b'"by":1,"at"')
    )
    for name in ("old", "new"):
        assert main(["replay", name, "--diff"]) == 0
        assert capsys.readouterr() == ("no difference: 0 commands are the same\n", "")
