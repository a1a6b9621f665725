"""Conventions subscribe before their reader is imported."""

import subprocess
import sys
from pathlib import Path

import pytest

from homebot.conventions.installed_conventions import check_tables, default_conventions, find_conventions
from homebot.errors import PluginError, WireError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings

CODE = """
import sys
from homebot.conventions.installed_conventions import default_conventions, find_conventions

def readers():
    return [name for name in sys.modules if name.startswith("homebot.") and name.endswith(".reader")
            and "packets" not in name]

found = find_conventions(default_conventions(), {}, "home425")
assert len(found) == len(default_conventions())
for one in found:
    assert one.filters() and one.rejected == 0
    one.birth_messages()
assert readers() == [], readers()
homie = next(one for one in found if one.name == "homie")
homie.read_message("homie/5/lamp/$state", b"init", retained=True)
assert readers() == ["homebot.integrations.homie.formats.reader"], readers()
"""


def test_only_the_convention_that_hears_something_loads_its_reader() -> None:
    """Filters, births and counts need none."""
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.rooms("zigbee2mqtt")
@pytest.mark.parametrize("names", [default_conventions(), ("thesis", "homeassistant", "zigbee2mqtt", "homie")])
def test_lists_of_all_devices_are_asked_for_before_single_announcements(names: tuple[str, ...]) -> None:
    """Else each device would be described twice: from its announcements while the list is read, and with the list."""
    found = [one.name for one in find_conventions(names, {}, "home425")]
    assert found == ["zigbee2mqtt", *(name for name in names if name != "zigbee2mqtt")]


BARE = "class Glow:\n    read_message = 1\n"
DERIVED = """
from homebot.conventions.convention import Convention, ConventionSettings

class Glow(Convention):
    Settings, name = ConventionSettings, "glow"
"""
COUNTS = """
    def __init__(self, settings):
        self.rejected = 0
"""


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        (BARE, "is no convention: it has no Settings, no name, no filters, no birth_messages"),
        (DERIVED, r"cannot be created: TypeError: Glow\.__init__\(\) takes exactly one argument"),
        (DERIVED + COUNTS, r"cannot be created: AttributeError: property 'rejected' "),
    ],
)
def test_a_class_that_is_no_convention_is_refused_with_what_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, problem: str
) -> None:
    """`homebot config check` ended with a traceback."""
    monkeypatch.chdir(tmp_path)
    Path("glow.py").write_text(source)
    assert check_tables(("glow.py:Glow",), {}) == []
    with pytest.raises(PluginError, match=problem):
        find_conventions(["glow.py:Glow"], {}, "home425")


def test_rejected_messages_are_counted_from_the_first_on() -> None:
    """The message that loads the reader counts too."""
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    assert (convention.is_loaded, convention.rejected) == (False, 0)
    with pytest.raises(WireError):
        convention.read_message("homeassistant/light/x/config", b"not JSON", retained=True)
    assert (convention.is_loaded, convention.rejected) == (True, 1)
