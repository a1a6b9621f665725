"""A described thing: what it pushes, what it is asked for, and what it is told; over a protocol of this file."""

from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import anyio
import pytest
import structlog

from homebot.clock import Clock, LoopClock
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue, Value
from homebot.errors import LinkError, RefusedError, UnableError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.sent_commands import sent_commands
from homebot.integrations.things.formats.binding import RequestBinding
from homebot.integrations.things.formats.parse import CONTEXT, read_thing
from homebot.integrations.things.formats.thing import Form, Thing
from homebot.integrations.things.http.thing_device import ThingDevice, ThingPayload, describe_thing

pytestmark = pytest.mark.virtual_time


def lamp(**changes: Any) -> dict[str, Any]:
    return {
        "@context": CONTEXT,
        "id": "urn:dev:mac:a8032abe54dc",
        "title": "Desk lamp",
        "@type": "Light",
        "base": "web://lamp/things/1/",
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": "nosec_sc",
        "properties": {
            "on": {
                "@type": "OnOffProperty",
                "type": "boolean",
                "forms": [
                    {"href": "on"},
                    {"href": "on", "op": "observeproperty", "subprotocol": "push"},
                ],
            },
            "brightness": {
                "type": "integer",
                "minimum": 0,
                "maximum": 254,
                "forms": [{"href": "/brightness{?unit}"}],
            },
        },
        "actions": {"blink": {"forms": [{"href": "blink"}]}},
        "events": {"hot": {"data": {"type": "string"}, "forms": [{"href": "hot", "subprotocol": "push"}]}},
    } | changes


def sensor(**hrefs: str) -> dict[str, Any]:
    properties = {name: {"type": "number", "readOnly": True, "forms": [{"href": href}]} for name, href in hrefs.items()}
    return lamp(properties=properties, actions={}, events={})


ON, BRIGHTNESS, HOT, BLINK = (
    "web://lamp/things/1/on",
    "web://lamp/brightness",
    "web://lamp/things/1/hot",
    "web://lamp/things/1/blink",
)


@dataclass
class MadeUpPort:
    """Addresses with payloads; a missing one does not answer, and an error is raised."""

    values: dict[str, bytes | Exception] = field(default_factory=dict)
    written: list[tuple[str, bytes]] = field(default_factory=list)
    reads: list[str] = field(default_factory=list)
    binding: RequestBinding = field(default_factory=lambda: RequestBinding(frozenset({"web"}), ("push",)))
    pushes_current: bool = True
    content_type: str = ""
    changed: anyio.Event = field(default_factory=anyio.Event)

    async def read(self, form: Form) -> ThingPayload:
        self.reads.append(form.href)
        value = self.values.get(form.href, LinkError("no answer"))
        if isinstance(value, Exception):
            raise value
        return ThingPayload(value, self.content_type)

    async def write(self, form: Form, payload: bytes) -> None:
        self.written.append((form.href, payload))
        self.values[form.href] = payload

    async def observe(self, form: Form, read_current: Callable[[], Awaitable[None]]) -> AsyncIterator[ThingPayload]:
        if not self.pushes_current:
            await read_current()
        while True:
            value = self.values[form.href]
            if isinstance(value, Exception):
                raise value
            yield ThingPayload(value, self.content_type)
            await self.changed.wait()

    def push(self, href: str, value: bytes | Exception) -> None:
        self.values[href] = value
        self.changed.set()
        self.changed = anyio.Event()


@dataclass
class RecordingHost(DriverHost):
    """What the device told its gateway."""

    clock: Clock = field(default_factory=LoopClock)
    log: Any = field(default_factory=structlog.get_logger)
    described: list[GatewayDevice] = field(default_factory=list)
    values: dict[tuple[str, str], PlainValue] = field(default_factory=dict)
    reachable: list[bool | None] = field(default_factory=list)
    rejected: list[str] = field(default_factory=list)

    def describe(self, device: GatewayDevice) -> None:
        self.described.append(device)

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        assert not tuple(devices)

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        assert key == ""
        self.values |= {(part, name): value for name, value in values.items()}

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        assert part == ""
        self.reachable.append(reachable)

    async def deliver_raw(self, payload: bytes) -> None:
        assert isinstance(payload, bytes)

    def reject(self, payload: bytes, why: str) -> None:
        assert isinstance(payload, bytes)
        self.rejected.append(why)


