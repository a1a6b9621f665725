"""The owner's services of the directory, over the graph and over a restart with an index file; in virtual time."""

from contextlib import AbstractAsyncContextManager
from pathlib import Path

import anyio
import pytest
from tests.discovery import directory_house
from tests.discovery.announcements import announce, part_of
from tests.discovery.directory_house import House

from homebot.devices import Devices, names
from homebot.devices import places_messages as messages
from homebot.devices.approval_messages import ApproveDevice
from homebot.devices.handles import Light
from homebot.discovery import OwnerFacts
from homebot.places import read_places

pytestmark = pytest.mark.virtual_time


ROOMS = {"Hall": {"floor": "Downstairs", "doors": ["Kitchen"]}, "Kitchen": {"floor": "Downstairs"}}


def directory(file: Path | None = None, rooms: dict[str, object] | None = None) -> AbstractAsyncContextManager[House]:
    places = read_places({"rooms": ROOMS if rooms is None else rooms}, "Home", "homebot.toml", "configuration")
    return directory_house.directory(file, OwnerFacts("Home", places))


LAMP = announce(
    "l",
    part_of("light", "on_off", id="l", writes=("a/set",)),
    ids=("mac:aabbccddeeff",),
    name="Desk lamp",
    area="Study",
    at=1.0,
    confirmed=True,
)


async def test_what_a_preview_showed_is_approved_and_nothing_else() -> None:
    bolt = part_of("door_lock", "lock", id="l", writes=("door/set",))
    lock = announce("lock/door", bolt, ids=("mac:aabbccddeeff",), name="Door", gateway="mqtt")
    other = lock.model_copy(update={"parts": (bolt.model_copy(update={"writes": ("garage/set",)}),)})
    async with directory() as house:
        client = house.asker.create_client(ApproveDevice, names.APPROVE_DEVICE)
        await house.hears(lock)
        shown = await client.call(ApproveDevice.Request(device="door", is_preview=True))
        assert shown.commands == ("l: lock to door/set",)
        await house.hears(other)
        refused = await client.call(ApproveDevice.Request(device="door", digest=shown.digest))
        assert not refused.success
        assert "it changed since it was shown; look at it again" in refused.message
        await house.hears(lock)
        assert (await client.call(ApproveDevice.Request(device="door", digest=shown.digest))).success


async def test_handles_are_found_and_followed_by_what_the_owner_states() -> None:
    async with directory() as house:
        await house.hears(LAMP)
        devices = Devices(house.asker)
        assert not await devices.find(Light, area="downstairs")
        placed = await house.place("desk_lamp", "kitchen")
        assert (placed.success, placed.room) == (True, "Kitchen")
        tag = house.asker.create_client(messages.TagDevice, names.TAG_DEVICE)
        assert (await tag.call(messages.TagDevice.Request(device="desk_lamp", tag="Night light"))).tags == (
            "Night light",
        )
        alias = house.asker.create_client(messages.AliasDevice, names.ALIAS_DEVICE)
        assert (await alias.call(messages.AliasDevice.Request(device="desk_lamp", alias="Corner"))).aliases == (
            "Corner",
        )
        for found in (
            await devices.find(Light, area="downstairs"),
            await devices.find(Light, area="HOME"),
            await devices.find(Light, tag="night-light", name="corner"),
            await devices.find(Light, area="kitchen", name="desk lamp"),
        ):
            assert [one.device.name for one in found] == ["Corner"]
        for nothing in (
            await devices.find(Light, area="Hall"),
            await devices.find(Light, tag="night"),
            await devices.find(Light, area=""),
        ):
            assert not nothing
        async with anyio.create_task_group() as tasks:
            follow = devices.follow(Light, area="Hall")
            tasks.start_soon(house.place, "desk_lamp", "Hall")
            async for change in follow:
                assert (change.kind, change.handle.device.area) == ("appeared", "Hall")
                break


