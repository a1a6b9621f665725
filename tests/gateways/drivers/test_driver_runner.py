"""The tables of drivers, as the configuration has them, and what drivers need."""

from pathlib import Path
from typing import ClassVar

import pytest

from homebot.config import load_config
from homebot.errors import UsageError
from homebot.gateways.drivers import DriverSettings
from homebot.integrations.wled.driver import WledDriver
from homebot.runtime.plan import make_plan


def test_a_relative_path_in_the_table_of_a_driver_begins_at_the_folder_of_the_configuration(tmp_path: Path) -> None:
    """As everywhere in that file."""
    secret = tmp_path / "shelly.txt"
    secret.write_text("hunter2")
    secret.chmod(0o600)
    file = tmp_path / "homebot.toml"
    file.write_text('[gateways.mdns.drivers.shelly]\npassword_file = "shelly.txt"\n')
    make_plan(load_config(file))


class NeedyDriver(WledDriver):
    """A driver of which one library is there, and one is not."""

    libraries: ClassVar[tuple[str, ...]] = ("anyio", "homebot_has_no_such_library")


def test_a_driver_without_its_library_names_the_command_that_installs_it() -> None:
    wanted = r'^it needs homebot_has_no_such_library; install it with: pip install "homebot\[mdns\]"$'
    with pytest.raises(UsageError, match=wanted):
        NeedyDriver.check(DriverSettings())
