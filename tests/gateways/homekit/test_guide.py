"""The guide to the HomeKit gateway shows a table that works."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from homebot.gateways.homekit import HomekitGateway, HomekitGatewaySettings

GUIDE = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text()
SECTION = GUIDE[GUIDE.index("## HomeKit") :].partition("\n## ")[0]


def test_its_table_works(tmp_path: Path) -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", SECTION, re.DOTALL)
    table = tomllib.loads(example)["gateways"]["homekit"]
    settings = HomekitGatewaySettings.model_validate(table)
    assert settings.pairings is not None
    HomekitGateway.check(settings)
    assert HomekitGatewaySettings().mdns in tomllib.loads(example)["gateways"]
