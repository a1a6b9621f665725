"""The Zenoh session of the bridge, on this computer."""

import sys
import threading
import time
from functools import partial
from queue import Empty, SimpleQueue
from typing import Final

import anyio
import anyio.lowlevel
import pytest
import zenoh
from anyio import to_thread
from structlog.testing import capture_logs
from tests.hanging_link import HangingLink
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import house_rights, log_in, robot_rights

from homebot.bridges.zenoh.lanes import Lanes
from homebot.bridges.zenoh.session import WireQuery, WireSample, open_session
from homebot.graph.qos import HistoryPolicy, QoSProfile
from homebot.messages.interfaces.settings import RosSettings

ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)


def name_thread() -> bytes:
    return threading.current_thread().name.encode()


@pytest.mark.parametrize(("count", "size", "most"), [(1500, 4, 1000), (12, 6_553_600, 10)])
async def test_more_messages_than_wait_for_the_loop_are_lost_counted_and_told(count: int, size: int, most: int) -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    listening = RosSettings.model_validate({"listen": address, "import": {"rosie": ("/rosie/*",)}})
    got: list[WireSample] = []
    async with open_session(listening, house_rights(listening)) as router:
        there, done = anyio.Event(), anyio.Event()

        def took(sample: WireSample) -> None:
            if sample.payload == b"first":
                there.set()
                return
            got.append(sample)
            if len(got) + router.lost == count:
                done.set()

        reading = router.subscribe("0/rosie/words/T/H", ALL, took)
        robot = log_in(address, "rosie", patience=PATIENCE)
        writer = robot.declare_publisher("0/rosie/words/T/H", congestion_control=zenoh.CongestionControl.BLOCK)
        with anyio.fail_after(PATIENCE), capture_logs() as lines:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(router.run)
                while not there.is_set():
                    writer.put(b"first", attachment=b"")
                    with anyio.move_on_after(0.2):
                        await there.wait()
                tasks.cancel_scope.cancel()
            for number in range(count):
                writer.put(number.to_bytes(size), attachment=b"")
            while router.lost < count - most:
                await anyio.lowlevel.checkpoint()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(router.run)
                await done.wait()
                await anyio.lowlevel.checkpoint()  # what was lost is told after the last
                tasks.cancel_scope.cancel()
        reading.undeclare()
        robot.close()  # type: ignore[no-untyped-call]
    assert [int.from_bytes(one.payload) for one in got] == list(range(len(got)))
    assert [(line["event"], line["lost"]) for line in lines] == [("ros2.lost", count - len(got))]


