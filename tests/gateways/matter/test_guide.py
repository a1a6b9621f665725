"""The guide to the Matter gateway shows a table that works, and names its keys."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from homebot.gateways.matter import MatterGateway, MatterGatewaySettings
from homebot.gateways.matter.server_messages import OLDEST_SCHEMA, SCHEMA

GUIDE = (Path(__file__).parents[3] / "docs" / "protocols.md").read_text()
SECTION = GUIDE[GUIDE.index("## Matter") :].partition("\n## ")[0]


def test_its_table_is_one_of_defaults() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", SECTION, re.DOTALL)
    settings = MatterGatewaySettings.model_validate(tomllib.loads(example)["gateways"]["matter"])
    MatterGateway.check(settings)
    assert settings == MatterGatewaySettings()


def test_it_names_the_versions_that_are_understood() -> None:
    assert f"Schema versions {OLDEST_SCHEMA} to {SCHEMA}" in SECTION
