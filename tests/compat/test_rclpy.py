"""rclpy's calls one by one, with the graph in the test's own process."""

import re
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE

from homebot.compat import rclpy
from homebot.compat.messages import program_type
from homebot.errors import DuplicateNameError, QosError, ServiceUnavailableError, TypeMismatchError, UsageError
from homebot.messages import Duration, SetBool, String, Time
from homebot.messages.interfaces import find_action, find_message, find_service
from homebot.messages.rcl_interfaces import Parameter, ParameterValue
from homebot.messages.std_msgs import Header

pytestmark = pytest.mark.slow

LaserScan = find_message("sensor_msgs/msg/LaserScan")


@pytest.fixture
def node() -> Iterator[rclpy.Node]:
    rclpy.init()
    yield rclpy.create_node("node")
    rclpy.shutdown()


def test_a_message_is_made_empty_and_its_fields_are_set_one_by_one() -> None:
    """A name that is no field is refused when it is set, as rclpy does."""
    scan = program_type(LaserScan)()
    assert (scan.angle_min, scan.header.frame_id, scan.ranges) == (0.0, "", [])
    scan.header.frame_id = "base"
    scan.ranges.append(1.5)
    assert scan == program_type(LaserScan)(header=program_type(Header)(frame_id="base"), ranges=[1.5])
    assert program_type(LaserScan)().header.frame_id == ""
    with pytest.raises(AttributeError):
        scan.rangs = []


def test_a_raw_subscription_receives_the_bytes_of_the_wire(node: rclpy.Node) -> None:
    """Source: OMG DDS-XTypes 1.3, section 7.6.3.1.2: 00 01 00 00 begins little-endian CDR."""
    heard = list[bytes]()
    node.create_subscription(String, "chatter", heard.append, 1, raw=True)
    node.create_publisher(String, "chatter", 1).publish(String(data="ab"))
    rclpy.spin_once(node)
    assert heard == [bytes.fromhex("00010000 03000000 616200")] == [rclpy.serialize_message(String(data="ab"))]


def test_the_names_that_the_guide_calls_missing_are_missing(node: rclpy.Node) -> None:
    """What is added leaves the list."""
    guide = (Path(__file__).parents[2] / "docs/robots.md").read_text("utf-8")
    named = re.findall(r"`(\w+)`", guide.partition("Missing: lifecycle nodes; ")[2].partition("\n- ")[0])
    publisher, subscription = node.create_publisher(String, "t", 1), node.create_subscription(String, "t", print, 1)
    timer = node.create_timer(1.0, print)
    places = (rclpy, node, publisher, subscription, timer, node.get_clock())
    assert len(named) > 20
    assert [name for name in named if any(hasattr(place, name) for place in places)] == []


def test_the_names_of_bases_and_infos_are_those_of_rclpy() -> None:
    assert isinstance(rclpy.SingleThreadedExecutor(), rclpy.Executor)
    assert isinstance(rclpy.ReentrantCallbackGroup(), rclpy.CallbackGroup)
    assert rclpy.QoSPublisherMatchedInfo().current_count == 0


def test_an_executor_runs_the_callbacks_of_several_nodes_on_one_thread(node: rclpy.Node) -> None:
    """Also those that were due before a node was added."""
    executor, other, heard = rclpy.SingleThreadedExecutor(), rclpy.create_node("other"), list[str]()
    publisher = node.create_publisher(String, "chatter", 10)
    node.create_subscription(String, "chatter", lambda message: heard.append(f"node: {message.data}"), 10)
    other.create_subscription(String, "chatter", lambda message: heard.append(f"other: {message.data}"), 10)
    publisher.publish(String(data="a"))
    for one in (node, other):
        executor.add_node(one)
    other.create_timer(0.1, rclpy.shutdown)
    executor.spin()
    assert sorted(heard) == ["node: a", "other: a"]


def test_a_program_waits_for_one_message(node: rclpy.Node) -> None:
    publisher = node.create_publisher(String, "chatter", 10)
    node.create_timer(0.05, lambda: publisher.publish(String(data="a")))
    is_there, message = rclpy.wait_for_message(String, node, "chatter", time_to_wait=PATIENCE)
    assert (is_there, message.data) == (True, "a")
    assert rclpy.wait_for_message(String, node, "silence", time_to_wait=0.1) == (False, None)
    assert node.count_subscribers("chatter") == node.count_subscribers("silence") == 0