class Rig:
    def __init__(self, description: dict[str, Any] | Thing | None = None, **port: Any) -> None:
        self.host = RecordingHost()
        values = {ON: b"false", BRIGHTNESS: b"127", HOT: b'"very"'} | port.pop("values", {})
        self.port = MadeUpPort(values, **port)
        thing = description if isinstance(description, Thing) else read_thing(description or lamp())
        self.thing = ThingDevice(thing, describe_thing(thing, "k", self.port.binding), self.port, self.host, 30.0)

    async def run_for(self, seconds: float) -> None:
        with anyio.move_on_after(seconds):
            await self.thing.run()

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self.thing.run)
            await anyio.sleep(1)
            yield
            tasks.cancel_scope.cancel()


def command(capability: str, value: PlainValue, part: str = "") -> Command:
    return Command(key="k", part=part, capability=capability, value=Value.of(value))


async def test_a_thing_is_described_with_what_can_be_read_and_set() -> None:
    rig = Rig()
    await rig.run_for(1)
    (device,) = rig.host.described
    assert (device.name, device.identifiers[0]) == ("Desk lamp", "mac:a8032abe54dc")
    main, blink, hot = device.parts
    assert main.service_type == "light"
    assert [(one.name, one.readable, one.settable) for one in main.capabilities] == [
        ("on_off", True, True),
        ("level", True, True),
    ]
    assert [one.name for one in (*blink.capabilities, *hot.capabilities)] == ["push", "press"]


async def test_values_are_observed_where_they_are_pushed_and_asked_for_otherwise() -> None:
    """A polled address is asked each 30 s; an observed one never."""
    rig = Rig()
    await rig.run_for(61)
    assert rig.host.values == {("", "on_off"): False, ("", "level"): 50.0, ("hot", "press"): "very"}
    assert rig.port.reads == [BRIGHTNESS] * 3
    assert rig.host.reachable == [True]


async def test_a_pushed_change_is_reported() -> None:
    rig = Rig()
    async with rig.running():
        rig.port.push(ON, b"true")
        await anyio.sleep(1)
    assert rig.host.values["", "on_off"] is True


async def test_an_observation_without_the_current_value_is_completed_by_a_read() -> None:
    rig = Rig(pushes_current=False)
    await rig.run_for(1)
    assert ON in rig.port.reads


async def test_a_property_that_cannot_be_observed_after_all_is_polled() -> None:
    rig = Rig()
    rig.port.values[ON] = RefusedError("observing", "no")
    async with rig.running():
        rig.port.values[ON] = b"true"
        await anyio.sleep(30)
    assert rig.host.values["", "on_off"] is True


async def test_a_command_is_spelt_and_what_is_polled_is_read_again_at_once() -> None:
    rig = Rig()
    async with rig.running():
        await rig.thing.perform(command("level", 100.0))
        await rig.thing.perform(command("push", True, "blink"))
        await anyio.sleep(1)
    assert rig.port.written == [(BRIGHTNESS, b"254"), (ON, b"true"), (BLINK, b"")]
    assert rig.host.values["", "level"] == 100.0


async def test_an_action_that_takes_a_value_is_a_setting() -> None:
    """A push without its value ends with an error of the server: eclipse-thingweb/node-wot 0.9 answers 500."""
    seconds, form = {"type": "integer", "minimum": 1, "maximum": 10}, [{"href": "blink"}]
    rig = Rig(lamp(actions={"blink": {"input": {"type": "object", "properties": {"for": seconds}}, "forms": form}}))
    await rig.thing.perform(command("number", 5.0, "blink"))
    assert rig.port.written == [(BLINK, b'{"for": 5}')]
    with pytest.raises(RefusedError):
        await rig.thing.perform(command("number", 11.0, "blink"))


async def test_a_brightness_of_zero_turns_a_lamp_off_that_has_a_switch() -> None:
    rig = Rig()
    await rig.thing.perform(command("level", 0.0))
    assert rig.port.written == [(ON, b"false")]


