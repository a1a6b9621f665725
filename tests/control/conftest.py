"""A home whose devices do with a command whatever a test says; in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from operator import itemgetter
from pathlib import Path
from typing import Any, ParamSpec, Protocol, TypeVar

import anyio
import pytest
from anyio.abc import TaskGroup
from tests.one_task import in_one_task

from homebot.clock import Clock
from homebot.control import Control, ControlSettings
from homebot.control.open_command import SimulatedExecution
from homebot.devices import Devices
from homebot.devices.client_rights import CurrentGrants, NodeGrants
from homebot.devices.command_messages import CommandEvent, Setting
from homebot.devices.gateway_messages import Command, RefreshPart, RefreshRequest, RefreshResponse
from homebot.devices.handles import Handle, Light
from homebot.devices.handles.handle_query import HandleType
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest, ReadJournalResponse
from homebot.devices.lease_messages import GetLeases, HeldPart, HoldPart, HoldRequest, LeaseResponse
from homebot.devices.names import COMMAND_EVENTS, GET_LEASES, HOLD_PART, READ_JOURNAL
from homebot.devices.outcomes import Outcome, Refused
from homebot.devices.value import PlainValue, Value
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.journal.store import JournalStore

P = ParamSpec("P")
HandleT = TypeVar("HandleT", bound=Handle)
Behaviour = Callable[["Home", Command], Awaitable[None]]

NO_GRANTS: Mapping[str, tuple[str, ...]] = {}
NOTHING: Mapping[str, PlainValue] = {}


async def obey(home: Home, command: Command) -> None:
    """Do what is commanded, and report it."""
    await home.report(command.key, command.capability, command.value.plain())


async def ignore(home: Home, command: Command) -> None:
    """Do nothing."""


def obey_after(seconds: float) -> Behaviour:
    """Do what is commanded after so many seconds."""

    async def behaviour(home: Home, command: Command) -> None:
        home.later(seconds, command.key, command.capability, command.value.plain())

    return behaviour


def report(*values: tuple[float, PlainValue]) -> Behaviour:
    """Report each value so many seconds after the command, whatever it was; those of one moment in this order."""

    async def behaviour(home: Home, command: Command) -> None:
        async def tell() -> None:
            passed = 0.0
            for seconds, value in sorted(values, key=itemgetter(0)):
                await anyio.sleep(seconds - passed)
                passed = seconds
                await home.report(command.key, command.capability, value)

        home.tasks.start_soon(tell)

    return behaviour


async def refusal(outcome: Awaitable[Outcome]) -> str:
    """Return why a command is refused."""
    refused = await outcome
    assert isinstance(refused, Refused)
    return refused.reason


def hold_request(
    device: str, capability: str, value: PlainValue, issuer: str = "client:robot", **more: Any
) -> HoldRequest:
    """Return what a program outside sends, which may be killed."""
    setting = Setting(capability=capability, value=Value.of(value))
    fields = {"lease": "1", "by": "robot", "ttl": 10.0, **more}
    return HoldRequest(device=device, setting=setting, issuer=issuer, **fields)


def end_of_ramp(seconds: float) -> tuple[list[int], Behaviour]:
    """Report the end alone, so many seconds after the newest command; return the commands, which begin it anew."""
    ramps: list[int] = []

    async def fade(home: Home, command: Command) -> None:
        ramps.append(number := len(ramps))
        home.tasks.start_soon(end, home, command, number)

    async def end(home: Home, command: Command, number: int) -> None:
        await anyio.sleep(seconds)
        if number == len(ramps) - 1:
            await obey(home, command)

    return ramps, fade


class Home:
    """A home with one gateway.

    Attributes:
        behaviours: What a device does with a command, by its key; it obeys by default.
        commands: The commands that the gateway carried out, oldest first.
        events: What became known of commands after their outcome.
        devices: The access of an app to the devices.
        control: The control layer.
    """

    def __init__(self, app: Node, gateway: RecordingGateway, control: Control, tasks: TaskGroup, graph: Graph) -> None:
        self.behaviours: dict[str, Behaviour] = {}
        self.commands: list[Command] = []
        self.events: list[CommandEvent] = []
        self.devices = Devices(app)
        self.control = control
        self.gateway = gateway
        self.graph = graph
        self.app = app
        self.tasks = tasks
        gateway.house = self
        app.create_subscription(CommandEvent, COMMAND_EVENTS, self.events.append, 100)

    def put(
        self,
        key: str,
        service_type: str,
        *settable: str,
        readable: tuple[str, ...] = (),
        area: str = "",
        name: str = "",
        is_silent: bool = False,
        is_write_only: tuple[str, ...] = (),
        echoed: tuple[str, ...] = (),
        fades: bool = False,
    ) -> None:
        """Let there be a device; a silent one reports nothing of what can be set."""
        part = simple_part(service_type, settable=settable, readable=readable)
        if is_silent or is_write_only:
            mute = settable if is_silent else is_write_only
            silent = [one.model_copy(update={"readable": one.name not in mute}) for one in part.capabilities]
            part = part.model_copy(update={"capabilities": tuple(silent)})
        if echoed:
            marked = [one.model_copy(update={"echoed": one.name in echoed}) for one in part.capabilities]
            part = part.model_copy(update={"capabilities": tuple(marked)})
        part = part.model_copy(update={"fades": fades})
        self.gateway.devices.put(GatewayDevice(key, name or key.title(), (part,), area=area), "the test says so")

    async def new(
        self,
        kind: type[HandleT],
        key: str,
        *settable: str,
        before: Mapping[str, PlainValue] = NOTHING,
        behaviour: Behaviour = obey,
        service_type: str = "",
        **more: Any,
    ) -> HandleT:
        """Put a device that reported values *before*, and return its handle."""
        self.put(key, service_type or next(iter(kind.service_types)), *settable, **more)
        for capability, value in before.items():
            await self.report(key, capability, value)
        self.behaviours[key] = behaviour
        return await self.handle(kind, key)  # type: ignore[arg-type]  # its conditions do not matter

    async def lamp(
        self, *settable: str, before: Mapping[str, PlainValue] = NOTHING, behaviour: Behaviour = obey, **more: Any
    ) -> Light:
        """Put the lamp ``lamp``, and return its handle."""
        return await self.new(Light, "lamp", *settable, before=before, behaviour=behaviour, **more)

    async def report(self, key: str, capability: str, value: PlainValue) -> None:
        """Let a device report a value."""
        await self.gateway.devices.report(key, {capability: value})

    async def hold(self, request: HoldRequest) -> LeaseResponse:
        """Hold what *request* says."""
        return LeaseResponse.of(await self.app.create_client(HoldPart, HOLD_PART).call(request, timeout=900))

    async def leases(self, device: str = "") -> tuple[HeldPart, ...]:
        """Return what is held."""
        return (await self.app.create_client(GetLeases, GET_LEASES).call(GetLeases.Request(device=device))).parts

    async def read(self, **request: object) -> ReadJournalResponse:
        """Read the journal."""
        wanted = ReadJournalRequest.model_validate(request)
        return await self.app.create_client(ReadJournal, READ_JOURNAL).call(wanted)

    def later(self, seconds: float, key: str, capability: str, value: PlainValue) -> None:
        """Let a device report a value in so many seconds."""

        async def tell() -> None:
            await anyio.sleep(seconds)
            await self.report(key, capability, value)

        self.tasks.start_soon(tell)

    def begin(self, command: Callable[[], Awaitable[Outcome]]) -> list[Outcome]:
        """Give a command beside the test; return where its outcome will be."""
        outcomes: list[Outcome] = []

        async def give() -> None:
            outcomes.append(await command())

        self.tasks.start_soon(give)
        return outcomes

    async def handle(self, kind: HandleType[P, HandleT], key: str = "") -> HandleT:
        """Return the only handle of *kind*, or that of the device *key*."""
        await anyio.sleep(0.01)  # of virtual time, in which the directory takes everything in
        found = await self.devices.find(Handle)
        (handle,) = [one for one in found if not key or one.name == key.title()]
        return self.devices.handles(handle.device, kind)[0]


class RecordingGateway(MemoryGateway):
    """A gateway whose devices behave as the test says."""

    house: Home

    async def _perform(self, command: Command) -> None:
        self._check_link()
        self.house.commands.append(command)
        await self.house.behaviours.get(command.key, obey)(self.house, command)


def answer_requests(home: Home, answer: Callable[[str], Awaitable[None]]) -> list[str]:
    """Let parts be asked for their values, which *answer* reports; return the keys that are asked."""
    asked: list[str] = []

    async def refresh(request: RefreshRequest) -> RefreshResponse:
        asked.append(request.key)
        await answer(request.key)
        return RefreshResponse(success=True, message="")

    home.gateway.node.create_service(RefreshPart, home.gateway.names.refresh, refresh)
    return asked


class OpenHome(Protocol):
    def __call__(
        self,
        grants: Mapping[str, tuple[str, ...]] = NO_GRANTS,
        clock: Clock | None = None,
        store: JournalStore | None = None,
        journal_file: Path | None = None,
        rehearsal: SimulatedExecution | None = None,
        **settings: object,
    ) -> AbstractAsyncContextManager[Home]: ...


@asynccontextmanager
async def opened_home(
    grants: Mapping[str, tuple[str, ...]] = NO_GRANTS,
    clock: Clock | None = None,
    store: JournalStore | None = None,
    journal_file: Path | None = None,
    rehearsal: SimulatedExecution | None = None,
    **settings: object,
) -> AsyncIterator[Home]:
    """Give a home without approvals; *settings* are those of `ControlSettings`."""
    graph = Graph(clock)
    async with (
        Node(graph, "memory", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "control") as control_node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        gateway = RecordingGateway(gateway_node)
        checked = ControlSettings.model_validate({"approvals": False, **settings})
        current = CurrentGrants(NodeGrants(grants))
        control = Control(control_node, checked, current, store=store, journal_file=journal_file, rehearsal=rehearsal)
        await tasks.start(gateway.serve)
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        await tasks.start(control.serve)
        yield Home(app, gateway, control, tasks, graph)
        tasks.cancel_scope.cancel()


@pytest.fixture
def open_home() -> OpenHome:
    """Give what opens a home."""
    return opened_home


@pytest.fixture
def home_settings() -> dict[str, Any]:
    """The settings of the fixture ``home``; a file of tests may have its own."""
    return {}


@pytest.fixture
async def home(open_home: OpenHome, home_settings: dict[str, Any]) -> AsyncIterator[Home]:
    """A home without approvals."""
    async with in_one_task(open_home(**home_settings)) as home:
        yield home
