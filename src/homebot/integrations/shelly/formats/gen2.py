"""Devices of Shelly's second generation and later: their discovery by requests. Pure.

These devices do not announce themselves. After any message of a device, homebot requests its info, its configuration,
its status and the components added to it, such as Bluetooth sensors; the status completes the description. A sleeping
device sends its whole status when it wakes, which is enough. A device that does not answer is described by the
components that it reports, if its topics begin with its own id.

Source: Shelly Gen2+ API, General (RPC Protocol, Notifications) and MQTT.
"""

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceRequest, DeviceWithdrawn, Publication
from homebot.conventions.payload import as_fields, parse_object, shown, text_of, to_json
from homebot.errors import WireError
from homebot.integrations.shelly.formats.gen2_component import COMPONENTS, call, components_from, page_name
from homebot.integrations.shelly.formats.gen2_device import (
    ANSWERS,
    Gen2Device,
    is_config_change,
    is_prefix,
    kind_of,
    mac_in,
)
from homebot.integrations.shelly.formats.status import Fields

MAX_ANSWER_BYTES = 128 * 1024
"""Longest answer; the one of a gateway with all possible sensors has about 40 kB."""

_MAX_DEVICES = 3000
_MAX_KEPT_BYTES = 32 * 1024 * 1024


class Gen2:
    """Registry of the devices of the second generation.

    Of more than 3,000 devices the oldest undescribed one is dropped; of more than 32 MB of answers the newest.

    Args:
        client: The client id of homebot; answers come on ``<client>/rpc`` and ``<client>/<prefix>/rpc``.
    """

    def __init__(self, client: str) -> None:
        self._client = client
        self._devices: BoundedDict[Gen2Device] = BoundedDict(_MAX_DEVICES, self._release)
        self._kept = 0
        self._refused = 0

    def knows(self, prefix: str) -> bool:
        """Return whether a device of this generation was seen at *prefix*."""
        return self._devices.get(prefix) is not None

    @property
    def dropped(self) -> int:
        """Number of dropped devices and answers."""
        return self._devices.dropped + self._refused

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Read a message on one of the filters.

        Raises:
            WireError: An answer breaks the rules.
        """
        if topic == f"{self._client}/rpc":
            return self._on_answer("", payload)
        if topic.startswith(f"{self._client}/") and topic.endswith("/rpc"):
            return self._on_answer(topic.removeprefix(f"{self._client}/").removesuffix("/rpc"), payload)
        if topic.endswith("/events/rpc"):
            return self._on_notification(topic, payload)
        prefix, _, component = topic.partition("/status/")
        if component:
            device = self._device(prefix) if mac_in(prefix) else None
            if device is None or device.has_status:
                return ()
            return self._add_components(device, {component: to_json(payload)}, topic, len(payload))
        prefix = topic.removesuffix("/online")
        if not payload:
            return self._on_gone(prefix)
        if payload != b"true":
            return ()
        device = self._device(prefix)
        if device is None:
            return ()
        if device.described:
            return () if retained else (self._request(device),)
        return (self._request(device),) if retained else self._requests(device)

    def _on_notification(self, topic: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        prefix = topic.removesuffix("/events/rpc")
        frame = as_fields(to_json(payload))
        device = self._device(prefix) if frame else None
        method, params = frame.get("method"), frame.get("params")
        if device is None or not isinstance(params, dict):
            return ()
        if device.has_status and device.described:
            return (self._request(device),) if method == "NotifyEvent" and is_config_change(params) else ()
        if method == "NotifyStatus" and mac_in(prefix):
            return self._add_components(device, params, topic, len(payload))
        requests = self._requests(device)
        if method == "NotifyFullStatus" and self._record_answer(device, "status", params, len(payload)):
            return self._described(device, topic, text_of(frame.get("src"))) + requests
        return requests

    def _add_components(
        self, device: Gen2Device, components: Fields, topic: str, size: int
    ) -> tuple[AnnouncementEvent, ...]:
        """Describe *device* by its published *components* before its first answer."""
        requests = self._requests(device)
        kept = device.sizes.get("components", 0) + size
        if not device.has_new_fields(components) or not self._has_room(device, "components", kept):
            return requests
        device.add_components(components, kept)
        return self._described(device, topic, device.prefix) + requests

    def _on_gone(self, prefix: str) -> tuple[AnnouncementEvent, ...]:
        device = self._devices.remove(prefix)
        if device is None:
            return ()
        self._release(device)
        return tuple(DeviceWithdrawn(key, "its online topic was removed") for key in device.described)

    def _release(self, device: Gen2Device) -> None:
        self._kept -= sum(device.sizes.values())

    def _on_answer(self, prefix: str, payload: bytes) -> tuple[AnnouncementEvent, ...]:
        frame = parse_object(payload, MAX_ANSWER_BYTES)
        result, source = frame.get("result"), frame.get("src")
        if not isinstance(result, dict):
            return ()
        if not isinstance(source, str):
            raise WireError(f"a response has the invalid src {shown(source)}")
        device = self._device(prefix or source)
        kind = kind_of(result)
        if device is None or not kind:
            return ()
        if kind == "components":
            size, following = len(payload), 0
            start = device.page_start(result)
            if start is not None and self._has_room(device, page_name(start), size):
                following = device.add_page(result, start, size)
            if following:
                key = f"{device.prefix}#{page_name(following)}"  # another key than that of a request of all answers
                return (DeviceRequest(key, (self._call_components(device, following),)),)
        elif not self._record_answer(device, kind, result, len(payload)):
            return ()
        return self._described(device, f"{device.prefix}/rpc", text_of(source))

    def _device(self, prefix: str) -> Gen2Device | None:
        return self._devices.find(prefix, lambda: Gen2Device(prefix)) if is_prefix(prefix) else None

    def _requests(self, device: Gen2Device) -> tuple[AnnouncementEvent, ...]:
        """Return a request at the first, second, fourth, eighth … sign of life: it may be no Shelly at all."""
        device.signs_of_life += 1
        return (self._request(device),) if device.signs_of_life & (device.signs_of_life - 1) == 0 else ()

    def _request(self, device: Gen2Device) -> DeviceRequest:
        source = f"{self._client}/{device.prefix}"
        calls = [call(device.prefix, source, method) for method in ANSWERS.values()]
        device.pages_asked = 0
        return DeviceRequest(device.prefix, (*calls, self._call_components(device, 0)))

    def _call_components(self, device: Gen2Device, offset: int) -> Publication:
        return call(device.prefix, f"{self._client}/{device.prefix}", COMPONENTS, components_from(offset))

    def _record_answer(self, device: Gen2Device, kind: str, result: Fields, size: int) -> bool:
        if not self._has_room(device, kind, size):
            return False
        device.record_answer(kind, result, size)
        return True

    def _has_room(self, device: Gen2Device, kind: str, size: int) -> bool:
        """Reserve *size* bytes for an answer of *kind*; return whether there is room."""
        grown = size - device.sizes.get(kind, 0)
        if size > MAX_ANSWER_BYTES or self._kept + grown > _MAX_KEPT_BYTES:
            self._refused += 1
            return False
        self._kept += grown
        return True

    def _described(self, device: Gen2Device, topic: str, device_id: str) -> tuple[AnnouncementEvent, ...]:
        if not device.status or not device.mac:
            return ()
        described, gone = device.describe(self._client, topic, device_id, needs_parts=True)
        if device.described:
            self._devices.pin(device.prefix)
        return (*described, *(DeviceWithdrawn(key, "it has no components left") for key in gone))
