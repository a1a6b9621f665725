"""A house whose devices, gateways and clock stand still, so that every command prints the same each time."""

from collections.abc import Callable

import pytest
from tests.cli.conftest import NOW, Homebot, HomebotWith

from homebot.cli import main
from homebot.clock import ManualClock
from homebot.control.explanations import Explanations
from homebot.devices import (
    DEVICE_CHANGES,
    FIND_DEVICES,
    QUERY_DEVICES,
    Device,
    DeviceChange,
    DevicePart,
    Endpoint,
    Fact,
    FindDevices,
    Found,
    GatewayNames,
    GatewayState,
    KeyValue,
    QueryDevices,
    RawCommand,
    Reachability,
    Route,
    State,
)
from homebot.devices.device import part_names
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse, PartFailure, Quarantine
from homebot.devices.history_messages import ReadHistory, ReadHistoryResponse
from homebot.devices.journal_messages import (
    ExplainDevice,
    ExplainMissingState,
    JournalEntry,
    ReadJournal,
    ReadJournalRequest,
    ReadJournalResponse,
)
from homebot.devices.names import (
    DISCOVERY_HEALTH,
    EXPLAIN_DEVICE,
    EXPLAIN_MISSING_STATE,
    FORGET_DEVICE,
    MERGE_DEVICES,
    OWNER,
    PREFER,
    READ_HISTORY,
    READ_JOURNAL,
    SPLIT_DEVICE,
    text_address,
)
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.term_messages import read_terms
from homebot.devices.query.terms import HasText
from homebot.devices.services import (
    AnnouncedOn,
    FindDevicesRequest,
    FindDevicesResponse,
    ForgetDevice,
    ForgetDeviceRequest,
    ForgetDeviceResponse,
    MergeDevices,
    MergeDevicesRequest,
    MergeDevicesResponse,
    QueryDevicesRequest,
    QueryDevicesResponse,
    SplitDevice,
    SplitDeviceRequest,
    SplitDeviceResponse,
)
from homebot.devices.value import PlainValue, Value
from homebot.discovery.search.postings import Postings
from homebot.discovery.search.unknown_words import explain_result
from homebot.errors import UsageError
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.journal.store import JournalNote, JournalStore
from homebot.messages import Time
from homebot.places import HousePlan
from homebot.support.counters import Severity
from homebot.words.queries import parse_query

LAMP_KEY = "homeassistant:light/0x00158d0001abcdef/light"
NATIVE_KEY = "zigbee2mqtt:0x00158d0001abcdef"


def ago(seconds: float) -> Time:
    return Time.from_seconds(NOW - seconds)


def told(part: str, capability: str, value: PlainValue, since: float, *, live: bool = True) -> State:
    return State(
        part=part, capability=capability, value=Value.of(value), since=ago(since), told_at=ago(since), live=live
    )


