"""Inputs and buttons of Shelly's first generation. Pure.

Source: Shelly Gen1 API, MQTT: ``input/<i>`` and ``input_event/<i>``.
"""

from __future__ import annotations

from functools import partial

from homebot.conventions.decode import NO_READINGS, Readings, to_json, to_text
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.shelly.gen1_topics import Gen1Topics
from homebot.conventions.table_codec import raw_bytes

__all__ = ["Presses", "build_input"]

_PRESSES = {
    "S": "single",
    "SS": "double",
    "SSS": "triple",
    "L": "long",
    "SL": "short_long",
    "LS": "long_short",
}
_STATES: dict[str, Readings] = {"0": {"state": False}, "1": {"state": True}}


class Presses:
    """Tells a new press from one that the device only repeats, by the counter beside it.

    A device that was asked for its state tells its last press again. So the first one that is heard only sets the
    counter, but for a device that wakes up to tell it. It outlives a description, which a device that is heard on one
    more topic gets anew.
    """

    __slots__ = ("_count",)

    def __init__(self) -> None:
        self._count: object = None

    def read(self, payload: bytes, *, counts_first: bool) -> Readings:
        """Return the press that *payload* tells, if it is a new one; the first counts where *counts_first* says so."""
        message = to_json(payload)
        if not isinstance(message, dict):
            return NO_READINGS
        event, count = message.get("event"), message.get("event_cnt")
        if not isinstance(count, int) or isinstance(count, bool):
            count = None
        is_first = self._count is None
        is_new = (count is None or count != self._count) and (counts_first or not is_first)
        self._count = 0 if count is None else count
        press = _PRESSES.get(event) if isinstance(event, str) else None
        return {"press": press} if is_new and press is not None else NO_READINGS


def build_input(
    topics: Gen1Topics, index: int, presses: Presses, *, has_state: bool, has_events: bool, counts_first: bool
) -> BytesPart:
    """Describe an input: a button where it tells presses.

    Args:
        topics: Those of the device.
        index: Number of the input.
        presses: Its presses so far.
        has_state: Whether it tells if it is on.
        has_events: Whether it tells presses.
        counts_first: Whether the first press that is heard is a new one.
    """
    part = PartBuilder(
        raw_bytes, f"input:{index}", "generic_switch" if has_events else "x_binary_sensor", advertised="input"
    )
    if has_state:
        part.read_from(topics.at(f"input/{index}"), _read_state)
        part.add_capability("state")
    if has_events:
        part.read_events_from(topics.at(f"input_event/{index}"), partial(presses.read, counts_first=counts_first))
        part.add_capability("press", options=tuple(_PRESSES.values()))
    return part


def _read_state(payload: bytes) -> Readings:
    return _STATES.get(to_text(payload) or "", NO_READINGS)