def test_a_guard_condition_runs_its_callback_when_it_is_triggered(node: rclpy.Node) -> None:
    called = rclpy.Future()
    condition = node.create_guard_condition(lambda: called.set_result("called"))
    condition.trigger()
    rclpy.spin_until_future_complete(node, called, timeout_sec=PATIENCE)
    assert called.result() == "called"
    condition.destroy()


def test_the_arguments_rename_a_node_and_its_ends_and_set_its_parameters() -> None:
    words = "--ros-args -r __node:=speaker -r __ns:=/demo -r chatter:=/heard -r go:=went -p voice.rate:=2.5"
    with rclpy.init(args=words.split()):
        node = rclpy.create_node("talker")
        node.declare_parameters("voice", [("rate", 1.0), ("name", "x")])
        assert node.get_fully_qualified_name() == "/demo/speaker"
        assert node.create_publisher(String, "chatter", 10).topic_name == "/heard"
        assert node.create_client(SetBool, "go").srv_name == "/demo/went"
        found = node.get_parameters_by_prefix("voice")
        assert {name: one.value for name, one in found.items()} == {"rate": 2.5, "name": "x"}


def test_callbacks_before_and_after_a_change_add_parameters_and_hear_of_all(node: rclpy.Node) -> None:
    """Also where a client of the node's service sets them."""
    heard: list[list[tuple[str, Any]]] = []
    node.declare_parameters("", [("speed", 1.0), ("limit", 1.0)])
    limit = rclpy.Parameter("limit", value=4.0)
    node.add_pre_set_parameters_callback(lambda given: [*given, limit])
    node.add_post_set_parameters_callback(lambda given: heard.append([(one.name, one.value) for one in given]))
    (result,) = node.set_parameters([rclpy.Parameter("speed", value=2.0)])
    assert result.successful
    assert node.get_parameter("limit").value == 4.0
    assert heard == [[("speed", 2.0), ("limit", 4.0)]]


def test_events_of_quality_of_service_call_back_while_the_node_spins(node: rclpy.Node) -> None:
    heard = list[int]()
    matched = rclpy.PublisherEventCallbacks(matched=lambda event: heard.append(event.current_count))
    missed = rclpy.SubscriptionEventCallbacks(deadline=lambda _: rclpy.shutdown())
    profile = rclpy.qos.QoSProfile(depth=1, deadline=rclpy.Duration(seconds=0.1))
    publisher = node.create_publisher(String, "chatter", profile, event_callbacks=matched)
    node.create_subscription(String, "chatter", print, profile, event_callbacks=missed)
    publisher.publish(String(data="a"))
    rclpy.spin(node)
    assert heard == [1]


def test_a_node_knows_the_time_its_name_and_its_neighbours(node: rclpy.Node) -> None:
    before = node.get_clock().now()
    stamp = program_type(Header)(stamp=before.to_msg()).stamp
    assert abs(time.time() - before.nanoseconds / 1e9) < PATIENCE
    assert stamp.sec * 10**9 + stamp.nanosec == before.nanoseconds
    assert 0 <= (node.get_clock().now() - before).nanoseconds < PATIENCE * 1e9
    assert node.get_fully_qualified_name() == "/node"
    assert "node" in node.get_node_names()
    assert node.resolve_topic_name("chatter") == "/chatter"
    subscription = node.create_subscription(String, "chatter", print, 10)
    assert (node.count_publishers("chatter"), node.count_subscribers("/chatter")) == (0, 1)
    assert node.destroy_subscription(subscription)
    assert node.count_subscribers("chatter") == 0


def test_times_and_durations_are_added_subtracted_and_sent_as_messages() -> None:
    begin, span = rclpy.Time(seconds=1, nanoseconds=5), rclpy.Duration(seconds=1.5)
    assert (begin + span).seconds_nanoseconds() == (2, 500_000_005)
    assert (type(begin - span), type(begin - begin)) == (rclpy.Time, rclpy.Duration)
    assert (begin + span).to_msg() == program_type(Time)(sec=2, nanosec=500_000_005)
    assert rclpy.Time.from_msg(begin.to_msg()) == begin < begin + span
    assert span.to_msg() == program_type(Duration)(sec=1, nanosec=500_000_000)