def kitchen_lamp() -> Device:
    light = Part(
        id="light",
        service_type="light",
        advertised="light",
        capabilities=(
            Capability(name="on_off", settable=True),
            Capability(name="level", settable=True),
            Capability(name="color_temperature", settable=True, bounds=(2202.0, 4000.0)),
            Capability(name="effect", readable=False, settable=True, options=("blink", "breathe")),
        ),
        reads=("zigbee2mqtt/Kitchen lamp",),
        writes=("zigbee2mqtt/Kitchen lamp/set",),
    )
    signal = Part(
        id="linkquality",
        name="Signal",
        service_type="x_sensor",
        category="diagnostic",
        capabilities=(Capability(name="measurement", unit="lqi"),),
        reads=("zigbee2mqtt/Kitchen lamp",),
    )
    return Device(
        id="kitchen-lamp",
        name="Kitchen lamp",
        service_type="light",
        endpoints=(
            Endpoint(
                gateway="mqtt",
                key=NATIVE_KEY,
                address=text_address(NATIVE_KEY, "light"),
                command_address=text_address(NATIVE_KEY, "light"),
            ),
        ),
        metadata=(),
        first_seen=ago(86_400 * 3),
        last_seen=ago(12),
        expires=ago(-3600),
        freshness="fresh",
        service_types=("light",),
        area="Kitchen",
        names=("Kitchen lamp", "0x00158d0001abcdef"),
        identifiers=("eui64:00158d0001abcdef",),
        parts=(
            DevicePart(
                id="light",
                part=light,
                routes=(
                    Route(gateway="mqtt", key=NATIVE_KEY, part="light", convention="zigbee2mqtt"),
                    Route(gateway="mqtt", key=LAMP_KEY, part="", convention="homeassistant"),
                ),
            ),
            DevicePart(
                id="linkquality",
                part=signal,
                routes=(Route(gateway="mqtt", key=NATIVE_KEY, part="linkquality", convention="zigbee2mqtt"),),
            ),
        ),
        facts=(
            Fact(
                name="manufacturer",
                value="IKEA",
                gateway="mqtt",
                convention="zigbee2mqtt",
                key=NATIVE_KEY,
                said_at=ago(300),
            ),
            Fact(
                name="model",
                value="LED1836G9",
                gateway="mqtt",
                convention="homeassistant",
                key=LAMP_KEY,
                said_at=ago(7300),
            ),
        ),
        reachable=Reachability(state="yes", since=ago(300), why="zigbee2mqtt/Kitchen lamp/availability says online"),
        states=(
            told("light", "on_off", True, 40),
            told("light", "level", 39.76, 40),
            told("linkquality", "measurement", 118.0, 5000, live=False),
        ),
        evidence=(f"the same eui64:00158d0001abcdef in {NATIVE_KEY} and {LAMP_KEY}",),
        conflicts=("homeassistant:light/evil writes to zigbee2mqtt/Kitchen lamp/set as well",),
    )


def through_hub(lamp: Device) -> Device:
    light, signal = lamp.parts
    native, other = light.routes
    hub = other.model_copy(update={"gateway": "homeassistant"})
    fact = Fact(name=PREFER, value="homeassistant", gateway="", convention=OWNER, key="configuration", said_at=ago(60))
    parts = (light.model_copy(update={"routes": (hub, native)}), signal)
    return lamp.model_copy(update={"parts": parts, "facts": (fact, *lamp.facts)})


def window() -> Device:
    return Device(
        id="windows/bath",
        name="bath\x1b[31m",
        service_type="windows",
        endpoints=(
            Endpoint(
                gateway="mqtt",
                key="windows/bath",
                address="home425/windows/bath/out",
                command_address="home425/windows/bath/in",
            ),
        ),
        metadata=(),
        first_seen=ago(90_000),
        last_seen=ago(90_000),
        expires=ago(86_400),
        freshness="stale",
    )


def attic() -> Device:
    part = Part(
        id="",
        service_type="temperature_sensor",
        tag="outdoor",
        guessed=True,
        capabilities=(Capability(name="temperature"), Capability(name="humidity"), Capability(name="battery_low")),
        reads=("attic/tele",),
    )
    return Device(
        id="attic",
        name="Attic",
        service_type="temperature_sensor",
        endpoints=(Endpoint(gateway="mqtt", key="attic", address=text_address("attic", ""), command_address=""),),
        metadata=(),
        first_seen=ago(500),
        last_seen=ago(120),
        expires=ago(-100),
        freshness="unconfirmed",
        area="Attic",
        names=("Attic",),
        parts=(DevicePart(id="", part=part, routes=(Route(gateway="mqtt", key="attic", part=""),)),),
        reachable=Reachability(state="no", since=ago(60), why="its last will says offline"),
        states=(
            told("", "temperature", -3.25, 120),
            told("", "humidity", 61.0, 120),
            told("", "battery_low", False, 9),
        ),
    )


