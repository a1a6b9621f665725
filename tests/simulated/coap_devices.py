"""Simulated devices that are CoAP servers: they describe themselves, can be observed, and register in a directory.

A *lamp* has a Thing Description; any other kind has a resource of IPSO and none. They know nothing of homebot.
"""

import json
import socket
from collections.abc import Callable, Mapping
from typing import Any

import aiocoap
import aiocoap.error
import anyio
from aiocoap import resource
from aiocoap.numbers.codes import Code

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import lamp_order
from homebot.support.isolation import run_as
from homebot.support.numbers import to_number

TEXT, LINK_FORMAT, JSON, TD = 0, 40, 50, 432
_LIFETIME = 60

_SENSORS: Mapping[str, tuple[str, str, str]] = {
    "lux": ("3301", "0", "5700"),
    "motion": ("3302", "0", "5500"),
    "thermostat": ("3303", "0", "5700"),
}
"""The paths of IPSO."""


class CoapDevice(ServedDevice):
    """A lamp with a Thing Description, or a sensor with a resource of IPSO.

    Args:
        port: The port; 0 for any free one, which it keeps.
        directory: The resource directory for its registration: ``coap://127.0.0.1:5683``; empty for none.
        groups: Multicast groups to join, each with the name of an interface.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        directory: str = "",
        groups: tuple[tuple[str, str], ...] = (),
    ) -> None:
        super().__init__(device, on_command)
        self.port = port or _free_port(host)
        self._host = host
        self._directory = directory.rstrip("/")
        self._groups = groups
        self._resources = tuple(self._make_resources())
        self._registration = ""
        self._context: aiocoap.Context | None = None

    @property
    def uri(self) -> str:
        """Its address."""
        return f"coap://{self._host if ':' not in self._host else f'[{self._host}]'}:{self.port}"

    async def serve(self) -> None:
        """Serve until cancelled."""
        site = resource.Site()
        site.add_resource(
            [".well-known", "core"], resource.WKCResource(site.get_resources_as_linkheader, impl_info=None)
        )
        for path, leaf in self._resources:
            site.add_resource(path, leaf)
        context = await aiocoap.Context.create_server_context(
            site, bind=(self._host, self.port), multicast=list(self._groups), transports=["udp6"]
        )
        self._context = context
        try:
            async with anyio.create_task_group() as tasks:
                if self._directory:
                    tasks.start_soon(run_as, "a registration", self._stay_registered)
                await anyio.sleep_forever()
        finally:
            self._context = None
            with anyio.CancelScope(shield=True):
                await context.shutdown()

    def show(self) -> None:
        """Notify the observers."""
        for _, leaf in self._resources:
            if isinstance(leaf, _StateResource):
                leaf.updated_state()

    async def register(self) -> None:
        """Register in the directory or renew that (RFC 9176, section 5); raise OSError on a refusal or silence."""
        query = f"ep={self.device.device_id}&lt={_LIFETIME}"  # the request's source is its address
        links = ",".join(_link(path, leaf) for path, leaf in self._resources).encode()
        if self._registration:
            await self._request_directory(Code.POST, f"{self._directory}{self._registration}")
            return
        root = await self._request_directory(Code.GET, f"{self._directory}/.well-known/core?rt=core.rd")
        path = root.payload.decode().partition("<")[2].partition(">")[0]
        answer = await self._request_directory(Code.POST, f"{self._directory}{path}?{query}", links)
        self._registration = "/" + "/".join(answer.opt.location_path)

    async def deregister(self) -> None:
        """Remove its registration while it stays online; raise OSError on a refusal or silence."""
        path, self._registration = self._registration, ""
        await self._request_directory(Code.DELETE, f"{self._directory}{path}")

    async def _stay_registered(self) -> None:
        while True:
            try:
                await self.register()
            except OSError:
                self._registration = ""
                await anyio.sleep(1.0)
            else:
                await anyio.sleep(_LIFETIME / 2)

    async def _request_directory(self, code: Code, uri: str, payload: bytes = b"") -> aiocoap.Message:
        if self._context is None:
            raise ConnectionError("the device has no power")
        message = aiocoap.Message(code=code, uri=uri, payload=payload)
        if payload:
            message.opt.content_format = LINK_FORMAT
        try:
            answer = await self._context.request(message).response
        except aiocoap.error.Error as exc:
            raise ConnectionError(f"{uri}: {exc!r}") from exc
        if not answer.code.is_successful():
            raise ConnectionError(f"{uri}: {answer.code}")
        return answer

    def _make_resources(self) -> list[tuple[tuple[str, ...], resource.Resource]]:
        if self.device.kind == "lamp":
            return [
                (("on",), _StateResource(lambda: self.state.is_on, self._switch, "light")),
                (("brightness",), _StateResource(lambda: round(self.state.brightness * 254), self._dim, "light")),
                ((".well-known", "wot"), _ThingResource(self._description)),
            ]
        return [
            (_SENSORS[self.device.kind], _StateResource(lambda: _sensed(self.device.kind, self.state), None, "ipso"))
        ]

    def _switch(self, value: object) -> bool:
        if not isinstance(value, bool):
            return False
        self._command(lamp_order(is_on=value))
        return True

    def _dim(self, value: object) -> bool:
        number = to_number(value)
        if number is None or not 0 <= number <= 254:
            return False
        self._command(lamp_order(brightness=number / 254))
        return True

    def _command(self, texts: tuple[str, ...]) -> None:
        for text in texts:
            self.on_command(text)

    def _description(self) -> dict[str, object]:
        on = {"type": "boolean", "@type": "OnOffProperty", "title": "On", "observable": True}
        brightness = {
            "type": "integer",
            "minimum": 0,
            "maximum": 254,
            "@type": "BrightnessProperty",
            "observable": True,
        }
        return {
            "@context": ["https://www.w3.org/2022/wot/td/v1.1", {"cov": "https://www.w3.org/2019/wot/coap#"}],
            "id": f"urn:dev:homebot-house:{self.device.home}:{self.device.device_id}",
            "title": self.device.device_id,
            "@type": "Light",
            "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
            "security": "nosec_sc",
            "properties": {
                "on": on | {"forms": _forms("/on")},
                "brightness": brightness | {"forms": _forms("/brightness")},
            },
        }


class _StateResource(resource.ObservableResource):  # type: ignore[misc]  # the library has no types
    """One value of the device, in JSON."""

    ct = str(JSON)

    def __init__(self, value: Callable[[], object], write: Callable[[object], bool] | None, kind: str) -> None:
        super().__init__()
        self.rt = kind
        self.if_ = "core.s" if write is None else "core.a"
        self._value = value
        self._write = write

    async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
        del request
        return aiocoap.Message(payload=json.dumps(self._value()).encode(), content_format=JSON)

    async def render_put(self, request: aiocoap.Message) -> aiocoap.Message:
        if self._write is None:
            return aiocoap.Message(code=Code.METHOD_NOT_ALLOWED)
        try:
            value = json.loads(request.payload[:1000])
        except ValueError:
            return aiocoap.Message(code=Code.BAD_REQUEST)
        return aiocoap.Message(code=Code.CHANGED if self._write(value) else Code.BAD_REQUEST)


class _ThingResource(resource.Resource):  # type: ignore[misc]  # the library has no types
    """The Thing Description."""

    ct = str(TD)
    rt = "wot.thing"

    def __init__(self, description: Callable[[], dict[str, object]]) -> None:
        super().__init__()
        self._make = description

    async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
        del request
        return aiocoap.Message(payload=json.dumps(self._make()).encode(), content_format=TD)


def _forms(path: str) -> list[dict[str, object]]:
    return [
        {"href": path, "op": ["readproperty"], "cov:method": "GET"},
        {"href": path, "op": ["writeproperty"], "cov:method": "PUT"},
        {"href": path, "op": ["observeproperty"], "subprotocol": "cov:observe", "cov:method": "GET"},
    ]


def _sensed(kind: str, state: DeviceState) -> object:
    if kind == "motion":
        return int(state.text == "on")
    return state.celsius if kind == "thermostat" else state.value


def _link(path: tuple[str, ...], leaf: resource.Resource) -> str:
    described: Mapping[str, Any] = leaf.get_link_description()
    pairs = (name if value is None else f'{name}="{value}"' for name, value in described.items())
    return ";".join([f"</{'/'.join(path)}>", *pairs])


def _free_port(host: str) -> int:
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])
