"""What the command line believes homebot to answer with is what the messages are."""

from __future__ import annotations

import json
import re
from importlib import import_module
from typing import Literal, get_origin, get_type_hints, is_typeddict

import pytest

from homebot.bridges.rosapi import endpoints
from homebot.cli import command_records, places_records, records
from homebot.cli.device_json import json_text, list_text
from homebot.messages.message import Message

MODULES = (command_records, places_records, records)
NAMES = {name: found for module in MODULES for name, found in vars(module).items()}
RECORDS = [one for one in NAMES.values() if is_typeddict(one)]


def message_of(record: type) -> type[Message]:
    """The message that the docstring of *record* names."""
    assert record.__doc__ is not None
    if "EndpointDetails" in record.__doc__:
        return endpoints.EndpointDetails
    named = re.search(r"`([\w.]+)`", record.__doc__)
    assert named is not None
    module, _, name = named[1].rpartition(".")
    found: type[Message] = getattr(import_module(module), name)
    return found


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_a_record_has_fields_of_its_message_alone(record: type) -> None:
    fields = get_type_hints(message_of(record))
    for name, kind in get_type_hints(record, NAMES).items():
        wanted = fields[name]
        if kind in {str, int, float, bool}:
            assert wanted is kind or (get_origin(wanted) is Literal and kind is str)
        elif get_origin(kind) is list:
            (inner,) = kind.__args__
            assert get_origin(wanted) is tuple
            assert is_typeddict(inner) is issubclass(wanted.__args__[0], Message)
        else:
            assert message_of(kind) is wanted


def test_json_for_other_programs_is_as_the_standard_library_writes_it() -> None:
    device = {"id": 'Kü"che\x9b\u2028\x7f', "empty": [], "of": {}, "x": [{"y": [1, 2.5, None, True]}, "客\U0001f4a1"]}
    assert json_text(device).lower() == json.dumps(device, indent=2).lower()
    assert list_text([json_text(device)] * 2).lower() == json.dumps([device] * 2, indent=2).lower()
    assert list_text([]) == "[]"
