"""What ``homebot doctor`` says of the link: types that differ, and what is refused."""

import anyio
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs
from tests.features.ros2.bare_robot import meeting
from tests.patience import PATIENCE

from homebot.bridges.zenoh.attachment import Attachment
from homebot.bridges.zenoh.tokens import NO_HASH
from homebot.features.ros2.health import NOT_IMPORTED
from homebot.features.ros2.imports import MAX_TOKENS_OF_ONE
from homebot.graph import EntityKind, QoSProfile
from homebot.messages import String
from homebot.messages.cdr import message_to_cdr
from homebot.messages.std_srvs import Trigger
from homebot.messages.type_hash import type_hash

OTHER_HASH = f"RIHS01_{'0' * 64}"
OLD_ATTACHMENT = (
    b"\x0fsequence_number" + bytes(8) + b"\x10source_timestamp" + bytes(8) + b"\x0asource_gid\x10" + bytes(16)
)


@pytest.mark.parametrize(
    ("kind", "name", "ros_type", "the_hash", "problem"),
    [
        (
            EntityKind.SUBSCRIPTION,
            "/house/words",
            String.ros_type,
            OTHER_HASH,
            f"is {OTHER_HASH}, here {type_hash(String)}",
        ),
        (
            EntityKind.CLIENT,
            "/house/light",
            Trigger.ros_type,
            OTHER_HASH,
            f"is {OTHER_HASH}, here {type_hash(Trigger)}",
        ),
        (
            EntityKind.PUBLISHER,
            "/rosie/words",
            String.ros_type,
            OTHER_HASH,
            f"is {OTHER_HASH}, here {type_hash(String)}",
        ),
        (
            EntityKind.SERVICE,
            "/rosie/dock",
            Trigger.ros_type,
            OTHER_HASH,
            f"is {OTHER_HASH}, here {type_hash(Trigger)}",
        ),
        (
            EntityKind.SUBSCRIPTION,
            "/house/words",
            "std_msgs/msg/Int32",
            OTHER_HASH,
            "a std_msgs/msg/Int32, here a std_msgs/msg/String",
        ),
        (EntityKind.SUBSCRIPTION, "/house/words", String.ros_type, NO_HASH, "as in ROS 2 Humble"),
    ],
)
async def test_a_type_that_differs_is_a_trouble_while_its_robot_is_there(
    kind: EntityKind, name: str, ros_type: str, the_hash: str, problem: str
) -> None:
    async with meeting() as both:
        both.app.create_publisher(String, "/house/words")
        both.app.create_service(Trigger, "/house/light", lambda _: Trigger.Response(success=True, message=""))
        both.declare(both.token(kind, name, ros_type, the_hash))
        (trouble,) = await both.troubles(1)
        assert trouble.startswith(f"{name} of /rosie/nav ")
        assert problem in trouble
        both.take_back()
        await both.troubles(0)


async def test_of_many_troubles_some_are_told() -> None:
    with capture_logs() as lines:
        await many_troubles()
    assert sum(line["event"] == NOT_IMPORTED for line in lines) == 20


async def many_troubles() -> None:
    async with meeting() as both:
        for number in range(25):
            both.declare(both.token(EntityKind.SERVICE, f"/rosie/dock{number}", Trigger.ros_type, OTHER_HASH))
        with anyio.fail_after(PATIENCE):
            while (await both.troubles(21))[-1] != "5 more do not pass":  # it was fewer before all had come
                await anyio.lowlevel.checkpoint()


@pytest.mark.parametrize("the_hash", [type_hash(String), NO_HASH])
async def test_messages_of_older_ros_2_are_read_and_what_is_none_is_refused_and_counted(the_hash: str) -> None:
    with capture_logs() as lines:
        async with meeting() as both:
            token = both.declare(both.token(EntityKind.PUBLISHER, "/rosie/words", String.ros_type, the_hash))
            words = both.app.create_subscription(String, "/rosie/words")
            writer = both.robot.publish(token.key, QoSProfile())
            payload, got = message_to_cdr(String(data="hello")), anyio.Event()

            async def listen() -> None:
                await words.receive()
                got.set()

            with anyio.fail_after(PATIENCE):
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(listen)
                    while not got.is_set():
                        writer.put(payload, attachment=OLD_ATTACHMENT)
                        with anyio.move_on_after(0.1):
                            await got.wait()
                for attachment, data in ((b"", payload), (Attachment(1, 0, bytes(16)).to_bytes(), payload[:-1])):
                    writer.put(data, attachment=attachment)
                while (await both.health()).counts[0].count < 2:
                    await anyio.lowlevel.checkpoint()
    assert [line["subject"] for line in lines if line["event"] == "ros2.message_refused"] == ["/rosie/words"]


async def test_one_process_takes_no_more_than_its_share_of_entities_and_the_rest_are_counted() -> None:
    async with meeting() as both:
        for number in range(MAX_TOKENS_OF_ONE + 5):
            both.declare(both.token(EntityKind.SUBSCRIPTION, f"/other/t{number}", "std_msgs/msg/String", "RIHS01_x"))
        (trouble,) = await both.troubles(1)
        assert trouble.startswith(f"a process of a robot has more than {MAX_TOKENS_OF_ONE} entities")
        with anyio.fail_after(PATIENCE):
            while {one.name: one.count for one in (await both.health()).counts}["not_imported"] != 5:
                await anyio.lowlevel.checkpoint()
        both.take_back()
        await both.troubles(0)
