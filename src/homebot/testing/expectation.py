"""The wait for values of one device, in terms of its handles."""

import math
from collections.abc import Iterator, Mapping
from typing import Final, final

import anyio

from homebot.devices import handles
from homebot.devices.device import Device, DeviceChange, StateChange
from homebot.devices.device_names import devices_called
from homebot.devices.handles import Handle
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.errors import UsageError
from homebot.support.names import did_you_mean
from homebot.units import parse_duration

_UNKNOWN: Final = object()
_KINDS: Final = tuple(
    kind
    for name in handles.__all__
    if isinstance(kind := getattr(handles, name), type) and issubclass(kind, Handle) and kind.service_types
)
"""All kinds of handles for specific device types."""

_TOLERANCE: Final = 0.01
"""Share by which a number may differ, as devices round levels and temperatures."""


@final
class Expectation(HouseWatcher):
    """The expected values of one device, such as ``on=False``."""

    def __init__(self, view: HouseView, name: str, values: Mapping[str, object]) -> None:
        if not values:
            raise UsageError(f"say what {name} is to become, for example on=False")
        self._view = view
        self._name = name
        self._values = values
        self._news = anyio.Event()
        self._known: dict[str, Device] = {}

    def on_device(self, change: DeviceChange) -> None:
        """Handle a change of a device."""
        if change.kind == "removed":
            self._known.pop(change.device.id, None)
        else:
            self._known[change.device.id] = change.device
        self._news.set()

    def on_values(self, change: StateChange) -> None:
        """Check again."""
        del change
        self._news.set()

    def close(self) -> None:
        """Check for the last time."""
        self._news.set()

    async def wait(self, within: str | float) -> None:
        """Return when the device has the values.

        Raises:
            AssertionError: It has other values at the end of the time; the message lists them.
        """
        __tracebackhide__ = True
        self._view.add(self)
        try:
            with anyio.move_on_after(parse_duration(within)):
                while any(not _is_equal(seen, wanted) for seen, wanted in self._seen()):
                    await self._news.wait()
                    self._news = anyio.Event()
                return
            problem = self._problem()
        finally:
            self._view.remove(self)
        wanted = ", ".join(f"{word}={value!r}" for word, value in self._values.items())
        time = within if isinstance(within, str) else f"{within:g} s"
        raise AssertionError(f"{self._name} did not become {wanted} within {time}: {problem}")

    def _seen(self) -> Iterator[tuple[object, object]]:
        present = self._present()
        yield from ((present.get(word, _UNKNOWN), value) for word, value in self._values.items())

    def _problem(self) -> str:
        if self._device() is None:
            known = sorted({device.name or device.id for device in self._known.values()})
            return f"there is no such device; {did_you_mean(self._name, known, f'there are {_list(known)}')}"
        present = self._present()
        for word in self._values:
            if word not in present:
                hint = did_you_mean(word, present, f"its values are {_list(sorted(present))}")
                return f"it has no value {word!r}; {hint}"
        return f"it is {', '.join(f'{word}={present[word]!r}' for word in self._values)}"

    def _present(self) -> Mapping[str, object]:
        """Return the current values of the device by property and capability; of several parts the first known."""
        device = self._device()
        view = None if device is None else self._view.get(device.id)
        values: dict[str, object] = {}
        if view is None:
            return values
        for part in view.device.parts:
            for kind in _KINDS:
                if part.part.service_type in kind.service_types:
                    handle = kind(view, part.id, self._view)
                    values |= {word: getattr(handle, word) for word in _words(kind) if values.get(word) is None}
        for state in view.current().states:  # a thermostat's temperature may belong to another part
            if values.get(state.capability) is None:
                values[state.capability] = state.value.plain()
        return values

    def _device(self) -> Device | None:
        devices = self._known.values()
        named = [device for device in devices if device.id == self._name or device.id.rpartition("/")[2] == self._name]
        named = named or [*devices_called(self._name, devices)]
        if len(named) > 1:
            raise UsageError(f"{self._name} may be {_list([device.id for device in named])}; give the id of one")
        return named[0] if named else None


def _words(kind: type[Handle]) -> Iterator[str]:
    """Yield the names of values of handles of *kind*, without those of every handle."""
    for owner in kind.__mro__:
        if owner is not Handle:
            yield from (name for name, attribute in vars(owner).items() if isinstance(attribute, property))


def _is_equal(present: object, wanted: object) -> bool:
    if isinstance(present, float) and isinstance(wanted, int | float) and not isinstance(wanted, bool):
        return math.isclose(present, wanted, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE)
    return present == wanted


def _list(names: list[str]) -> str:
    return ", ".join(names) or "none"
