"""A recording made of the history of a house, for times that nobody recorded. Pure.

It has the states, events and numbers of all devices as the history kept them: no pauses, and of more than two days only
the means of five minutes. Times are whole milliseconds: of each, first come the reports that led to commands, then
these, and then what may be their effects.
"""

import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain
from typing import Final

from homebot.devices import Device, Endpoint, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.history_messages import HistorySeries
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import ALIAS_DEVICE, TAG_DEVICE
from homebot.devices.places_messages import OwnerRequest
from homebot.devices.value import PlainValue, Reading, Value
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message
from homebot.recording.lines import FORMAT, RecordedCommand, RecordingHeader
from homebot.recording.recording import RecordedEvent, Recording, TimedCommand
from homebot.version import __version__

_GATEWAY: Final = "history"
_FOREVER: Final = 400 * 86_400.0
_FLAGS: Final = {"true": True, "false": False}


def history_recording(
    home: str,
    devices: Sequence[Device],
    series: Iterable[HistorySeries],
    commands: Iterable[JournalEntry],
    since: float,
    until: float,
) -> Recording:
    """Return the recording of the time from *since* to *until*, in seconds since the Unix epoch.

    Args:
        commands: Entries of the journal; those of the kind ``requested`` count.
    """
    began = Time.from_seconds(since)
    recording = Recording(RecordingHeader(format=FORMAT, version=__version__, home=home, started_at=began))
    recording.devices = {one.id: _with_one_endpoint(one) for one in devices if one.endpoints}
    requested = [one for one in commands if one.kind == "requested"]
    messages = [(since, message) for one in devices if one.endpoints for message in _announcements(one, began)]
    known = recording.devices
    messages += chain.from_iterable(_reports(one, known[one.device], since) for one in series if one.device in known)
    _add_commands(messages, requested)
    for line, (at, message) in enumerate(messages):
        if isinstance(message, RecordedCommand):
            recording.commands.append(TimedCommand(at - since, message, line=line))
        elif at <= since and not isinstance(message, OwnerRequest):
            recording.before.append(message)
        else:
            recording.events.append(RecordedEvent(at - since, message, line))
    recording.ends_at, recording.is_whole = until - since, True
    return recording


def _key(device: str) -> str:
    return f"{_GATEWAY}:{device}"


def _with_one_endpoint(device: Device) -> Device:
    endpoint = Endpoint.model_validate(
        device.endpoints[0].model_dump() | {"gateway": _GATEWAY, "key": _key(device.id), "address": _key(device.id)}
    )
    return device.model_copy(update={"endpoints": (endpoint,)})


def _announcements(device: Device, at: Time) -> Iterator[Message]:
    """Yield the announcement of *device*, and its names and tags by the owner."""
    yield Sighting(
        gateway=_GATEWAY,
        key=_key(device.id),
        kind="appeared",
        why="it is in the history",
        name=device.name,
        service_type=device.service_type,
        address=_key(device.id),
        command_address=_key(device.id),
        metadata=device.metadata,
        whole_device=True,
        native=True,
        area=device.area,
        parts=tuple(one.part.model_copy(update={"id": one.id}) for one in device.parts),
        seen_at=at,
        expires_at=Time.from_seconds(at.to_seconds() + _FOREVER),
        confirmed=True,
    )
    for name in reversed(device.names if len(device.names) > 1 else ()):  # the newest is shown
        yield _asked(at, ALIAS_DEVICE, device=device.id, alias=name)
    for tag in device.tags:
        yield _asked(at, TAG_DEVICE, device=device.id, tag=tag)


def _asked(at: Time, service: str, **request: str) -> OwnerRequest:
    return OwnerRequest(at=at, service=service, request=json.dumps(request))


def _is_set(device: Device, series: HistorySeries) -> bool:
    part = device.part(series.part)
    return part is not None and any(one.name == series.capability and one.settable for one in part.part.capabilities)


def _reports(series: HistorySeries, device: Device, since: float) -> Iterator[tuple[float, Report]]:
    """Yield the values with their times: of a mean its end, of the first number and what lasts the start.

    The mean of what was set meanwhile is left out: nobody set that.
    """
    values: Iterable[PlainValue] = series.values
    if series.words:
        values = (_FLAGS.get(word, word) for word in series.words)
    is_set = series.lows and _is_set(device, series)
    times = [max(since, one + series.width) for one in series.times]
    if series.values:
        times[0] = since
    for number, (at, value) in enumerate(zip(times, values, strict=False)):
        if is_set and series.lows[number] != series.highs[number]:
            continue
        reading = Reading(part=series.part, capability=series.capability, value=Value.of(value))
        yield (
            at,
            Report(
                gateway=_GATEWAY,
                key=_key(series.device),
                readings=(reading,),
                stream=f"{_key(series.device)} {series.part} {series.capability}",
                retained=False,
                received_at=Time.from_seconds(at),
            ),
        )


def _command(entry: JournalEntry) -> RecordedCommand:
    return RecordedCommand(
        id=entry.command, issuer=entry.issuer, device=entry.device, part=entry.part, settings=entry.settings
    )


def _add_commands(messages: list[tuple[float, Message]], requested: Sequence[JournalEntry]) -> None:
    """Add the commands to *messages*, each after its cause, and sort all by time."""
    causes = {(_key(one.trigger.device), _milliseconds(one.trigger.at)) for one in requested}
    messages += ((_milliseconds(one.at) / 1000, _command(one)) for one in requested)
    messages.sort(key=lambda one: (one[0], _turn(one[1], round(one[0] * 1000), causes)))


def _turn(message: Message, at: int, causes: Collection[tuple[str, int]]) -> int:
    """Return which of several messages of one millisecond is first: the smallest."""
    if isinstance(message, Report) and (message.key, at) not in causes:
        return 2
    return int(isinstance(message, RecordedCommand))


def _milliseconds(at: Time) -> int:
    return at.sec * 1000 + at.nanosec // 1_000_000
