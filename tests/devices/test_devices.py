"""What an app does with devices: listen and tell, in both ways of delivery, over restarts; in virtual time."""

from collections.abc import Awaitable, Callable
from functools import partial

import anyio
import pytest
from structlog.testing import capture_logs
from tests.devices.conftest import RunDirectory, RunGateway

from homebot.devices import Device, Devices, Endpoint, GatewayState, RawCommand, RawMessage, SubscribeToTopic
from homebot.devices.follow import Follow
from homebot.devices.handles import DoorLock, Light
from homebot.devices.house_view import HouseView
from homebot.devices.names import PLACE_DEVICE
from homebot.devices.places_messages import PlaceDevice
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import LinkError, RefusedError, ServiceFailedError, ServiceUnavailableError, WireError
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.messages import Time
from homebot.testing import FakeGateway
from homebot.words.house_queries import WordsQuery

pytestmark = pytest.mark.virtual_time

BOTH_WAYS = pytest.mark.parametrize("delivery", ["inbox", "mirror"])


class Ear:
    """A handler that writes down what it hears."""

    def __init__(self) -> None:
        self._heard: list[str] = []

    def __call__(self, message: RawMessage) -> None:
        self._heard.append(f"{message.key} {message.text()}")

    async def heard(self) -> list[str]:
        """What was heard since the last call."""
        await anyio.sleep(0.01)
        heard, self._heard = self._heard, []
        return heard


async def find(devices: Devices, device_id: str) -> Device:
    await anyio.sleep(0.001)
    (device,) = [one for one in await devices.find() if one.id == device_id]
    return device


@BOTH_WAYS
async def test_a_listener_receives_its_devices_in_order_and_no_others(
    graph: Graph, run_gateway: RunGateway, run_directory: RunDirectory, delivery: str
) -> None:
    """Also what they said since it came into being, but not what they said before."""
    async with run_gateway(delivery=delivery) as gateway, run_directory():
        await gateway.says("lights/a", "before")
        await anyio.sleep(1)
        async with Node(graph, "app") as node:
            devices, ear = Devices(node), Ear()
            await gateway.says("lights/a", "missed")
            await devices.listen(await find(devices, "lights/a"), ear)
            await gateway.says("lights/a", "live")
            await gateway.says("lights/b", "not asked for")
            assert await ear.heard() == ["lights/a missed", "lights/a live"]


@BOTH_WAYS
async def test_listening_again_replaces_the_handler_and_brings_nothing_twice(
    run_gateway: RunGateway, node: Node, delivery: str
) -> None:
    """An app that listens at every change of a device must not answer old messages anew."""
    async with run_gateway(delivery=delivery) as gateway:
        devices, first, second = Devices(node), Ear(), Ear()
        await gateway.says("lights/a", "one")
        lamp = await find(devices, "lights/a")
        await devices.listen(lamp, first)
        assert await first.heard() == ["lights/a one"]
        await devices.listen(lamp, second)
        await gateway.says("lights/a", "two")
        assert await first.heard() == []
        assert await second.heard() == ["lights/a two"]


@BOTH_WAYS
async def test_a_device_that_was_removed_and_is_back_is_heard_once(
    run_gateway: RunGateway, node: Node, delivery: str
) -> None:
    """Its first word after the return comes live; listening again does not repeat it."""
    async with run_gateway(delivery=delivery) as gateway:
        devices, ear = Devices(node), Ear()
        await gateway.says("lights/a", "one")
        await devices.listen(await find(devices, "lights/a"), ear)
        gateway.removes("lights/a")
        await anyio.sleep(1)
        await gateway.says("lights/a", "back")
        await devices.listen(await find(devices, "lights/a"), ear)
        assert await ear.heard() == ["lights/a one", "lights/a back"]


@BOTH_WAYS
async def test_a_restarted_gateway_is_asked_again(run_gateway: RunGateway, node: Node, delivery: str) -> None:
    """It has forgotten who listens; what it heard before it was asked is not lost."""
    devices, ear = Devices(node), Ear()
    async with run_gateway(delivery=delivery) as gateway:
        for key in ("lights/a", "lights/b"):
            await gateway.says(key, "one")
            await devices.listen(await find(devices, key), ear)
        assert await ear.heard() == ["lights/a one", "lights/b one"]
    async with run_gateway(delivery=delivery) as gateway:
        await gateway.says("lights/a", "two")
        assert await ear.heard() == ["lights/a two"]
        await gateway.says("lights/b", "three")
        assert await ear.heard() == ["lights/b three"]


