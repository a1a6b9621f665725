"""Looks at a topic, or at a device: the mean of its value for a second."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from functools import partial
from itertools import chain, pairwise
from statistics import fmean, median, variance
from typing import TYPE_CHECKING, Any, Final, Self

import anyio

from homebot.errors import InvalidNameError, UsageError
from homebot.features.identify.pictures import Region, brightness, compressed_brightness
from homebot.graph.qos import qos_profile_sensor_data
from homebot.messages.definition import fields_of
from homebot.support.folding import fold
from homebot.support.names import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.device_lookup import DeviceLookup
    from homebot.graph import Node
    from homebot.messages.message import Message

_LOOK: Final = 1.0
"""Seconds of a look."""

_MAX_SILENCE_S: Final = 5.0
"""Seconds without a value after which the sensor is too slow, or dead."""

_MAX_VALUES: Final = 200
_MAX_PICTURES: Final = 10
"""Values of a look: a picture costs some milliseconds."""

_PROMPT: Final = 2.0
"""Seconds for a device that has reported since the last look."""

_UNREPORTED: Final = 0.25
"""The change that a sensor may leave unreported, as a share of its value: many report changes of a fifth, or less."""

_SILENT: Final = 3
_AGAIN: Final = 0.2
"""Seconds between two questions for the state of a device."""

_MARGIN: Final = 1.2
_JUMPING: Final = 6.0
"""Factor of the median variance, as that of few values is below their mean; and of that which a look with a jump has at
least."""

_PICTURES: Final = {"sensor_msgs/msg/Image": brightness, "sensor_msgs/msg/CompressedImage": compressed_brightness}
_NUMBERS: Final = frozenset({f"{kind}{bits}" for kind in ("int", "uint", "float") for bits in (8, 16, 32, 64)})
_MAX_NAMED: Final = 8
_LARGEST: Final = 1e12
_NO_VALUES: Final = frozenset({"variance", "stamp", "header"})


_MAX_LOOKS: Final = 100
_MAX_COARSE_VALUES: Final = 4
"""Values and looks: those of a sensor with fine steps differ in each look."""

_COARSE: Final = 0.05
"""Steps of a sensor above this share of what it sees are coarser than the least effect by default."""

_TIMES_AT_END: Final = 4
_OFTEN, _NEAR_END = 2, 5
"""How often, and how much more often than the values below it, the largest value comes at the end of a range."""


class Noise:
    """The usual variance of the values of a sensor, from those of all looks, each about its own mean. Pure."""

    def __init__(self) -> None:
        self._variances: list[float] = []
        self._looks: deque[Sequence[float]] = deque(maxlen=_MAX_LOOKS)

    @property
    def trouble(self) -> str:
        """The reason for which no look decides: the sensor is at the end of its range, or too coarse; else empty."""
        counts = Counter(chain.from_iterable(self._looks))
        values = sorted(counts)
        step = min((after - before for before, after in pairwise(values)), default=math.inf)
        is_coarse = bool(values) and step > _COARSE * values[-1]
        if is_coarse and len(values) <= _MAX_COARSE_VALUES <= len(self._looks) and counts.total() > len(self._looks):
            return (
                f"what is seen has only the values {', '.join(f'{value:g}' for value in values)}: too coarse for this"
            )
        top, *others = reversed(values)
        if (
            others
            and counts[top] >= _TIMES_AT_END
            and counts[top] > _OFTEN * max(map(counts.__getitem__, others[:_NEAR_END]))
        ):
            return f"what is seen ends at {top:g}: it is too bright for the sensor"
        return ""

    def of(self, values: Sequence[float]) -> tuple[float, float]:
        """Return the mean of the values of one look, and its variance: more than usual if they jump."""
        self._looks.append(tuple(values))
        mean, own = fmean(values), variance(values) if len(values) > 1 else 0.0
        self._variances += [own] if len(values) > 1 else []
        usual = _MARGIN * median(self._variances or [0.0])
        return mean, (own if own > _JUMPING * usual else usual) / len(values)


class Sight(ABC):
    """View of a sensor, while it is entered.

    Attributes:
        is_prompt: Whether each look has values of its own.
        slack: By how much the last values may be wrong, as a share of them, because the sensor reported no change.
    """

    is_prompt = True

    def __init__(self) -> None:
        self.slack = 0.0
        self._noise = Noise()
        self._closing = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()

    @property
    def trouble(self) -> str:
        """The reason for which no look decides; empty if there is none."""
        return self._noise.trouble

    @abstractmethod
    async def values(self) -> Sequence[float]:
        """Return the values of a second, at least one; raise `UsageError` if there is none, or none can be read."""

    async def look(self) -> tuple[float, float]:
        """Look for a second; return the mean, and its variance."""
        mean, spread = self._noise.of(await self.values())
        return mean, max(spread, (max(1e-3, self.slack) * mean) ** 2 + 1e-12)


async def open_sight(node: Node, lookup: DeviceLookup, topic: str, region: Region, rooms: Collection[str]) -> Sight:
    """Return the sight of *topic*: a topic, or the id or name of a device; empty for the light sensor in *rooms*.

    Raises:
        UsageError: There is no such topic or device, or it has no value that can be read.
    """
    seeing = [
        device for device in await lookup.devices() if any(state.capability == "illuminance" for state in device.states)
    ]
    devices = await lookup.find_called(topic) if topic else [device for device in seeing if fold(device.area) in rooms]
    if len(devices) == 1 and devices[0].id in {device.id for device in seeing}:
        return _DeviceSight(node, lookup, devices[0].id)
    topics = [name for name, ros_type in node.graph.get_topic_names_and_types().items() if _may_fit(ros_type)]
    known = [*(device.name for device in seeing), *topics]
    some = f"there are {', '.join(known[:_MAX_NAMED])}" if known else "a robot has to publish it first"
    if not topic:
        reason = f"{len(devices)} light sensors are in its room" if rooms else "it is in no room"
        raise UsageError(f"say what looks, with `topic` (`--with`), as {reason}; {some}")
    try:
        name = node.resolve_name(topic)
    except InvalidNameError:
        name = topic  # of a device, with a space
    message_type = node.graph.get_message_type(name)
    if message_type is None:
        hint = did_you_mean(topic, known, some)
        raise UsageError(f"there is no topic {name}, nor a device with a light sensor; {hint}")
    return _TopicSight(node, name, message_type, region)


def _may_fit(ros_type: str) -> bool:
    return ros_type.startswith(("sensor_msgs/", "std_msgs/"))


class _TopicSight(Sight):
    def __init__(self, node: Node, name: str, message_type: type[Message], region: Region) -> None:
        super().__init__()
        self._node, self._name, self._type = node, name, message_type
        self._clock = node.graph.clock
        read = _PICTURES.get(message_type.ros_type)
        self._read: Callable[[Any], float] = _number_of(message_type) if read is None else partial(read, region=region)
        self._gap = 0.9 * _LOOK / (_MAX_VALUES if read is None else _MAX_PICTURES)
        self._values: list[float] | None = None
        self._problem = ""
        self._last_at = 0.0
        self._has_come = anyio.Event()

    def __enter__(self) -> Self:
        qos = qos_profile_sensor_data
        self._closing.callback(self._node.create_subscription(self._type, self._name, self._on_message, qos).close)
        return self

    def _on_message(self, message: Message) -> None:
        """Read *message* for a look that is under way; one that cannot be read is left out."""
        now = self._clock.monotonic()
        if self._values is None or now - self._last_at < self._gap:
            return
        self._last_at = now
        try:
            self._values.append(self._read(message))
        except UsageError as exc:
            self._problem = f"nothing on {self._name} can be read: {exc}"
        else:
            self._has_come.set()

    async def values(self) -> Sequence[float]:
        values = self._values = []
        self._problem = f"nothing was published on {self._name} within {_MAX_SILENCE_S:g} s; is its robot on?"
        self._has_come, self._last_at = anyio.Event(), -_LOOK
        try:
            await anyio.sleep(_LOOK)
            with anyio.move_on_after(_MAX_SILENCE_S - _LOOK):
                await self._has_come.wait()
        finally:
            self._values = None
        if not values:
            raise UsageError(self._problem)
        return values


class _DeviceSight(Sight):
    """View of a sensor that may report changes alone: what it does not report in five seconds has changed little."""

    is_prompt = False

    def __init__(self, node: Node, lookup: DeviceLookup, device_id: str) -> None:
        super().__init__()
        self._clock, self._lookup, self._device = node.graph.clock, lookup, device_id
        self._last_at = self._clock.now()
        self._silent_looks = 0

    async def values(self) -> Sequence[float]:
        began, passed, known, by_time, longest = self._clock.now(), 0.0, 0.0, dict[float, float](), _MAX_SILENCE_S
        while passed < _LOOK or (not by_time and passed < longest):
            await anyio.sleep(_AGAIN)
            device, passed = await self._lookup.device(self._device), self._clock.now() - began
            states = () if device is None else device.states
            readings = [
                state
                for state in states
                if state.capability == "illuminance" and isinstance(state.value.plain(), float)
            ]
            if not readings:
                raise UsageError(f"{self._device} is gone, or its illuminance is unknown")
            known, at = readings[0].value.number, readings[0].told_at.to_seconds()
            by_time |= {at: known} if at > began else {}
            longest = _MAX_SILENCE_S if at < self._last_at else _PROMPT
        is_silent = not by_time and longest == _MAX_SILENCE_S
        self._last_at, self._silent_looks = self._clock.now(), self._silent_looks + 1 if is_silent else -_MAX_VALUES
        if self._silent_looks >= _SILENT:  # the first, one with all dark, and one with all bright
            raise UsageError(f"{self._device} reported nothing while all changed: it sees none of them, or is too slow")
        self.slack = _UNREPORTED if is_silent else 0.0
        return [*by_time.values()] or [known]


def _number_of(message_type: type[Message]) -> Callable[[Any], float]:
    """Return what reads the only number of a message.

    Raises:
        UsageError: It has none, or several.
    """
    fields = fields_of(message_type)
    numbers = [
        field.name
        for field in fields
        if field.ros_type in _NUMBERS and not field.is_array and field.name not in _NO_VALUES
    ]
    if len(numbers) != 1:
        raise UsageError(
            f"{message_type.ros_type} has {len(numbers) or 'no'} numbers; take a topic with one, such as "
            "sensor_msgs/Illuminance or std_msgs/Float64, or with pictures"
        )

    def number(message: object) -> float:
        value = float(getattr(message, numbers[0]))
        if not abs(value) <= _LARGEST:
            raise UsageError(f"{value:g} is no value of a sensor")
        return value

    return number
