"""What handles promise to a type checker; read by mypy, never run.

An expected error is marked ``type: ignore``, and mypy complains about each mark that is not needed.
"""

from typing import assert_type

from homebot.apps.rooms import per_room
from homebot.devices import Device, Devices, Follow
from homebot.devices.handles import (
    ContactSensor,
    DoorLock,
    FollowHandles,
    Handle,
    HandleChange,
    Light,
    TemperatureSensor,
    WindowCovering,
)
from homebot.devices.handles.follow import Became


async def find(devices: Devices) -> None:
    assert_type(await devices.find(), tuple[Device, ...])
    assert_type(await devices.find("lights"), tuple[Device, ...])
    assert_type(await devices.find(service_type="lights"), tuple[Device, ...])
    assert_type(await devices.find(Light), tuple[Light, ...])
    assert_type(await devices.find(Light, area="kitchen", on=True), tuple[Light, ...])
    assert_type(await devices.find(DoorLock, locked=False, reachable=True), tuple[DoorLock, ...])
    assert_type(await devices.find(TemperatureSensor, below=18, name="fridge"), tuple[TemperatureSensor, ...])
    assert_type(await devices.find(Handle, area="kitchen"), tuple[Handle, ...])
    assert_type(await devices.find(Light, category="config"), tuple[Light, ...])
    await devices.find(Light, category="settings")  # type: ignore[call-overload]  # no category
    await devices.find(Light, locked=True)  # type: ignore[call-overload]  # what only locks can be asked
    await devices.find(Light, on="yes")  # type: ignore[call-overload]  # not whether it is on
    await devices.find(Light, "kitchen")  # type: ignore[call-overload]  # a query is named
    await devices.find(WindowCovering, on=True)  # type: ignore[call-overload]  # a blind is neither on nor off
    await devices.find("lights", on=True)  # type: ignore[call-overload]  # a word has no typed query
    await devices.find(str)  # type: ignore[call-overload]  # no kind of handle


async def follow(devices: Devices) -> None:
    assert_type(devices.follow("lights"), Follow)
    lamps = devices.follow(Light, on=True)
    untyped: FollowHandles[Light] = lamps
    assert_type(lamps.became("5m", on=False), Became[Light])
    assert_type(lamps.became(lasting="5m", key=per_room, area="hall"), Became[Light])
    lamps.became(on="no")  # type: ignore[arg-type]  # not whether it is on
    lamps.became(locked=True)  # type: ignore[call-arg]  # what only locks can be asked
    assert_type(untyped.became(on=False), Became[Light])
    devices.follow(Light, closed=True)  # type: ignore[call-overload]  # what only openings can be asked
    async for change in devices.follow(ContactSensor, is_open=True):
        assert_type(change, HandleChange[ContactSensor])
        assert_type(change.handle.is_open, bool | None)


async def act(lamp: Light, blind: WindowCovering, lock: DoorLock, contact: ContactSensor) -> None:
    assert_type(lamp.on, bool | None)
    assert_type(lamp.level, float | None)
    assert_type(lamp.color, tuple[float, float] | None)
    await lamp.turn_on(level=40, kelvin=2700, transition=1)
    await lamp.turn_on(color=(120, 100))
    await lamp.turn_on(40)  # type: ignore[call-arg]  # what it shall be is named
    lamp.set_position(30)  # type: ignore[attr-defined]  # a lamp has no position
    lamp.on = True  # type: ignore[misc]  # it is told with turn_on()
    assert_type(blind.position, float | None)
    await blind.set_position(30)
    await blind.set_position("open")  # type: ignore[arg-type]  # a position is a number
    await lock.unlock()
    contact.open()  # type: ignore[attr-defined]  # a sensor opens nothing
