"""The presets of a WLED controller."""

import pytest
from tests.integrations.wled.formats.wled_documents import RGB_0_15

from homebot.errors import RefusedError
from homebot.integrations.wled.formats.strip import WledStrip, preset_names

NAMES = {1: "Warm", 2: "Preset 2", 5: "Warm (5)", 7: "Party"}


def test_each_preset_has_a_name_of_its_own() -> None:
    presets = {"0": {}, "1": {"n": "Warm"}, "2": {"on": True}, "5": {"n": "Warm"}, "7": {"n": "Party", "playlist": {}}}
    assert preset_names({**presets, "x": {}, "9": None, "251": {}, "99999": {}}) == NAMES
    assert preset_names([]) == {}


@pytest.mark.parametrize(
    ("state", "name"),
    [({"ps": 1, "pl": -1}, "Warm"), ({"ps": 1, "pl": 7}, "Party"), ({"ps": -1, "pl": -1}, None), ({"ps": "1"}, None)],
)
def test_a_playlist_that_runs_counts_before_its_preset(state: dict[str, object], name: str | None) -> None:
    strip = WledStrip({"state": state, "info": {}}, (), NAMES)
    assert dict(strip.readings())["preset"] == {"option": name}


def test_a_preset_is_chosen_by_its_number() -> None:
    strip = WledStrip(RGB_0_15, (), NAMES)
    assert strip.write("preset", {"option": "Warm (5)"}, 0.0) == {"ps": 5}
    with pytest.raises(RefusedError):
        strip.write("preset", {"option": "Cold"}, 0.0)
    with pytest.raises(RefusedError):
        WledStrip(RGB_0_15, ()).write("preset", {"option": "Warm"}, 0.0)
