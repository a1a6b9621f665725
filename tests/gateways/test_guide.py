"""The tables in the guide to the protocols pass their check, and it names what the gateways understand and announce."""

import re
from pathlib import Path

import pytest
from tests.guide import blocks_in, guide

from homebot.cli.main import main
from homebot.gateways.mdns.own_services import DOOR, HOMEBOT
from homebot.integrations.matter.gateway.server_link import OLDEST_SCHEMA, SCHEMA

GUIDE = guide("protocols")
SECRETS = {"key": f"{'A' * 43}="}
"""Of ESPHome; others take 32 digits."""


@pytest.mark.parametrize("shown", blocks_in(GUIDE, "toml"))
def test_a_table_passes_its_check(shown: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind, name in re.findall(r'(\w+)_file = "(.*?)"', shown):
        (tmp_path / name).parent.mkdir(mode=0o700, exist_ok=True)
        (tmp_path / name).touch(0o600)
        (tmp_path / name).write_text(SECRETS.get(kind, "00" * 16))
    (tmp_path / "homebot.toml").write_text(shown)
    assert main(["config", "check", "--config", str(tmp_path / "homebot.toml")]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("section", "named"),
    [
        ("mDNS", f"`{HOMEBOT}`"),
        ("mDNS", f"`{DOOR}`"),
        ("Matter", f"Schema versions {OLDEST_SCHEMA} to {SCHEMA}"),
    ],
)
def test_a_section_names_it(section: str, named: str) -> None:
    assert named in GUIDE[GUIDE.index(f"## {section}") :].partition("\n## ")[0]
