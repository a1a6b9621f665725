"""The guide to the mDNS gateway shows a table that works, and names what is announced."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.gateways.mdns.own_services import DOOR, HOMEBOT

GUIDE = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text()
SECTION = GUIDE[GUIDE.index("## mDNS") :].partition("\n## ")[0]


def test_its_table_is_one() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", SECTION, re.DOTALL)
    table = tomllib.loads(example)["gateways"]["mdns"]
    MdnsGateway.check(MdnsGatewaySettings.model_validate(table))


def test_it_names_what_is_announced() -> None:
    assert f"`{HOMEBOT}`" in SECTION
    assert f"`{DOOR}`" in SECTION
