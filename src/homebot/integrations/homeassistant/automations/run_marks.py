"""Helpers with the time of the last run of their automation: a routine knows this by itself. Pure."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.support.located import Located

_NOW: Final = re.compile(
    r"\{\{now\(\)(?:\.timestamp\(\)|\.isoformat\(\)|\.strftime\(['\"]%Y-%m-%d%H:%M(?::%S)?['\"]\))?(?:\|(?:int|round))*\}\}"
)
"""The time of now, without its spaces."""

SETS_TIME: Final = "input_datetime.set_datetime"


def run_marks(actions: Sequence[Located], others: Sequence[str]) -> frozenset[str]:
    """Return the helpers that *actions* set to the time of each run, and that *others* do not name.

    Only the first actions count, before any that asks or waits: they are part of each run.
    """
    marks: set[str] = set()
    for node in actions:
        fields = node.value if isinstance(node.value, dict) else {}
        if {"service", "action"}.isdisjoint(fields) or "enabled" in fields:
            break
        marks |= {marked_by(fields)}
    return frozenset(mark for mark in marks - {""} if not any(mark in other for other in others))


def marked_by(fields: Mapping[str, Located]) -> str:
    """Return the helper that the call of a service sets to the time of now; empty for another call."""
    name = next((fields[key].value for key in ("service", "action") if key in fields), "")
    if name != SETS_TIME:
        return ""
    call = UnreadFields(Located(dict(fields), 0), "action")
    try:
        data = call.inner("data", "data_template")
        ids = [text for place in (call.inner("target"), data, call) for text in place.texts("entity_id")]
    except NotCarriedError:
        return ""
    (time,) = data.left.values() if len(data.left) == 1 else (Located("", 0),)
    is_now = isinstance(time.value, str) and _NOW.fullmatch("".join(time.value.split()))
    return ids[0] if len(ids) == 1 and is_now else ""
