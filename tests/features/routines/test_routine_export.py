"""``homebot routine export``, with the lines for the configuration that it prints."""

from pathlib import Path

import pytest
from tests.cli.conftest import NOW, HomebotWith, run_at

from homebot.clock import ManualClock
from homebot.config import load_config
from homebot.devices.app_messages import ListRoutines, RoutineInfo, RoutinesResponse
from homebot.devices.names import LIST_ROUTINES
from homebot.graph import Graph, Node
from homebot.runtime.plan import make_plan

TEXT = '[[routines]]\nname = "Let in"\nwhen = ["7:00"]\ndo = ["front door unlock"]\n'


@pytest.mark.parametrize(
    ("act", "grants"),
    [
        ("", {}),
        ("act = []\n", {"/let_in_app": ("read",)}),
        ("act = ['ordinary', 'id=\"a\"']\n", {"/let_in_app": ("act: ordinary", 'act: id="a"')}),
    ],
)
def test_the_printed_table_gives_the_app_the_rights_of_the_routine(
    homebot_with: HomebotWith,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    act: str,
    grants: dict[str, tuple[str, ...]],
) -> None:
    def routines(graph: Graph) -> Node:
        node = Node(graph, "homebot")
        info = RoutineInfo(name="Let in", app="let_in", text=TEXT + act)
        node.create_service(ListRoutines, LIST_ROUTINES, lambda _: RoutinesResponse(routines=(info,)))
        return node

    monkeypatch.chdir(tmp_path)
    code, out = run_at(homebot_with(routines, ManualClock(NOW)), capsys)("routine", "export", "Let in")
    assert code == 0, out
    (tmp_path / "homebot.toml").write_text(out.partition("homebot.toml:\n")[2])
    assert make_plan(load_config(tmp_path / "homebot.toml")).grants.now.scopes == grants
