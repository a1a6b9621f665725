"""The guide to the gateway of Hue bridges shows a table that works."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from homebot.gateways.hue import HueGateway, HueGatewaySettings

GUIDE = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text()
SECTION = GUIDE[GUIDE.index("## Philips Hue") :].partition("\n## ")[0]


def test_its_table_works() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", SECTION, re.DOTALL)
    gateways = tomllib.loads(example)["gateways"]
    settings = HueGatewaySettings.model_validate(gateways["hue"])
    HueGateway.check(settings)
    assert set(gateways["hue"]) == HueGatewaySettings.model_fields.keys() - {"act", "delivery", "stale_after"}
    assert settings.mdns in gateways