async def test_a_server_that_does_not_answer_in_time_has_not_answered() -> None:
    """Zenoh has an error for that, which is none of the server."""
    address, asked = f"tcp/127.0.0.1:{reserve_port()}", list[WireQuery]()
    listening = RosSettings.model_validate({"listen": address, "import": {"rosie": ("/rosie/*",)}})
    connecting = RosSettings.model_validate({"connect": (address,), "export": ("/rosie/*",)})
    async with (
        open_session(listening, house_rights(listening)) as router,
        open_session(connecting, robot_rights(connecting, "rosie")) as robot,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(router.run)
        tasks.start_soon(robot.run)
        robot.serve("0/rosie/dock/T/H", asked.append)
        with anyio.fail_after(PATIENCE):
            while not asked:
                assert await router.ask("0/rosie/dock/T/H", b"", b"", 0.3) is None
        tasks.cancel_scope.cancel()


async def test_a_peer_that_reads_nothing_holds_up_neither_the_loop_nor_other_peers() -> None:
    """Answers, refusals, questions and samples to it wait on a thread of its own, as many as are allowed."""
    size, count, port = 1_000_000, 40, reserve_port()
    listening = RosSettings.model_validate(
        {"listen": f"tcp/127.0.0.1:{port}", "export": ("/house/*",), "import": {"rosie": ("/rosie/*",)}}
    )
    asked, turns = list[WireQuery](), list[float]()
    async with HangingLink(port).running() as link, anyio.create_task_group() as tasks:
        ways = {"export": ("/rosie/*",), "import": {"house": ("/house/*",)}}
        connecting = RosSettings.model_validate({"connect": (link.address,), **ways})
        direct = RosSettings.model_validate({"connect": (listening.listen,), **ways})
        async with (
            open_session(listening, house_rights(listening)) as house,
            open_session(connecting, robot_rights(connecting, "rosie")) as robot,
            open_session(direct, robot_rights(direct, "rosie")) as other,
        ):
            for session in (house, robot, other):
                tasks.start_soon(session.run)
            house.serve("0/house/slow/T/H", asked.append)
            house.serve("0/house/fast/T/H", lambda query: query.reply(name_thread, query.attachment))
            robot.serve("0/rosie/dock/T/H", lambda query: query.reply(lambda: b"docked", query.attachment))
            robot.subscribe("0/house/map/T/H", ALL, lambda _: None)
            with anyio.fail_after(PATIENCE):
                while await other.ask("0/house/fast/T/H", b"", b"o" * 33, 1.0) != b"zenoh lane":
                    pass
                while await house.ask("0/rosie/dock/T/H", b"", b"h" * 33, 1.0) != b"docked":
                    pass
                for _ in range(count):
                    tasks.start_soon(robot.ask, "0/house/slow/T/H", b"", b"r" * 33, PATIENCE)
                while len(asked) < count:
                    await anyio.lowlevel.checkpoint()
            link.hang()
            maps = house.publish("0/house/map/T/H", ALL)
            began = anyio.current_time()
            for query in asked:
                query.reply(partial(bytes, size), query.attachment)
                maps.put(bytes(size), attachment=b"m" * 33)
                assert await other.ask("0/house/fast/T/H", b"", b"o" * 33, PATIENCE) == b"zenoh lane"
                turns.append(anyio.current_time() - began)
                began = anyio.current_time()
            assert await house.ask("0/rosie/dock/T/H", b"", b"h" * 33, 1.0) is None
            assert max(turns) < 1.0, "not the five seconds after which Zenoh gives up a peer"
            assert house.lost > 0
            tasks.cancel_scope.cancel()


async def test_answers_to_many_peers_are_written_one_at_a_time() -> None:
    """The event loop then shares the interpreter with one thread, not with one for each peer."""
    lanes, at_work, most = Lanes(lambda: None), list[int](), list[int]()
    is_written = SimpleQueue[None]()

    def encode() -> bytes:
        at_work.append(1)
        most.append(len(at_work))
        time.sleep(0.01)  # others have the interpreter
        at_work.pop()
        return b""

    for number in range(8):
        WireQuery(Asked(number, is_written), lanes).reply(encode, b"")
    for _ in range(8):
        await to_thread.run_sync(is_written.get)
    assert most == [1] * 8


async def test_a_panic_inside_zenoh_stops_no_later_call_of_the_peer() -> None:
    """It ended the thread, and what waited for the peer was never sent."""
    told, done = list[int](), SimpleQueue[str]()
    lanes = Lanes(lambda: told.append(1))

    class PanicError(BaseException):
        """As PyO3's, which is no Exception."""

    def panic() -> None:
        raise PanicError("PoisonError")

    assert lanes.make("rosie", panic, 0)
    assert lanes.make("rosie", partial(done.put, "sent"), 0)
    assert await to_thread.run_sync(done.get) == "sent"
    assert (lanes.failed, lanes.problem, told) == (1, "PanicError: PoisonError", [1])


async def test_answers_that_wait_are_not_made_on_a_session_that_closes() -> None:
    """Zenoh panicked in each of them where the peer closed at the same time."""
    lanes, made, goes_on = Lanes(lambda: None), SimpleQueue[str](), threading.Event()
    assert lanes.make("rosie", goes_on.wait, 0)
    assert lanes.make("rosie", partial(made.put, "late"), 0)
    lanes.close()
    assert not lanes.make("rosie", partial(made.put, "later"), 0)
    assert not lanes.make("bob", partial(made.put, "later"), 0)
    goes_on.set()
    with pytest.raises(Empty):
        await to_thread.run_sync(partial(made.get, timeout=0.1))


_ASKS: Final = """
import sys
from tests.robots_on_wire import log_in
with log_in(sys.argv[1], "rosie", patience=20.0) as session:
    for _ in range(30):
        session.get("0/house/slow/T/H", lambda _: None, payload=b"", attachment=bytes(33), timeout=60.0)
    sys.stdin.read()
"""


async def test_replies_go_on_after_a_peer_died_in_the_middle_of_its_queries() -> None:
    address, asked = f"tcp/127.0.0.1:{reserve_port()}", list[WireQuery]()
    listening = RosSettings.model_validate(
        {"listen": address, "export": ("/house/*",), "import": {"rosie": ("/rosie/*",)}}
    )
    connecting = RosSettings.model_validate({"connect": (address,), "import": {"house": ("/house/*",)}})
    async with (
        open_session(listening, house_rights(listening)) as house,
        open_session(connecting, robot_rights(connecting, "rosie")) as other,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(house.run)
        tasks.start_soon(other.run)
        house.serve("0/house/slow/T/H", asked.append)
        house.serve("0/house/fast/T/H", lambda query: query.reply(lambda: b"on", query.attachment))
        with anyio.fail_after(PATIENCE):
            for _ in range(3):
                async with await anyio.open_process([sys.executable, "-c", _ASKS, address]) as robot:
                    while len(asked) < 30:
                        await anyio.lowlevel.checkpoint()
                    for query in asked[:10]:
                        query.reply(partial(bytes, 100_000), query.attachment)
                    robot.kill()
                for query in asked[10:]:
                    query.reply(partial(bytes, 100_000), query.attachment)
                asked.clear()
                while await other.ask("0/house/fast/T/H", b"", b"o" * 33, 1.0) != b"on":
                    pass
        assert (house.lost, house.panicked.is_set()) == (0, False)
        tasks.cancel_scope.cancel()


class Asked:
    """A query of Zenoh from a peer of its own."""

    payload = None
    key_expr = ""

    def __init__(self, peer: int, is_over: SimpleQueue[None]) -> None:
        self.attachment = bytes([peer]) * 33
        self._is_over = is_over

    def reply(self, *_: object, **__: object) -> None:
        """Take an answer."""

    def drop(self) -> None:
        """Note that it is over."""
        self._is_over.put(None)
