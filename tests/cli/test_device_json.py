"""Devices as JSON for other programs."""

from __future__ import annotations

import json

from homebot.cli.device_json import json_text, list_text


def test_json_for_other_programs_is_as_the_standard_library_writes_it() -> None:
    device = {"id": 'Kü"che\x9b\u2028\x7f', "empty": [], "of": {}, "x": [{"y": [1, 2.5, None, True]}, "客\U0001f4a1"]}
    assert json_text(device).lower() == json.dumps(device, indent=2).lower()
    assert list_text([json_text(device)] * 2).lower() == json.dumps([device] * 2, indent=2).lower()
    assert list_text([]) == "[]"