async def test_a_refusal_is_answered_in_words() -> None:
    async with directory() as house:
        await house.hears(LAMP)
        for answer, reason in (
            (await house.place("nobody", "Hall"), "there is no device of that id"),
            (await house.place("desk_lamp", "Hal"), "there is no room 'Hal'; did you mean Hall?"),
            (await house.place("desk_lamp", "Kichen"), "did you mean Kitchen?"),
            (await house.place("desk_lamp", "Studdy"), "did you mean Study?"),
            (await house.place("desk_lamp", "Hall"), ""),
        ):
            assert answer.success is (reason == "")
            assert reason in answer.message
        assert (await house.place("desk_lamp", "Kichen", is_new=True)).success
        assert (await house.place("desk_lamp", "")).room == "Study"
        assert "no command stated the room" in (await house.place("desk_lamp", "")).message
        tag = house.asker.create_client(messages.TagDevice, names.TAG_DEVICE)
        assert not (await tag.call(messages.TagDevice.Request(device="desk_lamp", tag="x", remove=True))).success
        alias = house.asker.create_client(messages.AliasDevice, names.ALIAS_DEVICE)
        assert not (await alias.call(messages.AliasDevice.Request(device="desk_lamp", alias="x", remove=True))).success
        assert not (await alias.call(messages.AliasDevice.Request(device="desk_lamp", alias=" "))).success


async def test_rooms_are_answered_with_both_ends_of_each_door() -> None:
    async with directory() as house:
        answer = await house.asker.create_client(messages.GetPlaces, names.GET_PLACES).call(
            messages.GetPlaces.Request()
        )
        assert (answer.home, answer.rooms) == (
            "Home",
            (
                messages.RoomInfo(name="Hall", floor="Downstairs", doors=("Kitchen",)),
                messages.RoomInfo(name="Kitchen", floor="Downstairs", doors=("Hall",)),
            ),
        )


async def test_what_is_exported_here_is_imported_there_and_kept_over_a_restart(tmp_path: Path) -> None:
    file = tmp_path / "index.sqlite"
    async with directory() as house:
        await house.hears(LAMP)
        await house.place("desk_lamp", "Hall")
        exported = (
            await house.asker.create_client(messages.ExportPlaces, names.EXPORT_PLACES).call(
                messages.ExportPlaces.Request()
            )
        ).text
    async with directory(file, {}) as house:
        importer = house.asker.create_client(messages.ImportPlaces, names.IMPORT_PLACES)
        answer = await importer.call(messages.ImportPlaces.Request(text=exported))
        assert (answer.success, answer.added) == (
            True,
            ("room Hall", "room Kitchen", "mac:aabbccddeeff, which is not there yet"),
        )
        await anyio.sleep(5.0)
    async with directory(file, {}) as house:
        await house.hears(LAMP.model_copy(update={"name": "Another name"}))
        device = await house.device("another_name")
        assert (device.area, device.outer_areas) == ("Hall", ("Downstairs", "Home"))
        await house.place("another_name", "Kitchen")
        importer = house.asker.create_client(messages.ImportPlaces, names.IMPORT_PLACES)
        again = await importer.call(messages.ImportPlaces.Request(text=exported))
        assert (again.added, again.kept) == ((), ("another_name stays in Kitchen; the file says Hall",))
        assert (await importer.call(messages.ImportPlaces.Request(text=exported, replaces=True))).added == (
            "another_name",
        )
        assert (await house.device("another_name")).area == "Hall"
        wrong = await importer.call(messages.ImportPlaces.Request(text='[places.rooms.Hall]\nfloor = "Kitchen"'))
        assert wrong.message == "places.rooms.Hall.floor: 'Kitchen' is a room"
        assert (await house.device("another_name")).outer_areas == ("Downstairs", "Home")


async def test_a_statement_that_could_not_be_written_is_not_said_to_be_kept(tmp_path: Path) -> None:
    """As with a full disk: here a folder stands where the file should be. It counts until the next start."""
    (tmp_path / "folder").mkdir()
    async with directory(tmp_path / "folder") as house:
        await house.hears(LAMP)
        answer = await house.place("desk_lamp", "Hall")
        assert answer.success
        assert answer.message.startswith("a restart would lose this, as it was not written: ")
        assert (await house.device("desk_lamp")).area == "Hall"
    async with directory(tmp_path / "index.sqlite") as house:
        await house.hears(LAMP)
        assert (await house.place("desk_lamp", "Hall")).message == ""
