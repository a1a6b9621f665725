"""The Zenoh session of the bridge, on this computer."""

import anyio
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import house_rights, robot_rights

from homebot.bridges.ros2.session import WireQuery, WireSample, open_session
from homebot.graph.qos import HistoryPolicy, QoSProfile
from homebot.messages.interfaces.settings import RosSettings

ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)


@pytest.mark.parametrize(("count", "size", "most"), [(1500, 4, 1000), (12, 6_553_600, 10)])
async def test_more_messages_than_wait_for_the_loop_are_lost_counted_and_told(count: int, size: int, most: int) -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    listening = RosSettings.model_validate({"listen": address, "import": {"rosie": ("/rosie/*",)}})
    connecting = RosSettings.model_validate({"connect": (address,), "export": ("/rosie/*",)})
    got: list[WireSample] = []
    async with (
        open_session(listening, house_rights(listening)) as router,
        open_session(connecting, robot_rights(connecting, "rosie")) as robot,
    ):
        there, done = anyio.Event(), anyio.Event()

        def took(sample: WireSample) -> None:
            if sample.payload == b"first":
                there.set()
                return
            got.append(sample)
            if len(got) + router.lost == count:
                done.set()

        reading = router.subscribe("0/rosie/words/T/H", ALL, took)
        writer = robot.publish("0/rosie/words/T/H", ALL)
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
