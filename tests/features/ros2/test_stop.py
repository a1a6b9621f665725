"""The end of a homebot with a link to robots: Zenoh's threads kept a program alive that did not close its session."""

from pathlib import Path
from queue import Queue

import pytest
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import log_in, write_tokens
from tests.shell import homebot_in
from zenoh import Sample

pytestmark = pytest.mark.slow


def test_a_homebot_with_an_open_session_stops_when_it_is_told(tmp_path: Path) -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    ros = f'[ros]\nlisten = "{address}"\nimport = {{rosie = []}}\n'
    (tmp_path / "homebot.toml").write_text(f'[home]\nname = "villa"\n{write_tokens(tmp_path, "rosie")}{ros}')
    with (
        homebot_in(tmp_path, "--ephemeral", until=("is running",)),
        log_in(address, "rosie", patience=PATIENCE) as robot,
    ):
        tokens: Queue[str] = Queue()

        def record(sample: Sample) -> None:
            tokens.put(str(sample.key_expr))

        with robot.liveliness().declare_subscriber("@ros2_lv/0/**", record, history=True):
            while not tokens.get(timeout=PATIENCE).endswith("/ros2"):
                pass
