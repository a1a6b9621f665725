"""Steps that the suites have in common: listen, announce, command, and wait for effects."""

from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Final, TypeVar

import anyio

from homebot.devices import DEVICE_CHANGES, Device, DeviceChange, GatewayState, Sighting, SubscribeToTopic
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.part import Capability, Part
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.value import PlainValue, Value
from homebot.discovery import Directory, DirectorySettings
from homebot.graph import DurabilityPolicy, Node, QoSProfile, Subscription
from homebot.messages import Message
from homebot.testing.gateway_contract.lamp import Lamp, Neighbour

MessageT = TypeVar("MessageT", bound=Message)

PATIENCE: Final = 20.0
"""Seconds for steps of milliseconds: only a broken gateway takes as long, also on a slow or busy machine."""

_SHOWN: Final = 5

KEPT: Final = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROBOT: Final = ExposedDevice(
    id="robot",
    name="Robot",
    parts=(Part(id="", service_type="light", capabilities=(Capability(name="on_off", settable=True),)),),
)


def listen(watcher: Node, kind: type[MessageT], topic: str) -> Subscription[MessageT]:
    """Subscribe to *topic*, with its history."""
    return watcher.create_subscription(kind, topic, qos_profile=KEPT)


def kept(subscription: Subscription[MessageT]) -> list[MessageT]:
    """Return the history of *topic*."""
    return list(iter(subscription.take, None))


async def until(
    subscription: Subscription[MessageT],
    wanted: str,
    fits: Callable[[MessageT], bool] = lambda _: True,
    within: float = PATIENCE,
) -> MessageT:
    """Return the next message that *fits*.

    Raises:
        AssertionError: It did not come in time; the message says which was *wanted*, and what came instead.
    """
    came: deque[MessageT] = deque(maxlen=_SHOWN)
    with anyio.move_on_after(within):
        while not came or not fits(came[-1]):
            came.append(await subscription.receive())
        return came[-1]
    others = "\n".join(f"  {message!r:.300}" for message in came) or "  nothing"
    topic = subscription.info.name
    raise AssertionError(f"{wanted} did not come on {topic} within {within:g} s; the last that came:\n{others}")


async def first(subscription: Subscription[MessageT]) -> MessageT:
    """Return the next message."""
    return await until(subscription, f"a {subscription.info.ros_type}")


async def active(states: Subscription[GatewayState]) -> None:
    """Wait until the gateway says that it is active."""
    await until(states, "the state `active`, by publish_state,", lambda state: state.state == "active")


async def announced(lamp: Lamp, watcher: Node) -> Sighting:
    """Let the lamp come, and return its first sighting, once its first report was published too."""
    sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
    reports = listen(watcher, Report, lamp.gateway.names.readings)
    await lamp.announce()
    sighting = await until(sightings, "a sighting of the lamp after Lamp.announce(), by PublishedDevices.put,")
    await reported(lamp, reports, on=False)
    return sighting


@asynccontextmanager
async def directory(watcher: Node) -> AsyncIterator[Subscription[DeviceChange]]:
    """Run a directory on the graph of *watcher* inside the block; return the changes of its devices."""
    async with Node(watcher.graph, "discovery") as node, anyio.create_task_group() as tasks:
        await tasks.start(Directory(node, DirectorySettings()).serve)
        yield watcher.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=100)
        tasks.cancel_scope.cancel()


async def changed(changes: Subscription[DeviceChange], lamp: Lamp, *, is_lost: bool) -> Device:
    """Wait until the lamp is unreachable or not; return it."""

    def fits(change: DeviceChange) -> bool:
        device = change.device
        return (
            any(endpoint.key == lamp.key for endpoint in device.endpoints)
            and (device.reachable.state == "no") is is_lost
        )

    wanted = "after Lamp.lose_link() the lamp as unreachable," if is_lost else "the lamp as reachable"
    return (await until(changes, wanted, fits)).device


async def reported(lamp: Lamp, reports: Subscription[Report], *, on: bool) -> Report:
    """Wait for a report of whether the lamp is on, and return it."""
    wanted = f"a report of {lamp.key} that {lamp.capability} is {on}, by PublishedDevices.report,"
    return await until(reports, wanted, lambda report: value(lamp, report) is on)


def value(lamp: Lamp, report: Report) -> PlainValue:
    """Return whether the lamp is on by *report*; None if that is about something else."""
    return next((reading.value.plain() for reading in report.readings if reading.capability == lamp.capability), None)


async def send(lamp: Lamp, watcher: Node, **change: object) -> SendCommandResponse:
    """Send the lamp the command to be on, or another one."""
    asked = {"key": lamp.key, "part": lamp.part, "capability": lamp.capability, "value": Value.of(True), **change}
    client = watcher.create_client(SendCommand, lamp.gateway.names.send_command)
    return await client.call(Command.model_validate(asked), timeout=PATIENCE)


async def subscribe(lamp: Lamp, watcher: Node, address: str) -> SubscribeToTopicResponse:
    """Have raw messages on *address* delivered to the watcher."""
    client = watcher.create_client(SubscribeToTopic, lamp.gateway.names.subscribe)
    response = await client.call(SubscribeToTopicRequest(topic=address, listener=watcher.full_name), timeout=PATIENCE)
    assert (response.success, response.message) == (True, "")
    return response


async def healthy(lamp: Lamp, watcher: Node) -> HealthResponse:
    """Return the health of the gateway."""
    return await watcher.create_client(GetHealth, lamp.gateway.names.health).call(HealthRequest(), timeout=PATIENCE)


async def becomes_seen(neighbour: Neighbour, *, on: bool | None) -> None:
    """Wait until the neighbour sees the robot as it should."""
    await _becomes("Neighbour.seen()", lambda: neighbour.seen(ROBOT.name), on)


async def becomes_told(lamp: Lamp, *, on: bool) -> None:
    """Wait until the lamp was told to be on or off."""
    await _becomes("Lamp.told()", lamp.told, on)


async def becomes_set(lamp: Lamp, capability: str, wanted: PlainValue) -> None:
    """Wait until the lamp has received *wanted*, perhaps rounded."""
    await _becomes(f"Lamp.told_value({capability!r})", lambda: lamp.told_value(capability), wanted)


async def _becomes(what: str, read: Callable[[], Awaitable[PlainValue]], wanted: PlainValue) -> None:
    state: PlainValue = None
    with anyio.move_on_after(PATIENCE):
        while not _is_about(state := await read(), wanted):
            await anyio.sleep(0.02)
        return
    raise AssertionError(f"{what} did not return {wanted!r} within {PATIENCE:g} s; it returned {state!r}")


def _is_about(state: PlainValue, wanted: PlainValue) -> bool:
    if isinstance(wanted, tuple):
        return isinstance(state, tuple) and all(map(_is_about, state, wanted))
    if isinstance(wanted, float) and isinstance(state, float):
        return abs(state - wanted) <= max(1.5, 0.015 * abs(wanted))
    return state == wanted