def test_a_rate_and_a_clock_wait(node: rclpy.Node) -> None:
    begin, rate = time.monotonic(), node.create_rate(50)
    for _ in range(3):
        rate.sleep()
    assert node.get_clock().sleep_for(rclpy.Duration(seconds=0.01))
    assert time.monotonic() - begin >= 0.07


def test_a_timer_begins_anew_after_a_reset_and_ends_when_it_is_destroyed(node: rclpy.Node) -> None:
    calls: list[str] = []
    timer = node.create_timer(0.01, lambda: calls.append("now"), callback_group=object())
    timer.cancel()
    rclpy.spin_once(node, timeout_sec=0.05)
    assert calls == []
    timer.reset()
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    assert calls == ["now"]
    assert node.destroy_timer(timer)
    assert timer.is_canceled()
    assert node.create_timer(0.01, list, object(), autostart=False).is_canceled()


def test_a_blocking_call_in_a_callback_runs_the_callbacks_of_other_groups(node: rclpy.Node) -> None:
    """With several threads in rclpy, in one here."""

    def switch(request: Any, response: Any) -> Any:
        response.success = request.data
        return response

    answers: list[bool] = []
    group = rclpy.ReentrantCallbackGroup()
    node.create_service(program_type(SetBool), "switch", switch, callback_group=group)
    client = node.create_client(SetBool, "switch", callback_group=group)
    asked = program_type(SetBool).Request(data=True)
    node.create_timer(0.01, lambda: answers.append(client.call(asked).success), callback_group=group)
    executor = rclpy.MultiThreadedExecutor(num_threads=4)
    assert executor.add_node(node)
    while not answers:
        executor.spin_once(timeout_sec=PATIENCE)
    assert set(answers) == {True}
    with pytest.raises(ServiceUnavailableError):
        node.create_client(SetBool, "nobody").call(asked)
    executor.shutdown()
    executor.spin()


def test_an_accepted_goal_waits_until_it_is_executed(node: rclpy.Node) -> None:
    fibonacci: Any = program_type(find_action("example_interfaces/action/Fibonacci"))
    accepted: list[Any] = []

    def execute(goal: Any) -> Any:
        goal.succeed()
        return fibonacci.Result(sequence=[goal.request.order])

    server = rclpy.ActionServer(node, fibonacci, "fib", execute, handle_accepted_callback=accepted.append)
    client = rclpy.ActionClient(node, fibonacci, "fib", callback_group=None)
    sent = client.send_goal_async(fibonacci.Goal(order=3))
    while not (accepted and sent.done()):
        rclpy.spin_once(node, timeout_sec=0.01)
    assert accepted[0].is_active
    result = sent.result().get_result_async()
    rclpy.spin_once(node, timeout_sec=0.05)
    assert not result.done()
    accepted[0].execute()
    executor = rclpy.SingleThreadedExecutor()
    rclpy.spin_until_future_complete(node, result, executor, PATIENCE)
    assert (result.result().status, result.result().result.sequence) == (4, [3])
    server.destroy()


def test_overrides_go_before_defaults_and_a_type_alone_is_zero() -> None:
    rclpy.init(args=None)
    kinds = rclpy.Parameter.Type
    overrides = [rclpy.Parameter("speed", kinds.DOUBLE, 2.0), rclpy.Parameter("mode", kinds.STRING, "slow")]
    node = rclpy.Node("arm", parameter_overrides=overrides, automatically_declare_parameters_from_overrides=True)
    assert node.get_parameter("mode").value == "slow"
    other = rclpy.Node("leg", parameter_overrides=overrides, enable_rosout=True)
    assert [
        other.declare_parameter(*one).value for one in (("speed", 1.0), ("mode", kinds.STRING), ("n", kinds.INTEGER))
    ] == [2.0, "slow", 0]
    with pytest.raises(rclpy.ParameterNotDeclaredException):
        other.get_parameter("nothing")
    assert other.set_parameters_atomically(
        [rclpy.Parameter("n", value=3), rclpy.Parameter("speed", value=3.0)]
    ).successful
    assert [one.value for one in other.get_parameters(["n", "speed"])] == [3, 3.0]
    rclpy.shutdown()