async def test_a_gateway_that_is_away_is_asked_when_it_comes(run_gateway: RunGateway, node: Node) -> None:
    """The wish to listen stands."""
    devices, ear = Devices(node), Ear()
    async with run_gateway() as gateway:
        gateway.sees("lights/a")
        lamp = await find(devices, "lights/a")
    await devices.listen(lamp, ear)
    async with run_gateway() as gateway:
        await anyio.sleep(0.001)
        await gateway.says("lights/a", "hello")
        assert await ear.heard() == ["lights/a hello"]


async def test_a_refusal_is_raised_and_may_be_tried_again(run_gateway: RunGateway, node: Node) -> None:
    """With the gateway's reason."""
    async with run_gateway(refused=("lights/a/out",)) as gateway:
        gateway.sees("lights/a")
        devices = Devices(node)
        lamp = await find(devices, "lights/a")
        for _ in range(2):
            with pytest.raises(RefusedError, match="lights/a/out was refused: the test refuses it"):
                await devices.listen(lamp, Ear())


async def test_a_restarted_gateway_that_now_refuses_is_told_and_ends_nothing(
    run_gateway: RunGateway, node: Node
) -> None:
    """The app goes on with its other devices."""
    devices, ear = Devices(node), Ear()
    async with run_gateway() as gateway:
        for key in ("lights/a", "lights/b"):
            gateway.sees(key)
            await devices.listen(await find(devices, key), ear)
    with capture_logs() as lines:
        async with run_gateway(refused=("lights/a/out",)) as gateway:
            await anyio.sleep(0.001)
            await gateway.says("lights/b", "hello")
            assert await ear.heard() == ["lights/b hello"]
    told = [line["message"] for line in lines if line["event"] == "devices.not_heard"]
    assert told == ["lights/a/out is no longer received: listening to lights/a/out was refused: the test refuses it"]


