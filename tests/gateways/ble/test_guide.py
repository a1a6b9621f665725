"""The configuration that the guide shows is valid."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from homebot.gateways.ble import BleGatewaySettings

GUIDE = Path(__file__).parents[3] / "docs" / "protocols.md"


def test_the_table_of_the_guide_is_a_configuration() -> None:
    (block,) = (
        one for one in re.findall(r"```toml\n(.*?)```", GUIDE.read_text(), re.DOTALL) if "[gateways.ble]" in one
    )
    settings = BleGatewaySettings.model_validate(tomllib.loads(block)["gateways"]["ble"])
    assert settings.profiles["strip"].part().service_type == "light"
    assert settings.devices["A4:C1:38:0A:0B:0C"].name == "Attic"
