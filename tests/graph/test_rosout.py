"""/rosout: log lines as messages."""

import io
from collections.abc import AsyncIterator

import anyio.to_thread
import pytest
import structlog
from tests.patience import PATIENCE

from homebot.graph import Graph, Node, RosoutFeed, Subscription, qos_profile_rosout
from homebot.log import configure_logging
from homebot.messages import Log


@pytest.fixture
async def feed(graph: Graph) -> AsyncIterator[RosoutFeed]:
    feed = RosoutFeed(Node(graph, "log"))
    configure_logging(stream=io.StringIO(), level="debug", processors=[feed])
    yield feed
    structlog.reset_defaults()


@pytest.fixture
def lines(graph: Graph, feed: RosoutFeed) -> Subscription[Log]:
    return Node(graph, "reader").create_subscription(Log, "/rosout", qos_profile=qos_profile_rosout)


@pytest.mark.virtual_time
async def test_a_log_line_is_a_message(graph: Graph, lines: Subscription[Log]) -> None:
    node = Node(graph, "lamp", namespace="/kitchen")
    node.log.warning("lamp.lost", address="here")
    line = await lines.receive()
    assert (line.level, line.name, line.msg) == (30, "kitchen.lamp", "lamp.lost  address=here")
    assert line.stamp.sec == 1_700_000_000


@pytest.mark.parametrize(
    ("method", "level"),
    [("debug", 10), ("info", 20), ("warning", 30), ("error", 40), ("critical", 50)],
)
async def test_levels_are_those_of_ros(lines: Subscription[Log], method: str, level: int) -> None:
    getattr(structlog.get_logger(), method)("a.b")
    assert (await lines.receive()).level == level


async def test_words_for_people_are_the_message(lines: Subscription[Log]) -> None:
    structlog.get_logger().info("a.b", message="The lamp is gone.", x=1)
    line = await lines.receive()
    assert (line.name, line.msg) == ("homebot", "The lamp is gone.")


async def test_a_late_reader_gets_the_last_lines(graph: Graph, feed: RosoutFeed) -> None:
    structlog.get_logger().info("early")
    late = Node(graph, "late").create_subscription(Log, "/rosout", qos_profile=qos_profile_rosout)
    assert (await late.receive()).msg == "early"


async def test_text_that_is_no_unicode_does_not_break_the_log(lines: Subscription[Log]) -> None:
    structlog.get_logger().info("a.b", message="file \udcff")
    assert (await lines.receive()).msg == "file ?"


async def test_a_line_from_another_thread_comes_by_way_of_the_loop(lines: Subscription[Log]) -> None:
    await anyio.to_thread.run_sync(structlog.get_logger().info, "from.thread")
    with anyio.fail_after(PATIENCE):
        assert (await lines.receive()).msg == "from.thread"


async def test_after_its_node_is_closed_lines_pass_unpublished(graph: Graph) -> None:
    node = Node(graph, "log")
    feed = RosoutFeed(node)
    event = {"event": "a.b", "level": "info"}
    node.close()
    assert feed(None, "info", event) is event
    assert graph.get_message_type("/rosout") is None


async def test_a_line_from_another_thread_after_the_end_passes(graph: Graph) -> None:
    node = Node(graph, "log")
    feed = RosoutFeed(node)

    def log_and_close() -> None:
        feed(None, "info", {"event": "a.b"})
        node.close()

    await anyio.to_thread.run_sync(log_and_close)
    await anyio.lowlevel.checkpoint()
    assert node.is_closed