def test_a_task_runs_on_the_thread_that_spins(node: rclpy.Node) -> None:
    executor = rclpy.SingleThreadedExecutor()
    executor.add_node(node)
    task = executor.create_task(lambda number: number + 1, 2)
    executor.spin_until_future_complete(task, PATIENCE)
    assert task.result() == 3
    own = rclpy.Future()
    executor.create_task(own.set_result, 4)
    executor.spin_until_future_complete(own, PATIENCE)
    assert own.result() == 4
    executor.remove_node(node)


def test_parameters_are_declared_together_and_asked_for_with_an_alternative(node: rclpy.Node) -> None:
    node.declare_parameters("arm", [("reach", 1.5), ("grip", "soft")])
    assert [one.value for one in node.get_parameters(["arm.reach", "arm.grip"])] == [1.5, "soft"]
    assert (node.has_parameter("arm.reach"), node.has_parameter("reach")) == (True, False)
    other = rclpy.Parameter("reach", rclpy.Parameter.Type.DOUBLE, 2.0)
    assert node.get_parameter_or("arm.reach", other).value == 1.5
    assert node.get_parameter_or("reach", other) is other
    spans = node.declare_parameter("spans", [0.5, 1.5])
    assert (spans.value, spans.type_) == ([0.5, 1.5], rclpy.Parameter.Type.DOUBLE_ARRAY)
    assert spans.get_parameter_value().double_array_value == [0.5, 1.5]


def test_a_line_of_a_program_is_logged_once_or_once_in_a_time(node: rclpy.Node) -> None:
    child = node.get_logger().get_child("part")
    child.set_level(rclpy.LoggingSeverity.WARN)
    with capture_logs() as lines:
        for number in range(3):
            node.get_logger().warn(f"once {number}", once=True)
            node.get_logger().info(f"throttled {number}", throttle_duration_sec=60.0)
            node.get_logger().fatal(f"always {number}")
            child.warn(f"again {number}", skip_first=True)
            child.info("too low")
    events = ["once 0", "throttled 0", "always 0", "always 1", "again 1", "always 2", "again 2"]
    assert [line["event"] for line in lines] == events


def test_the_policies_of_a_profile_can_be_set_and_its_durations_are_those_of_rclpy(node: rclpy.Node) -> None:
    profile = rclpy.qos.QoSProfile(depth=1, deadline=rclpy.Duration(seconds=0.5))
    profile.reliability = rclpy.qos.ReliabilityPolicy.BEST_EFFORT
    node.create_publisher(String, "chatter", profile)
    [end] = node.graph_object.graph.get_endpoints(name="/chatter")
    assert (end.qos.depth, end.qos.deadline, end.qos.reliability) == (1, 0.5, profile.reliability)
    profile.depth = 0
    with pytest.raises(QosError, match="depth must be at least 1, got 0"):
        node.create_publisher(String, "chatter", profile)


def test_a_wrong_value_is_refused_when_it_is_published(node: rclpy.Node) -> None:
    publisher = node.create_publisher(String, "chatter", 10)
    with pytest.raises(TypeMismatchError, match=r"not a std_msgs/msg/String: field 'data': .* got 5"):
        publisher.publish(program_type(String)(data=5))
    with pytest.raises(
        TypeMismatchError, match="/node published a Header on /chatter, which carries std_msgs/msg/String"
    ):
        publisher.publish(program_type(Header)())


def test_callbacks_run_on_the_thread_that_spins_and_anything_may_be_called_from_another(node: rclpy.Node) -> None:
    """As a program does whose MQTT client runs a thread of its own."""
    heard: list[tuple[str, int]] = []
    publisher = node.create_publisher(String, "chatter", 10)
    node.create_subscription(String, "chatter", lambda message: heard.append((message.data, threading.get_ident())), 10)

    def publish() -> None:
        for text in "abc":
            publisher.publish(String(data=text))

    thread = threading.Thread(target=publish)
    thread.start()
    thread.join(PATIENCE)
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    assert heard == [("a", threading.get_ident())]
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    rclpy.spin_once(node, timeout_sec=PATIENCE)
    assert [text for text, _ in heard] == ["a", "b", "c"]
    rclpy.spin_once(node, timeout_sec=0)


