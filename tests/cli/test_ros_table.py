"""The table ``[ros]``: the interfaces of a workspace."""

from pathlib import Path

import pytest

from homebot.cli import main
from homebot.messages.interfaces.settings import read_interfaces

PET = "string name\nuint8 CAT=1  # the usual one\n"
WALK = "Pet pet\n---\n---\nfloat32 minutes_left\n"


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for path, text in {"msg/Pet.msg": PET, "action/Walk.action": WALK}.items():
        file = tmp_path / "ws/src/my_pets" / path
        file.parent.mkdir(parents=True)
        file.write_text(text)
    return tmp_path / "ws"


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ('interfaces = ["nowhere"]', "ros.interfaces: there is no folder"),
        ('distro = "kitted"', "ros.distro: input should be 'humble', 'jazzy' or 'kilted'"),
        ('interfaces = ["ws"]', "ros.interfaces: my_pets/msg/Pet: line 1: 'int33' is not a type"),
    ],
)
def test_a_wrong_table_is_named(workspace: Path, table: str, problem: str, capsys: pytest.CaptureFixture[str]) -> None:
    (workspace / "src/my_pets/msg/Pet.msg").write_text("int33 age\n")
    Path("homebot.toml").write_text(f"[ros]\n{table}\n")
    assert main(["config", "check"]) == 1
    assert problem in capsys.readouterr().err


def test_the_source_of_a_workspace_counts(workspace: Path) -> None:
    Path("homebot.toml").write_text('[ros]\ninterfaces = ["ws/src"]\ndistro = "kilted"\n')
    assert main(["config", "check"]) == 0
    known = read_interfaces({"interfaces": ["ws/src"], "distro": "kilted"}, "homebot.toml", workspace.parent)
    assert {"my_pets/action/Walk", "my_pets/msg/Pet"} < set(known.names())
    assert known.find_action("my_pets/Walk").Goal.model_fields["pet"].annotation is known.find_message("my_pets/Pet")
    assert "disable_collision_checks" in known.find_action("nav2_msgs/action/Spin").Goal.model_fields
