"""A Shelly of the second generation on a channel of its own, such as a WebSocket. Pure.

The frames of all channels are alike, so that parts read and write here what they do over MQTT; only the topics that
stand for the three kinds of frames are names without a broker behind them.

Source: Shelly Gen2+ API, General: RPC Protocol, RPC Channels (WebSocket), Notifications.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.conventions.payload import Readings, as_fields, compact_json, parse_object
from homebot.conventions.shelly.gen2_component import Fields
from homebot.conventions.shelly.gen2_device import Gen2Device, is_config_change, looks, sleeps
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.numbers import to_number

__all__ = ["ANSWERS", "CLIENT", "AnswerKind", "Gen2RpcDevice", "RpcCall", "is_news_of_setup"]

CLIENT = "homebot"
"""As whom a device is called."""

AnswerKind = Literal["info", "config", "status"]

ANSWERS: Mapping[AnswerKind, str] = {
    "info": "Shelly.GetDeviceInfo",
    "config": "Shelly.GetConfig",
    "status": "Shelly.GetStatus",
}
"""The methods whose answers describe a device, in the order in which they are called."""

_DAILY = 24 * 3600.0
_MOST_SILENT = 7 * _DAILY
_MISSED = 2.5


@dataclass(frozen=True, slots=True)
class RpcCall:
    """A call of a method of the device.

    Attributes:
        method: The method: ``Switch.Set``.
        params: Its parameters.
    """

    method: str
    params: Fields


class Gen2RpcDevice:
    """One device, by its answers and notifications.

    Args:
        device_id: Its id: ``shellyplus1-a8032abe54dc``.
    """

    def __init__(self, device_id: str) -> None:
        self._device = Gen2Device(device_id)
        self._parts: dict[str, DescribedPart] = {}
        self._notifications = f"{device_id}/events/rpc"
        self._answers = f"{CLIENT}/{device_id}/rpc"

    def keep(self, kind: AnswerKind, answer: Fields, size: int) -> None:
        """Take an answer of *size* bytes in the place of the last of its *kind*."""
        self._device.keep(kind, answer, size)

    def keep_components(self, page: Fields) -> int:
        """Take a page of the answer to ``Shelly.GetComponents``: what people and gateways added to the device.

        They count once the last page is there, in the place of those before.

        Returns:
            The number of components on all pages so far; 0 where that was the last page.
        """
        start = self._device.page_start(page)
        return 0 if start is None else self._device.keep_page(page, start, 0)

    def components_status(self) -> bytes:
        """Return what :meth:`keep_components` took, as an answer to ``Shelly.GetStatus``."""
        status = {key: one.get("status") for key, one in self._device.added.items()}
        return compact_json({"result": status}).encode(errors="replace")

    def describe(self) -> DeviceAnnounced | None:
        """Return its description by its answers; None where that is the same as before. The first may lack parts."""
        device = self._device
        described = device.describe(CLIENT, "", device.prefix)
        if device.described is not None and looks(device.described) == looks(described):
            return None
        device.described = described
        self._parts = {one.part.id: one for one in described.parts}
        return described

    @property
    def stale_after(self) -> float:
        """Seconds of silence after which it is missed, where it sleeps most of the time; 0 where it does not."""
        if not sleeps(self._device.status):
            return 0.0
        period = to_number(as_fields(self._device.status.get("sys")).get("wakeup_period")) or _DAILY
        return _MISSED * min(period, _MOST_SILENT)

    def read_notification(self, frame: bytes) -> Iterator[tuple[str, Readings]]:
        """Yield what *frame*, a notification, reports of each part that it reports anything of, by the part's id."""
        return self._read(self._notifications, frame)

    def read_status(self, frame: bytes) -> Iterator[tuple[str, Readings]]:
        """Yield likewise what *frame*, the answer to ``Shelly.GetStatus``, reports."""
        return self._read(self._answers, frame)

    def calls(self, part: str, capability: str, value: PlainValue, transition: float) -> tuple[RpcCall, ...]:
        """Return the calls by which a *part* gets a value.

        Raises:
            RefusedError: There is no such part, it cannot do that, or the value is out of its bounds.
        """
        described = self._parts.get(part)
        if described is None:
            raise RefusedError(f"a command to {part[:60]!r}", "the device has no such part any more")
        return tuple(
            RpcCall(str(frame["method"]), as_fields(frame.get("params")))
            for publication in described.codec.write(capability, value, transition=transition)
            for frame in (parse_object(publication.payload),)
        )

    def _read(self, topic: str, frame: bytes) -> Iterator[tuple[str, Readings]]:
        for part_id, described in self._parts.items():
            if readings := described.codec.read(topic, frame, retained=False):
                yield part_id, readings


def is_news_of_setup(frame: Fields) -> bool:
    """Return whether *frame* says that the device is set up anew, so that it has to be asked again."""
    return frame.get("method") == "NotifyEvent" and is_config_change(as_fields(frame.get("params")))