def test_a_failing_callback_ends_the_spin_with_its_exception_and_the_next_message_is_heard(node: rclpy.Node) -> None:
    heard: list[str] = []

    def hear(message: Any) -> None:
        heard.append(message.data)
        raise RuntimeError(message.data)

    publisher = node.create_publisher(String, "chatter", 10)
    node.create_subscription(String, "chatter", hear, 10)
    for text in "ab":
        publisher.publish(String(data=text))
        with pytest.raises(RuntimeError, match=text):
            rclpy.spin(node)
    assert heard == ["a", "b"]


def test_a_coroutine_callback_awaits_a_call_of_its_own_node(node: rclpy.Node) -> None:
    """The classical deadlock of rclpy: the answer arrives in the same thread, meanwhile."""

    def switch(request: Any, response: Any) -> Any:
        response.success = request.data
        return response

    answers: list[bool] = []
    node.create_service(program_type(SetBool), "switch", switch)
    client = node.create_client(SetBool, "switch")

    async def on_time() -> None:
        timer.cancel()
        response = await client.call_async(program_type(SetBool).Request(data=True))
        answers.append(response.success)

    timer = node.create_timer(0.01, on_time)
    deadline = time.monotonic() + PATIENCE
    while not answers and time.monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.1)
    assert answers == [True]
    assert timer.is_canceled()


def test_a_call_without_a_server_fails_at_once(node: rclpy.Node) -> None:
    client = node.create_client(SetBool, "switch")
    assert not client.wait_for_service(timeout_sec=0.01)
    future = client.call_async(program_type(SetBool).Request())
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
    assert future.done()
    with pytest.raises(ServiceUnavailableError):
        future.result()


def test_a_failing_callback_of_a_future_ends_the_spin_and_a_block_of_init_the_graph() -> None:
    def fail(future: rclpy.Future) -> None:
        raise RuntimeError(str(future.exception()))

    with rclpy.init():
        node = rclpy.create_node("node")
        node.create_client(SetBool, "switch").call_async(program_type(SetBool).Request()).add_done_callback(fail)
        with pytest.raises(RuntimeError, match="/switch"):
            rclpy.spin(node)
    assert not rclpy.ok()


def test_a_tool_sets_a_parameter_by_its_service_and_the_check_of_the_node_decides(node: rclpy.Node) -> None:
    result_class = program_type(find_message("rcl_interfaces/msg/SetParametersResult"))
    node.declare_parameter("speed", 0.5)
    node.add_on_set_parameters_callback(lambda given: result_class(successful=given[0].value != 3, reason="too fast"))
    service = program_type(find_service("rcl_interfaces/srv/SetParameters"))
    tool = rclpy.create_node("tool")
    client = tool.create_client(service, "/node/set_parameters")
    for speed, successful in ((1.0, True), (3.0, False)):
        request = service.Request()
        request.parameters = [Parameter(name="speed", value=ParameterValue(type=3, double_value=speed))]
        future: Any = client.call_async(request)
        rclpy.spin_until_future_complete(tool, future, timeout_sec=PATIENCE)
        (result,) = future.result().results
        assert result.successful is successful
    assert node.get_parameter("speed").value == 1.0


def test_a_name_is_taken_until_its_node_is_destroyed(node: rclpy.Node) -> None:
    with pytest.raises(DuplicateNameError):
        rclpy.create_node("node")
    node.destroy_node()
    node.destroy_node()
    rclpy.create_node("node")


def test_a_shutdown_ends_a_spin_in_another_thread(node: rclpy.Node) -> None:
    thread = threading.Thread(target=rclpy.spin, args=(node,))
    thread.start()
    rclpy.shutdown()
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert not rclpy.ok()


def test_without_init_there_is_no_node() -> None:
    with pytest.raises(UsageError, match=r"call rclpy.init\(\) first"):
        rclpy.create_node("node")
