"""The tables of drivers, as the configuration has them."""

from __future__ import annotations

from pathlib import Path

from homebot.config import load_config
from homebot.runtime.plan import make_plan


def test_a_relative_path_in_the_table_of_a_driver_begins_at_the_folder_of_the_configuration(tmp_path: Path) -> None:
    """As everywhere in that file."""
    secret = tmp_path / "shelly.txt"
    secret.write_text("hunter2")
    secret.chmod(0o600)
    file = tmp_path / "homebot.toml"
    file.write_text('[gateways.mdns.drivers.shelly]\npassword_file = "shelly.txt"\n')
    make_plan(load_config(file))
