"""The Home Assistant gateway, where Home Assistant is another than it should be."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from anyio.abc import TaskStatus
from tests.gateways.watched_gateway import WatchedGateway, reading, receive, watched
from tests.integrations.homeassistant.simulated.entity import ServedEntity
from tests.integrations.homeassistant.simulated.server import Fields, SimulatedHomeAssistant
from tests.patience import PATIENCE
from tests.simulated.http.web_server import WebPeer

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import Report, SendCommandResponse
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import as_json, as_object
from homebot.integrations.homeassistant.gateway import HomeAssistantGateway, HomeAssistantGatewaySettings

pytestmark = pytest.mark.slow

SHORT = {"domain": "zha", "device_id": "home-lock", "type": "remote_button_short_press", "subtype": "turn_on"}
OWN = {"domain": "lock", "device_id": "home-lock", "type": "locked", "entity_id": "lock.home_lock"}


class RefusingLock(ServedEntity):
    """A lock that carries nothing out."""

    def call(self, service: str, data: Mapping[str, object]) -> bool:
        del service, data
        return False


class CrashingHomeAssistant(SimulatedHomeAssistant):
    """A Home Assistant that crashes, if told to, at a service call before it answers."""

    def __init__(self) -> None:
        super().__init__()
        self.serving = anyio.CancelScope()
        self.crashes = False
        self.called = 0
        self.last_call: Mapping[str, object] = {}

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        with anyio.CancelScope() as self.serving:
            await super().serve(task_status=task_status)

    def receive(self, peer: WebPeer, message: bytes) -> None:
        is_call = b"call_service" in message
        self.called += is_call
        self.last_call = as_object(message) if is_call else self.last_call
        if is_call and self.crashes:
            self.serving.cancel()
        else:
            super().receive(peer, message)


class NamingHomeAssistant(SimulatedHomeAssistant):
    """A Home Assistant with a further name for each entity, which is in single entries only."""

    def receive(self, peer: WebPeer, message: bytes) -> None:
        if b"get_entries" not in message:
            super().receive(peer, message)
            return
        asked = as_object(message)
        entries = {key: {"entity_id": key, **one.entry(), "aliases": ["Portal"]} for key, one in self.entities.items()}
        assert asked["entity_ids"] == list(entries)
        peer.send(as_json({"id": asked["id"], "type": "result", "success": True, "result": entries}))


class GuardedHomeAssistant(SimulatedHomeAssistant):
    """Home Assistant 2024.3 for a user who is no administrator."""

    def receive(self, peer: WebPeer, message: bytes) -> None:
        asked = as_object(message)
        if asked.get("event_type") not in {"floor_registry_updated", "label_registry_updated"}:
            super().receive(peer, message)
            return
        error = {"code": "unauthorized", "message": "Unauthorized"}
        peer.send(as_json({"id": asked["id"], "type": "result", "success": False, "error": error}))


class RemoteHomeAssistant(SimulatedHomeAssistant):
    """A Home Assistant with a remote of ZHA, and a phone."""

    def _listed(self, registry: str) -> list[Fields]:
        listed = super()._listed(registry)
        if registry != "device":
            return listed
        phone = {"id": "phone", "name": "Phone", "identifiers": [["mobile_app", "1"]], "connections": []}
        remotes = [{**one, "identifiers": [["zha", "00:0b:57:ff:fe:12:34:56"]]} for one in listed]
        return [*remotes, phone]


class House(WatchedGateway):
    """A lock in a simulated Home Assistant, and what the gateway says of it."""

    def __init__(self, gateway: HomeAssistantGateway, watcher: Node) -> None:
        self.gateway, self.watcher = gateway, watcher
        self.seen = self.sightings()
        self._states, self._reports = self.states(), self.reports()

    async def state(self, wanted: str) -> GatewayState:
        return await receive(self._states, lambda one: one.state == wanted)

    async def reported(self, capability: str) -> PlainValue:
        return await reading(self._reports, capability, lambda _: True)

    async def sighted(self, parts: int) -> Sighting:
        return await receive(self.seen, lambda one: len(one.parts) == parts)

    async def unlock(self, code: str = "", expires: float = 0.0) -> SendCommandResponse:
        return await self.command("home-lock", "lock_home-lock", "lock", "unlocked", expires, code)


@asynccontextmanager
async def house(folder: Path, home: SimulatedHomeAssistant, token: str = "") -> AsyncIterator[House]:
    file = folder / "token"
    file.touch(mode=0o600)
    file.write_text(token or home.token)
    async with anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        lock = RefusingLock(SimulatedDeviceInfo("home", "lock", "lock", "locks", "hall"), lambda _: None, home)
        lock.begin(DeviceState(text="locked"), has_power=True)
        await tasks.start(lock.serve)
        settings = HomeAssistantGatewaySettings.model_validate({"url": home.url, "token_file": file})
        async with watched("homeassistant", lambda node: HomeAssistantGateway(node, settings)) as found:
            yield House(*found)
        tasks.cancel_scope.cancel()


async def test_a_trigger_of_a_device_is_a_press_and_one_of_an_entity_is_not(tmp_path: Path) -> None:
    home = SimulatedHomeAssistant()
    home.triggers["home-lock"] = [OWN, {**SHORT, "domain": "mqtt"}, SHORT]
    async with house(tmp_path, home) as seen:
        _, buttons = (await seen.sighted(parts=2)).parts
        assert buttons.service_type == "generic_switch"
        assert [one.options for one in buttons.capabilities] == [("remote_button_short_press turn_on",)]
        home.fire(SHORT)
        assert await seen.reported("press") == "remote_button_short_press turn_on"


@pytest.mark.parametrize(
    ("kind", "data", "press"),
    [
        ("zha_event", {"device_id": "home-lock", "command": "on", "args": []}, "on"),
        ("deconz_event", {"device_id": "home-lock", "event": 1002}, "1002"),
        ("ios.action_fired", {"actionName": "GOODNIGHT"}, "GOODNIGHT"),
        ("tag_scanned", {"tag_id": "4711", "device_id": "phone"}, "4711"),
    ],
)
async def test_an_event_of_a_remote_or_of_an_app_is_a_press(
    tmp_path: Path, kind: str, data: Fields, press: str
) -> None:
    home = RemoteHomeAssistant()
    home.triggers["home-lock"] = [SHORT]
    async with house(tmp_path, home) as seen:
        remote = await seen.sighted(parts=3)
        assert [part.id for part in remote.parts[1:]] == ["remote_button_short_press_turn_on", "event"]
        home.tell(kind, {"device_id": "elsewhere", "command": "off"})
        home.tell(kind, data)
        assert await seen.reported("press") == press


async def test_the_aliases_of_an_entity_are_further_names_of_its_device(tmp_path: Path) -> None:
    async with house(tmp_path, NamingHomeAssistant()) as seen:
        sighting = await seen.sighted(parts=1)
    assert next(one.value for one in sighting.metadata if one.key == "aliases").endswith("Portal")


async def test_a_user_who_may_not_follow_floors_and_labels_is_served(tmp_path: Path) -> None:
    home = GuardedHomeAssistant()
    home.floors["hall"] = "Ground floor"
    async with house(tmp_path, home) as seen:
        sighting = await seen.sighted(parts=1)
    assert next(one.value for one in sighting.metadata if one.key == "floor") == "Ground floor"


async def test_a_renamed_area_is_the_new_room_and_a_change_of_nothing_else_says_nothing(tmp_path: Path) -> None:
    home = SimulatedHomeAssistant()
    async with house(tmp_path, home) as seen:
        assert (await seen.sighted(parts=1)).area == "hall"
        assert await seen.reported("lock") == "locked"
        home.change_registry("device")
        home.areas["hall"] = "Big hall"
        home.change_registry("area")
        with anyio.fail_after(PATIENCE):
            while (sighting := await seen.seen.receive()).area != "Big hall":
                assert sighting.area == "hall"
        assert sighting.why == "Home Assistant described it anew"


async def test_a_token_that_is_not_valid_is_told_with_the_way_to_a_new_one(tmp_path: Path) -> None:
    async with house(tmp_path, SimulatedHomeAssistant(), token="old") as seen:
        reason = (await seen.state("unavailable")).reason
    assert "the token was revoked, has expired or is another's; make a new one" in reason
    assert "Long-lived access tokens" in reason
    assert f"put it into {tmp_path / 'token'}, which is read again within five minutes" in reason


async def test_a_home_assistant_that_is_off_is_told_in_words(tmp_path: Path) -> None:
    home = CrashingHomeAssistant()
    async with house(tmp_path, home) as seen:
        await seen.state("active")
        home.serving.cancel()
        while "cannot be opened" not in (reason := (await seen.state("unavailable")).reason):
            assert reason == "Home Assistant closed the connection"
    assert reason.endswith("nothing is listening there (connection refused): start it, or correct the address")


async def test_a_version_without_what_the_gateway_needs_is_told(tmp_path: Path) -> None:
    home = SimulatedHomeAssistant()
    home.version = "2022.3.1"
    async with house(tmp_path, home) as seen:
        assert (
            "it is Home Assistant 2022.3.1; homebot needs 2022.11 or later" in (await seen.state("unavailable")).reason
        )


async def test_a_refusal_of_a_command_with_a_code_never_repeats_it(tmp_path: Path) -> None:
    async with house(tmp_path, SimulatedHomeAssistant()) as seen:
        await seen.sighted(parts=1)
        plain, coded = await seen.unlock(), await seen.unlock(code="4711")
    assert (plain.success, plain.problem, "not found" in plain.message) == (False, "refused", True)
    assert (coded.success, coded.problem) == (False, "refused")
    assert "4711" not in coded.message
    assert "not found" not in coded.message


async def test_an_entity_is_polled_when_its_values_are_asked_for(tmp_path: Path) -> None:
    home = CrashingHomeAssistant()
    async with house(tmp_path, home) as seen:
        await seen.sighted(parts=1)
        assert (await seen.refresh("home-lock", "lock_home-lock")).success
        wanted = {
            "domain": "homeassistant",
            "service": "update_entity",
            "service_data": {"entity_id": ["lock.home_lock"]},
        }
        assert wanted.items() <= home.last_call.items()


@pytest.mark.parametrize(
    ("context", "set_by"),
    [
        ("id", ""),
        ({"id": "id", "user_id": "anna"}, "person"),
        ({"id": "id", "user_id": "robot"}, ""),
        ({"id": "id", "parent_id": "trigger"}, "program"),
        ({"id": "id", "parent_id": "trigger", "user_id": "anna"}, "person"),
    ],
)
async def test_a_change_tells_whether_a_user_or_an_automation_made_it(
    tmp_path: Path, context: object, set_by: str
) -> None:
    home = CrashingHomeAssistant()
    async with house(tmp_path, home) as seen:
        await seen.sighted(parts=1)
        reports = seen.watcher.create_subscription(Report, seen.gateway.names.readings, qos_profile=100)
        home.send_states({"c": {"lock.home_lock": {"+": {"s": "unlocked", "c": context}}}})
        report = await receive(reports, lambda one: any(each.capability == "lock" for each in one.readings))
        assert report.set_by == set_by


async def test_a_command_is_sent_once_or_not_at_all_while_home_assistant_is_away(tmp_path: Path) -> None:
    """One is in flight when it crashes, two come while it is away, of which one expires: none is sent after that."""
    home = CrashingHomeAssistant()
    async with house(tmp_path, home) as seen, anyio.create_task_group() as tasks:
        await seen.state("active")
        await seen.sighted(parts=1)
        home.crashes = True
        in_flight = await seen.unlock()
        await seen.state("unavailable")
        late = await seen.unlock(expires=0.1)
        lost = await seen.unlock()
        assert [one.problem for one in (in_flight, late, lost)] == ["unanswered", "unreachable", "unreachable"]
        home.crashes = False
        await tasks.start(home.serve)
        await seen.state("active")
        assert home.called == 1
        assert (await seen.unlock()).problem == "refused"
        assert home.called == 2
        tasks.cancel_scope.cancel()


async def test_a_token_that_is_not_valid_is_found_before_the_start(tmp_path: Path) -> None:
    """Home Assistant was not asked, and all was well."""
    home, file = SimulatedHomeAssistant(), tmp_path / "token"
    async with anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        settings = HomeAssistantGatewaySettings.model_validate({"url": home.url, "token_file": file})
        file.write_text(home.token)
        await HomeAssistantGateway.reach(settings)
        file.write_text("old")
        with pytest.raises(RefusedError, match="make a new one"):
            await HomeAssistantGateway.reach(settings)
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"token_file": "a", "token_env": "B"},
        {"token_file": "a", "url": "mqtt://ha"},
        {"token_file": "a", "url": "http://user:secret@ha:8123"},
    ],
    ids=["no token", "two", "scheme", "password"],
)
def test_a_table_that_cannot_work_is_refused(table: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"token|address of Home Assistant") as error:
        HomeAssistantGatewaySettings.model_validate(table)
    assert "secret@" not in str(error.value).partition("input_value")[0]


def test_a_token_file_that_is_not_there_is_named_with_the_way_to_one(tmp_path: Path) -> None:
    settings = HomeAssistantGatewaySettings(token_file=tmp_path / "none")
    with pytest.raises(UsageError, match=r"token_file: .*Long-lived access tokens"):
        HomeAssistantGateway.check(settings)


@pytest.mark.parametrize(
    ("url", "websocket"),
    [
        ("http://ha:8123", "ws://ha:8123/api/websocket"),
        ("https://ha.example/", "wss://ha.example/api/websocket"),
        ("ws://ha:8123/api/websocket", "ws://ha:8123/api/websocket"),
    ],
)
def test_the_address_is_that_of_a_browser(url: str, websocket: str) -> None:
    assert HomeAssistantGatewaySettings(url=url, token_env="X").websocket == websocket