@pytest.mark.parametrize(
    ("capability", "value", "part", "error"),
    [
        ("level", 500.0, "", RefusedError),
        ("push", False, "blink", RefusedError),
        ("press", "x", "hot", UnableError),
        ("color", (0.0, 0.0), "", UnableError),
        ("on_off", True, "nobody", UnableError),
    ],
)
async def test_an_invalid_value_is_refused_before_anything_is_sent(
    capability: str, value: PlainValue, part: str, error: type[Exception]
) -> None:
    rig = Rig()
    with pytest.raises(error):
        await rig.thing.perform(command(capability, value, part))
    assert rig.port.written == []


async def test_a_link_that_is_lost_ends_the_run_with_one_plain_error() -> None:
    rig = Rig(values={BRIGHTNESS: LinkError("no answer"), ON: LinkError("no answer")})
    with pytest.raises(LinkError, match="no answer"):
        await rig.thing.run()


async def test_a_thing_that_refuses_everything_ends_the_run_with_its_refusal() -> None:
    refusal = RefusedError("reading", "401")
    rig = Rig(values={ON: refusal, BRIGHTNESS: refusal, HOT: refusal})
    with pytest.raises(RefusedError, match="401"):
        await rig.thing.run()


async def test_a_payload_that_breaks_the_rules_is_charged_and_the_rest_goes_on() -> None:
    rig = Rig(values={BRIGHTNESS: b'"bright"', HOT: WireError("no answer of this protocol")})
    await rig.run_for(1)
    assert rig.host.values == {("", "on_off"): False}
    assert rig.host.rejected == ["'brightness' cannot be 'bright'"]
    strange = Rig(content_type="image/png")
    await strange.run_for(1)
    assert strange.host.rejected[0] == "the content type 'image/png' is not understood"


async def test_the_type_of_an_answer_counts_more_than_the_declared_one() -> None:
    rig = Rig(content_type="text/plain; charset=utf-8")
    await rig.run_for(1)
    assert rig.host.values["", "level"] == 50.0


async def test_an_answer_that_names_its_property_is_unwrapped() -> None:
    """As WebThings answer."""
    rig = Rig(values={ON: b'{"on": true}'})
    await rig.run_for(1)
    assert rig.host.values["", "on_off"] is True


async def test_affordances_of_one_address_share_one_request() -> None:
    rig = Rig(
        sensor(temperature="/brightness", humidity="/brightness"),
        values={BRIGHTNESS: b'{"temperature": 21.5, "humidity": 40}'},
    )
    await rig.run_for(1)
    assert rig.port.reads == [BRIGHTNESS]
    assert rig.host.values == {("temperature", "temperature"): 21.5, ("humidity", "humidity"): 40.0}


async def test_one_bad_push_does_not_end_the_observation() -> None:
    rig = Rig()
    async with rig.running():
        for payload in (b"x" * 300_000, b'"perhaps"', b"true"):
            rig.port.push(ON, payload)
            await anyio.sleep(1)
    assert rig.host.values["", "on_off"] is True
    assert len(rig.host.rejected) == 2
    assert ON not in rig.port.reads


def test_the_owner_sees_the_address_and_payload_of_each_command_before_an_approval() -> None:
    """The action of a made-up lock may open the garage."""
    forms = {"lock": [{"href": "web://garage/open"}], "unlock": [{"href": "off", "htv:methodName": "POST"}]}
    actions = {name: {"@type": f"{name.title()}Action", "forms": form} for name, form in forms.items()}
    state = {"@type": "LockedProperty", "type": "string", "readOnly": True, "forms": [{"href": "locked"}]}
    lock = lamp(**{"@type": "Lock"}, properties={"locked": state}, actions=actions, events={})
    assert shown(lock) == ["lock=locked: web://garage/open", "lock=unlocked: POST web://lamp/things/1/off"]
    assert shown(lamp(events={})) == [
        f"on_off=on: {ON} true",
        f"on_off=off: {ON} false",
        f"level=100: {BRIGHTNESS} 254",
        f"blink: push=on: {BLINK}",
    ]


def shown(description: dict[str, Any]) -> list[str]:
    """The commands of a thing, as the owner sees them."""
    device = describe_thing(read_thing(description), "x", MadeUpPort().binding).described()
    return [line for part in device.parts for line in sent_commands(part)]
