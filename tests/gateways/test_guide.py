"""The tables in the guide to the protocols pass their check, and it names what the gateways understand and announce."""

import re
from pathlib import Path

import pytest
from tests.guide import blocks_in, guide, section_in

from homebot.cli.main import main
from homebot.gateways.mdns.own_services import DOOR, HOMEBOT

GUIDE = guide("protocols")
SECRETS = {"key": f"{'A' * 43}="}
"""Of ESPHome; others take 32 digits."""
FOLDER = re.compile(r"""(?<=[.["])(coap|esphome|homeassistant|homekit_bridge|homekit|hue|matter|shelly|thing)""")


def table(shown: str) -> object:
    """Mark it with the folders that it names."""
    named = {"things" if one in {"coap", "thing"} else one for one in FOLDER.findall(re.sub("#.*", "", shown))}
    return pytest.param(shown, marks=[pytest.mark.rooms(*named)])


@pytest.mark.parametrize("shown", [table(one) for one in blocks_in(GUIDE, "toml")])
def test_a_table_passes_its_check(shown: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind, name in re.findall(r'(\w+)_file = "(.*?)"', shown):
        (tmp_path / name).parent.mkdir(mode=0o700, exist_ok=True)
        (tmp_path / name).touch(0o600)
        (tmp_path / name).write_text(SECRETS.get(kind, "00" * 16))
    (tmp_path / "homebot.toml").write_text(shown)
    assert main(["config", "check", "--config", str(tmp_path / "homebot.toml")]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("named", [HOMEBOT, DOOR])
def test_a_section_names_what_is_announced(named: str) -> None:
    assert f"`{named}`" in section_in(GUIDE, "mDNS")
