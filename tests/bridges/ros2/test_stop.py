"""The end of a homebot with a link to robots: Zenoh's threads kept a program alive that did not close its session."""

import json
from pathlib import Path

import pytest
import zenoh
from tests.ports import reserve_port
from tests.shell import homebot_in

pytestmark = pytest.mark.slow


def test_a_homebot_with_an_open_session_stops_when_it_is_told(tmp_path: Path) -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    (tmp_path / "homebot.toml").write_text(f'[home]\nname = "villa"\n[ros]\nlisten = "{address}"\n')
    settings = {"mode": "peer", "connect": {"endpoints": [address]}, "listen": {"endpoints": ["tcp/127.0.0.1:0"]}}
    config = json.dumps(settings | {"scouting": {"multicast": {"enabled": False}}})
    with (
        homebot_in(tmp_path, "--ephemeral", until=("is running",)),
        zenoh.open(zenoh.Config.from_json5(config)) as robot,
    ):
        tokens = list(robot.liveliness().get("@ros2_lv/0/**", timeout=60.0))
        assert any(str(one.ok.key_expr).endswith("/ros2") for one in tokens if one.ok is not None)
