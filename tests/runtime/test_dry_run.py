"""A dry run: apps and people command as ever, and nothing reaches a device."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict
from structlog.testing import capture_logs
from tests.apps.houses import flat, is_on, lamp
from tests.replay.recorded_days import MemorySink

from homebot.config import parse_config
from homebot.control.sending import WOULD_SEND
from homebot.devices import Devices, GatewayNames, RawCommand
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command, SendCommand
from homebot.devices.handles import Light
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import COMMAND_DEVICES, READ_JOURNAL, SENDS_NOTHING
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.devices.part import Capability, Part
from homebot.devices.value import Value
from homebot.errors import ConfigError
from homebot.gateways import GatewayContext
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.recording.recording import read_recording
from homebot.runtime import Runtime
from homebot.runtime.dry_run import observing
from homebot.runtime.plan import make_plan
from homebot.testing import VirtualHouse, virtual_house_of


class OtherSettings(BaseModel):
    model_config = ConfigDict(extra="forbid")


class OtherGateway(MemoryGateway):
    Settings = OtherSettings


KEPT = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Reached(list[object]):
    """What came to the devices of a gateway."""


class DefiantGateway(MemoryGateway):
    """A gateway of somebody else that has one lamp and acts, whatever its table and its host say."""

    def __init__(self, node: Node, settings: MemoryGatewaySettings, context: GatewayContext) -> None:
        super().__init__(node, settings.model_copy(update={"act": True}))
        reached = context.service(Reached)
        assert reached is not None
        self._reached = reached
        node.create_service(Trigger, f"{node.full_name}/beep", self._beep)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        part = Part(id="light", service_type="light", capabilities=(Capability(name="on_off", settable=True),))
        self.devices.put(GatewayDevice("lamp", "Lamp", (part,), address="lamp/state", command_address="lamp/set"), "is")
        await self.devices.report("lamp", {"on_off": False}, "light")
        await super().serve(task_status=task_status)

    async def _perform(self, command: Command) -> None:
        self._reached.append(command)

    async def _send_raw(self, command: RawCommand) -> None:
        self._reached.append(command)

    def _show(self, offer: ExposedDevice) -> None:
        self._reached.append(offer)

    def _beep(self, request: TriggerRequest) -> SuccessResponse:
        self._reached.append(request)
        return SuccessResponse(success=True, message="")


pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def dry_house() -> AsyncIterator[VirtualHouse]:
    world = flat(hall_lamp=lamp("hall"))
    async with virtual_house_of(world=world, is_dry_run=True) as home:
        await home.press("hall_lamp", "on")
        await home.run_for(5)
        yield home


async def kinds(node: Node) -> list[str]:
    journal = node.create_client(ReadJournal, READ_JOURNAL)
    return [one.kind for one in (await journal.call(ReadJournalRequest())).entries if one.command]


@pytest.mark.rooms("homeassistant")
async def test_an_app_goes_on_as_if_the_lamp_had_obeyed_and_the_lamp_stays_on() -> None:
    async with dry_house() as house, Node(house.runtime.graph, "app") as node:
        (light,) = await Devices(node).find(Light)
        outcome = await light.turn_off()
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.SENT
        assert light.on is False
        await house.run_for(5)
        assert is_on(house.world, "hall_lamp")
        assert await kinds(node) == ["requested", "would", "outcome"]


@pytest.mark.rooms("homeassistant")
async def test_the_lamp_is_as_it_is_from_its_next_report_on() -> None:
    async with dry_house() as house, Node(house.runtime.graph, "app") as node:
        (light,) = await Devices(node).find(Light)
        assert (await light.turn_off()).succeeded
        await house.run_for("10m")  # it repeats its state every five
        assert [one.on for one in await Devices(node).find(Light)] == [True]


@pytest.mark.rooms("homeassistant")
async def test_a_text_of_an_app_is_not_sent_either() -> None:
    async with dry_house() as house, Node(house.runtime.graph, "app") as node:
        devices = Devices(node)
        (device,) = await devices.find("lights")
        assert await devices.tell(device, "off") == ()
        await house.run_for(5)
        assert is_on(house.world, "hall_lamp")
        assert "would" in await kinds(node)
        assert "published" not in await kinds(node)


@pytest.mark.rooms("homeassistant")
async def test_the_code_in_a_text_is_not_logged_either() -> None:
    async with dry_house() as house, Node(house.runtime.graph, "app") as node:
        devices = Devices(node)
        (device,) = await devices.find("lights")
        with capture_logs() as lines:
            await devices.tell(device, '{"action": "DISARM", "code": "4711"}')
        (line,) = (one for one in lines if one["event"] == WOULD_SEND)
        assert line["message"] == 'app would set hall_lamp → {"action": "DISARM", "code": "***"}'


@pytest.mark.rooms("homeassistant")
async def test_a_person_is_told_that_nothing_was_sent() -> None:
    async with dry_house() as house, Node(house.runtime.graph, "door") as node:
        command = node.create_client(CommandDevices, COMMAND_DEVICES)
        request = CommandDevicesRequest(target="hall_lamp", command="off", issuer="client:local", scope=("act: all",))
        answer = await command.call(request)
        assert not answer.success
        (result,) = (one.result for one in answer.results)
        assert (result.outcome, result.policy) == ("refused", "dry_run")
        assert "runs with --dry-run and sends nothing" in result.reason
        assert is_on(house.world, "hall_lamp")


@pytest.mark.rooms("homeassistant", "recording")
async def test_an_app_that_commands_again_and_again_lets_time_pass() -> None:
    """The light service turns off each lamp that is on, again if it must; here none ever goes off."""
    world = flat(hall_lamp=lamp("hall"))
    sink = MemorySink()
    async with virtual_house_of("light_service", world=world, is_dry_run=True, observers=sink.observers()) as home:
        await home.press("hall_lamp", "on")
        await home.run_for("30m")
        assert is_on(world, "hall_lamp")
    commands = read_recording([one.encode() for one in sink.lines], "run").commands
    assert 2 <= len(commands) < 1000


def test_a_gateway_that_cannot_be_kept_from_sending_is_refused() -> None:
    """One of somebody else may have no `act`; then it is not started at all."""
    config = parse_config({"gateways": {"other": {"class": "tests.runtime.test_dry_run:OtherGateway"}}}, "homebot.toml")
    with pytest.raises(ConfigError, match=r"homebot.toml: gateways.other.act: unknown key"):
        make_plan(observing(config))


async def test_a_gateway_of_somebody_else_that_ignores_act_gets_nothing_by_any_way() -> None:
    """By a handle, as a text, by a person, raw, by its services, and as an offer to other systems."""
    reached = Reached()
    config = parse_config({"gateways": {"defiant": {"class": f"{__name__}:DefiantGateway"}}}, "homebot.toml")
    runtime = Runtime(config, with_door=False, services=[reached], is_dry_run=True)
    async with runtime, Node(runtime.graph, "app") as node:
        devices, names = Devices(node), GatewayNames("defiant")
        (light,) = await devices.find(Light)
        assert (await light.turn_on()).succeeded
        (device,) = await devices.find("light")
        await devices.tell(device, "on")
        request = CommandDevicesRequest(target="Lamp", command="on", issuer="client:anna", scope=("act: all",))
        assert not (await node.create_client(CommandDevices, COMMAND_DEVICES).call(request)).success
        await node.create_publisher(RawCommand, names.out).send(RawCommand(address="lamp/set", payload="on"))
        sent = Command(key="lamp", part="light", capability="on_off", value=Value.of(True))
        answer = await node.create_client(SendCommand, names.send_command).call(sent)
        assert (answer.success, answer.problem, answer.message) == (False, "refused", SENDS_NOTHING)
        beep = await node.create_client(Trigger, f"{names.node}/beep").call(TriggerRequest())
        assert (beep.success, beep.message) == (False, SENDS_NOTHING)
        offers = node.create_publisher(ExposedDevice, names.offers, KEPT)
        offers.publish(ExposedDevice(id="robot", name="Robot", parts=()))
        await anyio.sleep(60)
        assert reached == []
        assert (await kinds(node))[-2:] == ["published", "would"]
