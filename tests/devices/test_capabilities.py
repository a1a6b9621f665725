import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.source_trees import SOURCE

ROW = """CapabilityType(
    "confetti_strength", "number", "how much is thrown", unit="%", bounds=(0.0, 100.0), is_set=True, bare="share",
    spoken="confetti", words={"burst": 100.0}
),
"""

STRANGER = """
from homebot.words.commands import parse_command_words
from homebot.devices.capabilities import SETTABLE
from homebot.devices.part import Capability, Part
from homebot.devices.query.terms import CanDo, StateIs
from homebot.words.queries import parse_query
from homebot.devices.text.commands import decode_command, encode_command
from homebot.devices.text.states import decode_text, encode_state
from homebot.devices.wording.values import span, value_text
from homebot.integrations.homeassistant.formats.published_entity import publish_single

name = "confetti_strength"
thrown = Capability(name=name, settable=True)
part = Part(id="", service_type="x_setting", capabilities=(thrown,))
spoken = {word: parse_command_words(word, (), part, "the cannon") for word in ("0.4", "40 %", "burst", "confetti 40")}
assert spoken == {word: {name: 100.0 if word == "burst" else 40.0} for word in spoken}, spoken
assert decode_command(encode_command(name, 40.0, part), part) == (name, 40.0)
assert decode_text(encode_state({name: 40.0}), part) == {name: 40.0}
assert (value_text(name, 40.0), span(thrown)) == ("40 %", "0 to 100 %")
assert parse_query("with confetti strength") == CanDo(name)
assert parse_query("confetti > 20") == StateIs(name, ">", 20.0)
assert name in SETTABLE  # the journal keeps who set it, and follow tells of it
number = publish_single(part, thrown, "homebot/cannon")[0]
assert (number.component, number.config["max"], number.config["unit_of_measurement"]) == ("number", 100.0, "%")
"""


@pytest.mark.parametrize("row", [ROW, ""], ids=["with its row", "without"])
def test_a_new_capability_is_one_row_of_one_table(tmp_path: Path, row: str) -> None:
    copy = tmp_path / "homebot"
    shutil.copytree(SOURCE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    table = copy / "devices" / "capabilities.py"
    head, first, rest = table.read_text(encoding="utf-8").partition("_CONTROLS = (\n")
    table.write_text(head + first + row + rest, encoding="utf-8")
    ran = subprocess.run([sys.executable, "-c", STRANGER], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert ("RefusedError" in ran.stderr) == (not row), ran.stderr
    assert bool(ran.returncode) == (not row), ran.stderr
