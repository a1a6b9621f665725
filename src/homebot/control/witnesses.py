"""Witnesses of commands: sensors that the owner names, and meters of the same device."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial
from types import MappingProxyType
from typing import Final, NamedTuple, final

from homebot.control.gateway_feed import GatewayFeed
from homebot.control.open_command import OpenCommand
from homebot.control.settings import ControlSettings
from homebot.control.timeline.evidence import outcome_of
from homebot.devices import Device, DevicePart
from homebot.devices.approval_messages import TrustDeviceRequest, TrustDeviceResponse
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer, Outcome
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.bounded_map import BoundedMap

CONTRADICTED = "control.contradicted_by_witness"

_MAX_CONTRADICTED: Final = 1000
_MAX_NAMED: Final = 4
_METERS: Final = frozenset({"power", "flow"})
"""Capabilities with which a device measures its own effect."""


@dataclass(slots=True, eq=False)
class Witness:
    """A sensor that observes one command.

    Attributes:
        is_named: Whether the owner named it; if so, it is awaited, and may contradict the device.
        seen_at: When it last reported, on the monotonic clock.
    """

    name: str
    is_named: bool
    part: DevicePart
    capability: str
    before: PlainValue
    newest: PlainValue
    seen_at: float = 0.0
    stop_watch: Callable[[], None] = lambda: None


@final
class Witnesses:
    """Sensors that observe commands.

    Attributes:
        contradicted: The name of the witness that contradicted each of the last 1,000 parts, until a witness sees the
            part obey, or the owner trusts it again.
    """

    def __init__(self, node: Node, settings: ControlSettings, feed: GatewayFeed, lookup: DeviceLookup) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._named = settings.named_witnesses
        self._timeout = settings.timeout
        self._feed = feed
        self._lookup = lookup
        self.counts = {"commands_witnessed": 0, "commands_disproved": 0, "contradictions_forgotten": 0}
        self.contradicted: BoundedMap[tuple[str, str], str] = BoundedMap(_MAX_CONTRADICTED, self._on_drop)

    def notes(self) -> tuple[str, ...]:
        """Return a note on the devices that a witness contradicts, for people."""
        return tuple(
            f"{device}: {witness} saw no effect of its last command; `homebot trust {device}` once it is repaired"
            for (device, _), witness in self.contradicted.items()
        )

    def trust(self, request: TrustDeviceRequest) -> TrustDeviceResponse:
        """Forget that witnesses contradicted a device; return the names of these witnesses."""
        places = [place for place in self.contradicted if place[0] == request.device]
        return TrustDeviceResponse(witnesses=tuple([self.contradicted.pop(place) for place in places]))

    async def begin(self, opened: OpenCommand) -> list[Witness]:
        """Return the witnesses of a command about to be sent; each watches until its ``stop_watch`` is called."""
        command = opened.command
        if rises(command.settings) is None or not (wanted := sensed_by(command.settings)):
            return []
        device, part = command.device, command.part
        name = next((name for query, name in self._named if fits(query, PartFacets(device, part))), None)
        if name is None:
            witnesses = _sensors(device, wanted & _METERS, is_named=False)
        else:  # empty if the owner wants no witness
            witnesses = await self._named_sensors(name, wanted) if name else []
        for witness in witnesses:
            on_report = partial(self._on_report, witness, opened.wake)
            witness.stop_watch = self._feed.watch(witness.part.routes, on_report)
        return witnesses

    async def verify(self, opened: OpenCommand, witnesses: list[Witness], outcome: Outcome) -> Outcome:
        """Return *outcome*, or a better one from a witness; named witnesses are awaited."""
        now = self._clock.monotonic()
        if isinstance(outcome, Confirmed):
            return await self._verify_report(opened, witnesses, outcome, now)
        is_silent = isinstance(outcome, NoAnswer) and not outcome.reason
        seeing = _with_answer(Observed.EFFECT, witnesses, opened, now) if is_silent else []
        return self._confirm(opened, seeing[0], outcome) if seeing else outcome

    async def _verify_report(
        self, opened: OpenCommand, witnesses: list[Witness], outcome: Outcome, reported_at: float
    ) -> Outcome:
        """Return the outcome of a command that the device reported as done at *reported_at*."""
        until = now = reported_at
        named = [witness for witness in witnesses if witness.is_named]
        if named:
            until += self._timeout + opened.command.transition
        while isinstance(newest := outcome_of(opened.progress, now), Confirmed):
            if seeing := _with_answer(Observed.EFFECT, witnesses, opened, reported_at):
                return self._confirm(opened, seeing[0], outcome)
            if now >= until:
                contradicting = _with_answer(Observed.NOTHING, named, opened, reported_at)
                return self._contradict(opened, contradicting[0]) if contradicting else outcome
            await opened.wait(until - now)
            now = self._clock.monotonic()
        return newest  # a newer command replaced it, or the device went back

    async def _named_sensors(self, name: str, wanted: frozenset[str]) -> list[Witness]:
        try:
            devices = await self._lookup.find_called(name)
        except ServiceError:
            return []
        return [sensor for device in devices for sensor in _sensors(device, wanted, is_named=True)][:_MAX_NAMED]

    def _on_drop(self, _place: tuple[str, str], _witness: str) -> None:
        self.counts["contradictions_forgotten"] += 1

    def _on_report(
        self, witness: Witness, wake: Callable[[], None], capability: str, value: PlainValue, *_: object
    ) -> None:
        if capability == witness.capability:
            witness.newest, witness.seen_at = value, self._clock.monotonic()
            wake()

    def _confirm(self, opened: OpenCommand, witness: Witness, outcome: Outcome) -> Outcome:
        command = opened.command
        self.counts["commands_witnessed"] += 1
        self.contradicted.pop(command.place, None)
        reported = outcome.latency if isinstance(outcome, Confirmed) else 0.0
        latency = max(reported, witness.seen_at - opened.progress.given_at)
        return Confirmed(
            latency, Evidence.WITNESSED, witness.name, command_id=command.id, reported=opened.progress.reported
        )

    def _contradict(self, opened: OpenCommand, witness: Witness) -> Outcome:
        command = opened.command
        self.counts["commands_disproved"] += 1
        self.contradicted[command.place] = witness.name
        saw = f"{witness.name} measured no change"
        self._node.log.warning(
            CONTRADICTED, message=f"{command.label}: {saw}", device=command.device.id, command=command.id
        )
        return Contradicted(saw, witness.name, command_id=command.id)


def _with_answer(
    answer: Observed, witnesses: Iterable[Witness], opened: OpenCommand, reported_at: float
) -> list[Witness]:
    """Return the witnesses with that *answer* about a command that the device reported as done at *reported_at*."""
    is_rise = rises(opened.command.settings) is True
    return [
        witness
        for witness in witnesses
        if observed(
            witness.capability, witness.before, witness.newest, is_rise=is_rise, is_heard=witness.seen_at > reported_at
        )
        is answer
    ]


def _sensors(device: Device, wanted: frozenset[str], *, is_named: bool) -> list[Witness]:
    """Return the sensors of a device that measure one of *wanted*, except silent and stale ones."""
    if device.freshness != "fresh" or device.reachable.state == "no":
        return []
    sensors: list[Witness] = []
    for state in device.states:
        if state.capability in wanted and state.live and state.part not in device.offline_parts:
            part, value = device.part(state.part), state.value.plain()
            if part is not None and any(
                capability.name == state.capability and capability.readable and not capability.settable
                for capability in part.part.capabilities
            ):
                sensors.append(Witness(device.name, is_named, part, state.capability, value, value))
    return sensors


class Observed(Enum):
    """Answer of a sensor about a command."""

    EFFECT = "effect"
    NOTHING = "nothing"
    UNCLEAR = "unclear"


class _Sense(NamedTuple):
    """Signs of an effect in the values of a sensor.

    Attributes:
        least: The smallest change that counts; 0 for a binary sensor.
        shows_fall: Whether a value that does not fall proves that nothing happened; daylight may hide a lamp.
    """

    least: float = 0.0
    shows_fall: bool = True


_SENSES: Final[Mapping[str, _Sense]] = MappingProxyType(
    {
        "contact": _Sense(),
        "unlocked": _Sense(),
        "power": _Sense(1.0),
        "flow": _Sense(0.02),
        "illuminance": _Sense(2.0, shows_fall=False),
    }
)
"""Sensors that show an effect within seconds; motion has other causes, and temperature is slow."""

_SENSED_BY: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "on_off": ("illuminance", "power"),
        "level": ("illuminance", "power"),
        "fan_speed": ("power",),
        "position": ("contact",),
        "movement": ("contact",),
        "lock": ("unlocked",),
        "valve": ("flow",),
    }
)
_RISING: Final[Mapping[PlainValue, bool]] = MappingProxyType(
    {True: True, False: False, "open": True, "closed": False, "unlocked": True, "locked": False}
)
_SHARE: Final = 0.1
"""The smallest change of a number, as a fraction of its previous value."""


def sensed_by(settings: Iterable[str]) -> frozenset[str]:
    """Return the sensor capabilities that may show a change of *settings*."""
    return frozenset().union(*filter(None, map(_SENSED_BY.get, settings)))


def rises(settings: Mapping[str, PlainValue]) -> bool | None:
    """Return whether a command makes something stronger or opens it; None if uncertain: a level may dim."""
    for value in settings.values():
        if isinstance(value, float):
            if value == 0.0:
                return False
        elif value in _RISING:
            return _RISING[value]
    return None


def observed(capability: str, before: PlainValue, newest: PlainValue, *, is_rise: bool, is_heard: bool) -> Observed:
    """Return the observation of a rise or fall from the values of *capability* before the command and now.

    Args:
        is_heard: Whether the sensor reported after the device.
    """
    if isinstance(before, bool) and isinstance(newest, bool):
        if before is is_rise:
            return Observed.UNCLEAR  # it was already so
        return Observed.EFFECT if newest is is_rise else Observed.NOTHING
    if not (isinstance(before, float) and isinstance(newest, float)):
        return Observed.UNCLEAR
    sense = _SENSES[capability]
    change = newest - before if is_rise else before - newest
    if change >= max(sense.least, _SHARE * abs(before)):
        return Observed.EFFECT
    if not is_heard:
        return Observed.UNCLEAR
    is_nothing = newest < sense.least if is_rise else sense.shows_fall and change <= 0.0 < before - sense.least
    return Observed.NOTHING if is_nothing else Observed.UNCLEAR