async def test_a_gateway_that_fails_to_answer_is_an_error() -> None:
    """Other than one that is away."""
    graph = Graph()

    def fail(_request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        raise RuntimeError("ouch")

    async with Node(graph, "broken", namespace="/gateway") as gateway, Node(graph, "app") as node:
        gateway.create_service(SubscribeToTopic, "~/subscribe_to_topic", fail)
        with pytest.raises(ServiceFailedError, match="ouch"):
            await Devices(node).listen(_device("broken"), Ear())


async def test_a_gateway_that_flickers_is_asked_at_its_next_start(
    run_gateway: RunGateway, node: Node, graph: Graph
) -> None:
    """It is gone again before it could be asked."""
    devices, ear = Devices(node), Ear()
    async with run_gateway() as gateway:
        gateway.sees("lights/a")
        await devices.listen(await find(devices, "lights/a"), ear)
    FakeGateway(flicker := Node(graph, "fake", namespace="/gateway"))
    flicker.close()
    await anyio.sleep(0.01)
    async with run_gateway() as gateway:
        await anyio.sleep(0.01)
        await gateway.says("lights/a", "hello")
        assert await ear.heard() == ["lights/a hello"]


async def test_a_command_reaches_the_device_through_its_gateway(gateway: FakeGateway, node: Node) -> None:
    """On the address where it listens."""
    gateway.sees("lights/a")
    devices = Devices(node)
    await devices.tell(await find(devices, "lights/a"), "off")
    await anyio.sleep(0.001)
    assert gateway.told == [("lights/a/in", "off")]


async def test_a_device_that_takes_no_commands_refuses_them(gateway: FakeGateway, node: Node) -> None:
    """A sensor, for one."""
    gateway.sees("sensors/t", takes_commands=False)
    devices = Devices(node)
    with pytest.raises(RefusedError, match="a command to sensors/t was refused: it takes no commands"):
        await devices.tell(await find(devices, "sensors/t"), "off")


async def test_a_command_for_a_gateway_that_is_away_is_not_lost_in_silence() -> None:
    """It is an error that may pass."""
    async with Node(Graph(), "app") as node:
        with pytest.raises(LinkError, match="'off' was not sent to lights/x: its gateway fake is not running"):
            await Devices(node).tell(_device("fake"), "off")


async def test_a_command_for_a_gateway_without_its_network_is_not_lost_in_silence() -> None:
    """It is sent once the gateway reaches its network again."""
    graph = Graph()
    async with Node(graph, "app") as node, Node(graph, "fake", namespace="/gateway") as gateway:
        out = gateway.create_subscription(RawCommand, "~/out", qos_profile=10)
        states = gateway.create_publisher(GatewayState, "~/state", qos_profile_latched)
        devices = Devices(node)
        await devices.tell(_device("fake"), "on")
        states.publish(GatewayState(state="unavailable", reason="the broker is away", acts=True))
        with pytest.raises(LinkError, match="its gateway fake is unavailable: the broker is away"):
            await devices.tell(_device("fake"), "off")
        states.publish(GatewayState(state="active", reason="", acts=True))
        await devices.tell(_device("fake"), "on")
        assert [(await out.receive()).payload for _ in range(2)] == ["on", "on"]
        assert out.take() is None


async def test_a_text_for_a_gateway_that_is_away_waits_for_it_and_not_for_one_that_observes() -> None:
    graph = Graph()
    async with Node(graph, "app") as node, Node(graph, "fake", namespace="/gateway") as gateway:
        gateway.create_publisher(GatewayState, "~/state", qos_profile_latched).publish(
            GatewayState(state="active", reason="", acts=False)
        )
        device = _device("fake")
        both = device.model_copy(update={"endpoints": device.endpoints + _device("other").endpoints})
        with pytest.raises(LinkError, match="its gateway other is not running"):
            await Devices(node).tell(both, "off")
        with pytest.raises(RefusedError, match="the gateway only observes"):
            await Devices(node).tell(device, "off")


async def test_a_command_that_waits_for_a_gateway_that_goes_away_is_not_lost_in_silence() -> None:
    """The queue was full, and then nobody was there to read it."""
    graph = Graph()
    async with Node(graph, "app") as node:
        gateway = Node(graph, "fake", namespace="/gateway")
        gateway.create_subscription(RawCommand, "~/out", qos_profile=1)
        devices = Devices(node)
        await devices.tell(_device("fake"), "on")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(_close_soon, gateway)
            with pytest.raises(LinkError):
                await devices.tell(_device("fake"), "off")


async def _close_soon(node: Node) -> None:
    await anyio.sleep(1)
    node.close()


async def test_without_a_directory_finding_devices_is_an_error() -> None:
    """That is an error, not an empty house."""
    async with Node(Graph(), "app") as node:
        with pytest.raises(ServiceUnavailableError, match="/discovery/find_devices"):
            await Devices(node).find("lights")


def test_a_payload_that_is_no_text_is_told_with_its_address() -> None:
    """And with its first bytes."""
    message = RawMessage(
        gateway="g", key="k", address="a/b", payload=b"\xff", retained=False, received_at=Time(sec=0, nanosec=0)
    )
    with pytest.raises(WireError, match=r"the payload on a/b is not text \(frame: ff\)"):
        message.text()


async def test_an_endpoint_of_something_that_is_no_gateway_costs_itself_and_not_the_app() -> None:
    """The other endpoints are listened to all the same."""
    graph = Graph()
    async with Node(graph, "g", namespace="/gateway") as gateway_node, Node(graph, "app") as node:
        gateway = FakeGateway(gateway_node)
        devices = Devices(node)
        bad, good = _device("no gateway!"), _device("g")
        device = good.model_copy(update={"endpoints": bad.endpoints + good.endpoints})
        heard: list[str] = []
        with pytest.raises(RefusedError, match="has a character that is not allowed in names"):
            await devices.listen(device, lambda message: heard.append(message.text()))
        await gateway.says("lights/x", "on")
        await anyio.wait_all_tasks_blocked()
        assert heard == ["on"]
        with pytest.raises(RefusedError, match="has a character that is not allowed in names"):
            await devices.tell(bad, "off")
        await devices.tell(device, "off")
        await anyio.wait_all_tasks_blocked()
        assert gateway.told == [("lights/x/in", "off")]


def _device(gateway: str) -> Device:
    now = Time(sec=0, nanosec=0)
    endpoint = Endpoint(gateway=gateway, key="lights/x", address="lights/x/out", command_address="lights/x/in")
    return Device(
        id="lights/x",
        name="x",
        service_type="lights",
        endpoints=(endpoint,),
        metadata=(),
        first_seen=now,
        last_seen=now,
        expires=now,
        freshness="fresh",
    )


async def find_words(words: str, node: Node) -> None:
    assert await Devices(node).find(words) == ()


async def follow_words(words: str, node: Node) -> None:
    await anext(Devices(node).follow(words))


async def follow_query(words: str, node: Node) -> None:
    await read_all(Follow(node, words=WordsQuery(words)))


MISSPELT: dict[str, Callable[[Node], Awaitable[object]]] = {
    "find('lihgts'): 'lihgts' is not a device type, and no device was announced as one; did you mean lights?": (
        lambda node: Devices(node).find("lihgts")
    ),
    "follow('lihgts'): 'lihgts' is not a device type, and no device was announced as one; did you mean lights?": (
        lambda node: anext(Devices(node).follow("lihgts"))
    ),
    **{
        f"{call}('{words}'): {problem}.": partial(ask, words)
        for words, problem in (
            ("locks", "nothing in the house is of this type"),
            ("door_lock", "nothing in the house is of this type"),
        )
        for call, ask in (("find", find_words), ("follow", follow_words))
    },
    **{
        f"follow('{words}'): {problem}.": partial(follow_query, words)
        for words, problem in (
            ("unlocked locks", "nothing in the house is of this type"),
            ("locks in hall", "nothing in the house is of this type"),
            ("locks or vacuums", "nothing in the house is of this type"),
            ("lights on in nowhere", "no device is in 'nowhere'; areas are hall, home"),
            ("lights tag:foo", "no device has the tag 'foo'; tags are none"),
            ("lights chandelier", "no device has the word 'chandelier'"),
        )
    },
    "find('lanterns'): 'lanterns' is not a device type, and no device was announced as one; did you mean ": (
        lambda node: Devices(node).find("lanterns")
    ),
    "find(Light, area='nowhere'): no device is in 'nowhere'; areas are hall, home.": (
        lambda node: Devices(node).find(Light, area="nowhere")
    ),
    "follow(Light, tag='foo').became(on=True): no device has the tag 'foo'; tags are none.": (
        lambda node: anext(Devices(node).follow(Light, tag="foo").became(on=True))
    ),
    "find(Light, name='no such lamp', area='hall'): nothing is called 'no such lamp'; did you mean hall lamp?": (
        lambda node: Devices(node).find(Light, name="no such lamp", area="hall")
    ),
    "find(Light, area='Hal'): no device is in 'hal'; did you mean hall?": (
        lambda node: Devices(node).find(Light, area="Hal")
    ),
    "follow(Light, area='Hal', on=True): no device is in 'hal'; did you mean hall?": (
        lambda node: anext(Devices(node).follow(Light, area="Hal", on=True))
    ),
    "follow('lights not in hal'): no device is in 'hal'; did you mean hall?": (
        lambda node: read_all(Follow(node, words=WordsQuery("lights not in hal")))
    ),
    "find(DoorLock): nothing in the house is of this type.": lambda node: Devices(node).find(DoorLock),
    "find(DoorLock, area='hall', locked=False): nothing in the house is of this type.": (
        lambda node: Devices(node).find(DoorLock, area="hall", locked=False)
    ),
    "follow(DoorLock): nothing in the house is of this type.": lambda node: anext(Devices(node).follow(DoorLock)),
    "follow(DoorLock).became(locked=True): nothing in the house is of this type.": (
        lambda node: anext(Devices(node).follow(DoorLock).became(locked=True))
    ),
    "follow(DoorLock, area=''): nothing in the house is of this type.": (
        lambda node: anext(Devices(node).messages(DoorLock, area=""))
    ),
}


async def read_all(query: Follow) -> None:
    async for _ in query:
        pass


async def expect_one_problem(
    gateway: FakeGateway, node: Node, problem: str, ask: Callable[[Node], Awaitable[object]]
) -> None:
    """Ask twice, in a house with a lamp in the hall, which is told once."""
    await hall_lamp(gateway, node)
    with capture_logs() as lines, anyio.move_on_after(400):
        for _ in range(2):
            await ask(node)
        await anyio.sleep_forever()
    told = [one["message"] for one in lines if one["event"] == "devices.unknown_name"]
    (line,) = told
    assert line.startswith(problem)
    assert line.endswith(" Until a device comes, it finds nothing.")
    names = HouseView.of(node).names
    assert await names.problems() == tuple(told)
    assert await names.mistakes() == (line.removesuffix(" Until a device comes, it finds nothing.").removesuffix("."),)


@pytest.mark.parametrize(("problem", "ask"), MISSPELT.items(), ids=MISSPELT)
async def test_a_misspelt_query_is_logged_once_and_goes_on(
    gateway: FakeGateway, node: Node, problem: str, ask: Callable[[Node], Awaitable[object]]
) -> None:
    """It raised an error, which ended an app for ever although the device came a minute later."""
    await expect_one_problem(gateway, node, problem, ask)


async def test_a_kind_that_the_house_may_lack_is_no_problem(gateway: FakeGateway, node: Node) -> None:
    """An app may take windows or contact sensors, whichever there are."""
    await hall_lamp(gateway, node)
    with capture_logs() as lines, anyio.move_on_after(400):
        await Devices(node).find(DoorLock, area="Hal", optional=True)
        await Devices(node).find(Light, on=False)
        await anext(Devices(node).follow(DoorLock, optional=True).became(locked=True))
    assert [line for line in lines if line["log_level"] != "info"] == []
    assert await HouseView.of(node).names.problems() == await HouseView.of(node).names.mistakes() == ()


async def test_the_names_of_a_query_that_has_ended_are_no_problem(gateway: FakeGateway, node: Node) -> None:
    await hall_lamp(gateway, node)
    query = Devices(node).follow(Light, area="Hal")
    with anyio.move_on_after(20):
        await anext(query)
    names = HouseView.of(node).names
    assert len(await names.problems()) == 1
    query.close()
    assert await names.problems() == await names.mistakes() == ()


async def test_the_names_of_the_first_hundred_queries_are_checked(gateway: FakeGateway, node: Node) -> None:
    await hall_lamp(gateway, node)
    for number in range(110):
        await Devices(node).find(Light, area="Hal", name=f"lamp {number}")
    assert len(await HouseView.of(node).names.mistakes()) == 100


async def test_what_may_yet_be_announced_is_not_refused(gateway: FakeGateway, node: Node) -> None:
    await hall_lamp(gateway, node)
    devices = Devices(node)
    assert await devices.find(Light, area="Hall") == ()
    assert await devices.find(Light, area="Cellar") == ()
    assert await devices.find("xyzzy") == ()
    query = devices.follow("robots")
    with anyio.move_on_after(400):
        await anext(query)
    await gateway.says("robots/robi", "x")
    assert (await anext(query)).device.id == "robots/robi"


async def hall_lamp(gateway: FakeGateway, node: Node) -> None:
    await gateway.says("lights/hall_lamp", "on")
    await anyio.sleep(0.01)
    await place(node, "lights/hall_lamp", "Hall")


async def place(node: Node, device: str, room: str) -> None:
    request = PlaceDevice.Request(device=device, room=room, is_new=True)
    await node.create_client(PlaceDevice, PLACE_DEVICE).call(request)
    await anyio.sleep(0.01)


@pytest.mark.parametrize("ask", ["find", "follow"])
async def test_a_sentence_is_no_type(ask: str) -> None:
    async with Node(Graph(), "app") as node:
        devices = Devices(node)
        with pytest.raises(ValueError, match="'lihgts in kichen' is a sentence, not a type of device; ask for a kind"):
            await devices.find("lihgts in kichen") if ask == "find" else devices.follow("lihgts in kichen")
