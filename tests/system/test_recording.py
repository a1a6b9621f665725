"""A recording of a running homebot, its replay, and a dry run; the commands are those of docs/replay.md."""

import json
import re
import shlex
import signal
from pathlib import Path

from tests.guide import commands_in, guide
from tests.patience import PATIENCE
from tests.shell import Homebot, homebot_in

import homebot.apps.light_service

GUIDE = guide("replay")
COMMANDS = commands_in(GUIDE)
RUNS_HERE = [
    "homebot record day.jsonl.gz --for 86400",
    "homebot replay day.jsonl.gz --diff",
    "homebot replay day.jsonl.gz --app my_lights_out.py --diff",
    "homebot run --config homebot.toml --dry-run",
]
LAMP = "roomlights405"


def kinds(shell: Homebot, command: str) -> list[tuple[str, str]]:
    """What a command with --json says of each difference: which it is, and of which device."""
    done = shell.run(f"{command} --json")
    found = [json.loads(line) for line in done.stdout.splitlines()]
    return [(one["difference"], one["device"]) for one in found]


def test_every_command_of_the_guide_is_run_here() -> None:
    assert RUNS_HERE == COMMANDS


def test_a_run_is_recorded_and_replayed(tmp_path: Path) -> None:
    """The light service turns off the lamp that is on at the start, and again when somebody turns it on."""
    with homebot_in(tmp_path, "--house", "thesis", "--record", "run.jsonl", until=(f"{LAMP} → off",)) as shell:
        recorder = shell.begin(RUNS_HERE[0].replace("86400", "5"))
        while not (tmp_path / "day.jsonl.gz").exists():
            assert recorder.poll() is None
        refused = shell.run("homebot record other.jsonl")
        assert (refused.returncode, "makes one recording for clients at a time" in refused.stderr) == (1, True)
        assert not (tmp_path / "other.jsonl").exists()
        assert shell.run(f"homebot do {LAMP} on").returncode == 0
        out, err = recorder.communicate(timeout=PATIENCE)
        assert (recorder.returncode, err) == (0, "")
        assert re.fullmatch(r"day\.jsonl\.gz: \d+ lines\n", out)
        again = shell.run("homebot record day.jsonl.gz")
        assert (again.returncode, again.stderr) == (
            1,
            "homebot: day.jsonl.gz exists already; --force replaces it\n",
        )
    for file in ("day.jsonl.gz", "run.jsonl"):
        assert (tmp_path / file).stat().st_mode & 0o777 == 0o600
        done = shell.run(RUNS_HERE[1].replace("day.jsonl.gz", file))
        assert (done.returncode, done.stderr) == (0, "")
        assert re.fullmatch(r"no difference: ([1-9]\d* commands are|1 command is) the same\n", done.stdout)


def test_a_recorder_that_is_stopped_by_ctrl_c_writes_a_whole_file(tmp_path: Path) -> None:
    with homebot_in(tmp_path, "--house", "thesis", until=(f"{LAMP} → off",)) as shell:
        recorder = shell.begin("homebot record day.jsonl")
        file = tmp_path / "day.jsonl"
        while not file.exists() or not file.stat().st_size:
            assert recorder.poll() is None
        recorder.send_signal(signal.SIGINT)
        out, err = recorder.communicate(timeout=PATIENCE)
        assert (recorder.returncode, err) == (0, "")
        assert "lines" in out
    lines = [json.loads(line)["kind"] for line in file.read_text().splitlines()]
    assert (lines[0], lines[-1]) == ("recording", "end")
    assert {"device", "gateway", "sighting", "report"} <= set(lines)


def test_a_changed_app_gives_other_commands(tmp_path: Path) -> None:
    """It turns no lamp off that has the name of the one that is on."""
    with homebot_in(tmp_path, "--house", "thesis", "--record", "day.jsonl.gz", until=(f"{LAMP} → off",)) as shell:
        assert shell.run("homebot record other.jsonl --for 2").returncode == 0  # what is in the last second counts not
    source = Path(homebot.apps.light_service.__file__).read_text("utf-8")
    changed = source.replace("if lamp.on", f'if lamp.on and "{LAMP}" not in lamp.device.id')
    assert changed != source
    (tmp_path / "my_lights_out.py").write_text(changed)
    done = shell.run(RUNS_HERE[2])
    assert done.returncode == 1
    assert re.search(rf"^- .*  {LAMP}  off  light_service, because .*\n.*[1-9]\d* gone", done.stdout, re.DOTALL)
    assert set(kinds(shell, RUNS_HERE[2])) == {("gone", f"lights/{LAMP}")}


def test_a_dry_run_sends_nothing_and_says_so(tmp_path: Path) -> None:
    """The lamp that is on at the start stays so, whatever the app and a person command."""
    (tmp_path / "homebot.toml").write_text('[home]\nname = "home425"\n[gateways.mqtt]\nroot = "home425"\n')
    options = ["--house", "house.toml", "--app", "light_service", *shlex.split(RUNS_HERE[3])[2:]]
    (tmp_path / "house.toml").write_text(
        f'[rooms.hall]\ndoors = ["outside"]\n[devices.{LAMP}]\nkind = "lamp"\nroom = "hall"\nis_on = true\n'
    )
    with homebot_in(tmp_path, *options, until=(f"light_service would set lights/{LAMP} → off",)) as shell:
        done = shell.run(f"homebot do {LAMP} off")
        assert done.returncode == 1
        assert "homebot runs with --dry-run and sends nothing" in done.stdout
        found = shell.run("homebot find 'on lights'")
        assert LAMP in found.stdout
        assert "not sent, and assumed to be done" in shell.run(f"homebot why-not {LAMP} off").stdout
        assert "not sent: this is a dry run" in shell.run("homebot journal").stdout
        assert "only observes: homebot runs with --dry-run" in shell.run("homebot doctor").stdout