class StillHouse:
    """The nodes of the house.

    Attributes:
        published: What was published through the gateway, as topic, payload and retain.
        forgotten: The ids that were forgotten.
        acts: Whether the gateway acts.
        is_well: Whether nothing is wrong.
        counted: What the gateway counted besides.
        failures: What failed in it.
        crowd: How many more devices there are that are silent, each disputed twice.
        carried: How many devices were given out.
        restless: For how many questions the devices change places.
        is_near: Whether devices are found by words that are only like theirs.
        journal: The entries of the journal, oldest first.
        is_restarted: Whether homebot knows the lamp's state from retained messages alone.
        prefers_hub: Whether the lamp's second route is through a hub, which the owner prefers for commands.
    """

    def __init__(self) -> None:
        self.published: list[tuple[str, str, bool]] = []
        self.forgotten: list[str] = []
        self.acts = True
        self.is_well = False
        self.counted: tuple[Count, ...] = ()
        self.failures: list[PartFailure] = []
        self.crowd = 0
        self.carried = 0
        self.restless = 0
        self.is_near = False
        self.journal: list[JournalEntry] = []
        self.is_restarted = False
        self.prefers_hub = False

    def node(self, graph: Graph) -> Node:
        node = Node(graph, "still")
        states = node.create_publisher(GatewayState, GatewayNames("mqtt").state, qos_profile_latched)
        states.publish(GatewayState(state="active", reason="", acts=self.acts))
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        node.create_subscription(RawCommand, GatewayNames("mqtt").out, self._publish, 10)
        node.create_service(FindDevices, FIND_DEVICES, self._find)
        node.create_service(QueryDevices, QUERY_DEVICES, self._query)
        node.create_service(ForgetDevice, FORGET_DEVICE, self._forget)
        node.create_service(SplitDevice, SPLIT_DEVICE, self._split)
        node.create_service(MergeDevices, MERGE_DEVICES, self._merge)
        node.create_service(GetHealth, GatewayNames("mqtt").health, self._health)
        node.create_service(GetHealth, DISCOVERY_HEALTH, self._directory_health)
        node.create_service(ReadJournal, READ_JOURNAL, self._read_journal)
        node.create_service(ReadHistory, READ_HISTORY, lambda _: ReadHistoryResponse(success=True))
        explanations = Explanations(self._read_journal, self._device)
        node.create_service(ExplainDevice, EXPLAIN_DEVICE, explanations.explain)
        node.create_service(ExplainMissingState, EXPLAIN_MISSING_STATE, explanations.explain_missing)
        return node

    def _devices(self) -> tuple[Device, ...]:
        lamp = kitchen_lamp()
        if self.is_restarted:
            retained = tuple(one.model_copy(update={"live": False}) for one in lamp.states)
            lamp = lamp.model_copy(update={"states": retained})
        if self.prefers_hub:
            lamp = through_hub(lamp)
        if self.is_well:
            return (lamp.model_copy(update={"conflicts": ()}),)
        silent = window().model_copy(update={"conflicts": ("it is a door", "it is a wall")})
        crowd = [silent.model_copy(update={"id": f"windows/{number:03}"}) for number in range(self.crowd)]
        return (attic(), lamp, window(), *crowd)

    def _find(self, request: FindDevicesRequest) -> FindDevicesResponse:
        found = [one for one in self._devices() if request.service_type in {"", one.service_type}]
        self.carried += len(found)
        return FindDevicesResponse(devices=tuple(found), sequence=1)

    def _query(self, request: QueryDevicesRequest) -> QueryDevicesResponse:
        try:
            query = read_terms(request.query, parse_query)
        except UsageError as exc:
            return QueryDevicesResponse(success=False, message=str(exc))
        found = [one for one in self._devices() if fits(query, facets_of(one))]
        found = found[self.restless :] + found[: self.restless]
        self.restless = max(0, self.restless - 1)
        postings = Postings()
        for one in self._devices():
            postings.put(facets_of(one), ())
        near = HasText("lihgt") if self.is_near else query
        note = explain_result(near, [one.id for one in found], postings, HousePlan("villa"))
        results = tuple(
            Found(device=one, score=2.0 - number, reasons=(f"it is number {number + 1}", f"it is {one.freshness}"))
            for number, one in enumerate(found)
        )
        shown = results[request.offset :][: request.limit or None]
        self.carried += len(shown)
        return QueryDevicesResponse(success=True, message=note, results=shown, total=len(found))

    def _forget(self, request: ForgetDeviceRequest) -> ForgetDeviceResponse:
        self.forgotten.append(request.device)
        if request.device == "attic":
            return ForgetDeviceResponse(success=False, message="it went a moment ago")
        topic = "homeassistant/light/0x00158d0001abcdef/light/config"
        return ForgetDeviceResponse(success=True, announced_on=(AnnouncedOn(gateway="mqtt", topic=topic),))

    def _split(self, request: SplitDeviceRequest) -> SplitDeviceResponse:
        if request.device == "attic":
            why = "a split of attic was refused: nothing was merged into it"
            return SplitDeviceResponse(success=False, message=why)
        return SplitDeviceResponse(success=True, devices=(request.device, f"{request.gateway}_{request.key}"))

    def _merge(self, request: MergeDevicesRequest) -> MergeDevicesResponse:
        if len(request.devices) == 1:
            return MergeDevicesResponse(success=False, message="a merge was refused: it takes two different devices")
        return MergeDevicesResponse(success=True, device=request.devices[-1])

    def _health(self, request: HealthRequest) -> HealthResponse:
        del request
        offender = Quarantine(
            gateway="mqtt",
            offender="homeassistant/sensor/evil/config",
            why="homeassistant/sensor/evil/config: the payload is no JSON",
            offences=7,
            since=ago(90),
            until=ago(-510),
        )
        counts = Count.each({"announcements": 1024}) + Count.each({"announcements_rejected": 7}, Severity.FAULT)
        return HealthResponse(
            counts=counts + self.counted,
            quarantined=() if self.is_well else (offender,),
            failures=tuple(self.failures),
            notes=("a device waits to be paired",),
        )

    def _directory_health(self, request: HealthRequest) -> HealthResponse:
        del request
        trouble = "the index file /data/index.sqlite cannot be written: database or disk is full"
        return HealthResponse(counts=(Count(name="devices", count=3),), troubles=() if self.is_well else (trouble,))

    async def _device(self, device_id: str) -> Device | None:
        return next((one for one in self._devices() if one.id == device_id), None)

    async def _read_journal(self, request: ReadJournalRequest) -> ReadJournalResponse:
        kept = JournalStore(1000, 1e9)
        for entry in self.journal:
            fields = dict(entry)
            outcome = next((one.to_outcome() for one in fields.pop("results")), None)
            kept.add(JournalNote(**{**fields, "at": entry.at.to_seconds(), "outcome": outcome}))
        names = tuple(KeyValue(key=key, value=name) for key, name in part_names(self._devices()).items())
        return (await kept.read(request)).model_copy(update={"names": names})

    def _publish(self, command: RawCommand) -> None:
        self.published.append((command.address, command.payload, command.retain))
        if command.address == "homebot/things/urn-dev-lamp/td" and command.payload:
            endpoint = Endpoint(gateway="mqtt", key="thing:urn-dev-lamp", address="", command_address="")
            device = window().model_copy(update={"id": "desk-lamp", "endpoints": (endpoint,)})
            self._changes.publish(DeviceChange(kind="appeared", device=device, sequence=2, why="it was announced"))


@pytest.fixture
def still() -> StillHouse:
    return StillHouse()


Run = Callable[..., int]


@pytest.fixture
def run(still_homebot: Homebot) -> Run:
    """Runs a command against the house, and returns its exit code."""
    return lambda *arguments: main(["--door", still_homebot.door, *arguments])


@pytest.fixture
def still_homebot(still: StillHouse, homebot_with: HomebotWith) -> Homebot:
    return homebot_with(still.node, ManualClock(NOW))
