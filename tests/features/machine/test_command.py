"""``homebot join``: the configuration of both machines, secrets that only their owner can read, and what goes wrong."""

import io
import stat
from pathlib import Path

import pytest

from homebot.cli import main
from homebot.config import load_config
from homebot.runtime.plan import make_plan

Text = pytest.CaptureFixture[str]

pytestmark = pytest.mark.rooms("machine")

LISTENS = '[home]\nname = "villa"\n[ros]\nlisten = "tcp/127.0.0.1:7447"\n'
ADDRESS = "tcp/127.0.0.1:7447"


@pytest.fixture
def invite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Text) -> str:
    """The code of the first machine; the second one is the present folder."""
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "first")
    Path("homebot.toml").write_text(LISTENS)
    assert main(["join", "--new", "attic"]) == 0
    monkeypatch.chdir(tmp_path / "second")
    return capsys.readouterr().out.split()[-1]


def join(code: str, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setattr("sys.stdin", io.StringIO(f"{code}\n"))
    return main(["join", ADDRESS])


def test_both_machines_get_their_tables_and_the_same_secret(
    invite: str, monkeypatch: pytest.MonkeyPatch, capsys: Text
) -> None:
    Path("homebot.toml").write_text("[gateways.mqtt]")
    assert join(invite, monkeypatch) == 0
    assert "run: homebot run" in capsys.readouterr().out
    first, second = make_plan(load_config(Path("../first/homebot.toml"))), make_plan(load_config(Path("homebot.toml")))
    assert (first.own_gateways, [one.name for one in first.gateways]) == ((), ["attic"])
    assert not first.as_other_machine
    assert (second.home, second.own_gateways) == ("villa", ("mqtt",))
    assert second.as_other_machine.startswith("this is the machine attic: ")
    assert second.link is not None
    assert second.link.connect == (ADDRESS,)
    secrets = [Path(folder, "attic.token") for folder in ("../first", ".")]
    assert secrets[0].read_text() == secrets[1].read_text()
    assert [stat.S_IMODE(one.stat().st_mode) for one in secrets] == [0o600, 0o600]


@pytest.mark.rooms("ros2")
def test_a_machine_gets_the_certificate_of_the_house_that_listens_with_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Text
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["router", "--certificate", "villa.lan"]) == 0
    with_key = 'listen = "tls/0.0.0.0:7447"\ncert_file = "router.crt"\nkey_file = "router.key"\n'
    Path("homebot.toml").write_text(f'[home]\nname = "villa"\n[ros]\n{with_key}')
    assert main(["join", "--new", "attic"]) == 0
    code = capsys.readouterr().out.split()[-1]
    (tmp_path / "second").mkdir()
    monkeypatch.chdir(tmp_path / "second")
    monkeypatch.setattr("sys.stdin", io.StringIO(code))
    assert main(["join", "tls/villa.lan:7447"]) == 0
    link = make_plan(load_config(Path("homebot.toml"))).link
    assert link is not None
    assert link.ca is not None
    assert link.ca.read_bytes() == (tmp_path / "router.crt").read_bytes()


@pytest.mark.parametrize(
    ("before", "code", "why"),
    [
        ("", "rubbish", "that is not the code which `homebot join --new NAME` printed"),
        (
            '[home]\nname = "other"\n',
            "",
            "the home is other, and not villa; change name in [home]; nothing was written",
        ),
        ("[ros]\n", "", "has a table [ros]"),
    ],
    ids=["code", "home", "twice"],
)
def test_nothing_is_written_for_what_does_not_fit(
    invite: str, monkeypatch: pytest.MonkeyPatch, capsys: Text, before: str, code: str, why: str
) -> None:
    Path("homebot.toml").write_text(before)
    assert join(code or invite, monkeypatch) == 1
    assert why in capsys.readouterr().err
    assert Path("homebot.toml").read_text() == before
    assert not Path("attic.token").exists()


def test_a_house_that_does_not_listen_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Text
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("homebot.toml").write_text('[home]\nname = "villa"\n')
    assert main(["join", "--new", "attic"]) == 1
    assert "has no listen in [ros], where attic could connect" in capsys.readouterr().err


@pytest.mark.rooms("ros2")
def test_a_machine_trusts_the_certificate_of_a_house_that_listens_for_other_computers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Text
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["router", "--certificate", "villa.lan"]) == 0
    files = 'cert_file = "router.crt"\nkey_file = "router.key"\n'
    Path("homebot.toml").write_text(LISTENS.replace("tcp/127.0.0.1", "tls/0.0.0.0") + files)
    assert main(["join", "--new", "attic"]) == 0
    code = capsys.readouterr().out.split()[-1]
    Path("attic").mkdir()
    monkeypatch.chdir("attic")
    monkeypatch.setattr("sys.stdin", io.StringIO(code))
    assert main(["join", "tls/villa.lan:7447"]) == 0
    link = make_plan(load_config(Path("homebot.toml"))).link
    assert link is not None
    assert link.ca is not None
    assert link.ca.read_text() == Path("../router.crt").read_text()
    assert Path("../router.key").read_text() not in code
