"""Goals that a person stops with Ctrl-C."""

from unittest.mock import create_autospec

import pytest

from homebot.cli.door_client import DoorClient
from homebot.cli.goals import perform_goal


@pytest.mark.parametrize(
    ("as_json", "told"), [(False, "homebot: cancelled\n"), (True, '{"note": "cancelled"}\n')], ids=["words", "json"]
)
def test_the_end_of_a_goal_after_ctrl_c_is_told_as_the_command_tells_all_else(
    capsys: pytest.CaptureFixture[str], *, as_json: bool, told: str
) -> None:
    door = create_autospec(DoorClient, instance=True, as_json=as_json)
    door.next.side_effect = KeyboardInterrupt
    door.until.return_value = [("", {"op": "action_result", "values": {"message": "cancelled"}}, 0.0)]
    with pytest.raises(KeyboardInterrupt):
        perform_goal(door, "/achieve", "x/action/X", {}, lambda _: None)
    door.cancel_goal.assert_called_once()
    assert capsys.readouterr().err == told
