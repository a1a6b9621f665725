"""``homebot interface``: types of ROS by name, and those of a workspace."""

from pathlib import Path

import pytest

from homebot.cli import main

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


def test_types_are_listed_and_shown(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interface", "list", "nav2_msgs"]) == 0
    assert "nav2_msgs/action/NavigateToPose\n" in capsys.readouterr().out
    assert main(["interface", "show", "std_msgs/Header"]) == 0
    assert capsys.readouterr().out == (
        "# std_msgs/msg/Header\n# RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01\n"
        "builtin_interfaces/Time stamp\nstring frame_id\n"
    )
    assert main(["interface", "show", "homebot/srv/WhereIsRobot"]) == 0
    assert "---\nbool success\nstring message\nhomebot/RobotPose[] pose\n" in capsys.readouterr().out
    for unknown in ("nav2_msgs/NavigateToPos", "NavigateToPose"):
        assert main(["interface", "show", unknown]) == 1
        assert "similar: nav2_msgs/action/NavigateToPose" in capsys.readouterr().err


def test_a_workspace_is_imported_and_counts_with_its_table(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["interface", "import", str(workspace)]) == 0
    assert 'interfaces = ["interfaces"]' in capsys.readouterr().out
    assert main(["interface", "list", "my_pets"]) == 1
    Path("homebot.toml").write_text('[ros]\ninterfaces = ["interfaces"]\ndistro = "kilted"\n')
    assert main(["config", "check"]) == 0
    capsys.readouterr()
    assert main(["interface", "list", "my_pets"]) == 0
    assert capsys.readouterr().out == "my_pets/action/Walk\nmy_pets/msg/Pet\n"
    assert main(["interface", "show", "my_pets/Pet"]) == 0
    assert capsys.readouterr().out.endswith(PET)
    assert main(["interface", "show", "nav2_msgs/action/Spin"]) == 0
    assert "disable_collision_checks" in capsys.readouterr().out


def test_a_workspace_with_an_error_is_not_imported(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (workspace / "src/my_pets/msg/Toy.msg").write_text("\ufeffstring color\nBall ball\n", "utf-8")
    assert main(["interface", "import", str(workspace)]) == 1
    assert "my_pets/msg/Toy has a field of an unknown message type 'my_pets/msg/Ball'" in capsys.readouterr().err
    assert not Path("interfaces").exists()


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
