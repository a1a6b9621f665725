"""Helpers with the time of the last run of their automation: a routine knows this by itself. Pure."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from homebot.integrations.homeassistant.automations.fields import NotCarriedError, called_service, service_name
from homebot.support.located import Located

_NOW: Final = re.compile(
    r"\{\{now\(\)(?:\.timestamp\(\)|\.isoformat\(\)|\.strftime\(['\"]%Y-%m-%d(?:%H:%M(?::%S)?)?['\"]\))?(?:\|(?:int|round))*\}\}"
)
"""The time of now, without its spaces."""

SETS_TIME: Final = "input_datetime.set_datetime"


def run_marks(actions: Sequence[Located], others: Sequence[str]) -> dict[str, bool]:
    """Return the helpers that *actions* set to the time of each run, and that *others* and further calls do not name.

    Of each it returns whether it has the time of day beside the date.
    Only the first actions count, before any that asks or waits: they are part of each run.
    """
    marks: dict[str, bool] = {}
    calls = [node.value for node in actions if isinstance(node.value, dict) and service_name(node.value)]
    named = [*others, *(str(call) for call in calls if not marked_by(call))]
    for node in actions:
        fields = node.value if isinstance(node.value, dict) else {}
        if not service_name(fields) or "enabled" in fields:
            break
        marks[marked_by(fields)] = "'date':" not in str(fields)
    return {mark: has_time for mark, has_time in marks.items() if mark and not any(mark in other for other in named)}


def marked_by(fields: Mapping[str, Located]) -> str:
    """Return the helper that the call of a service sets to the time of now; empty for another call."""
    if service_name(fields) != SETS_TIME:
        return ""
    try:
        call = called_service(fields)
    except NotCarriedError:
        return ""
    (time,) = call.data.left.values() if len(call.data.left) == 1 else (Located("", 0),)
    is_now = isinstance(time.value, str) and _NOW.fullmatch("".join(time.value.split()))
    return call.entities[0] if len(call.entities) == 1 and is_now else ""
