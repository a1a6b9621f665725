"""roslibpy, an independent client, through the door."""

import json
import subprocess
import sys
import textwrap
from typing import Any

import anyio
import pytest
from tests.bridges.fibonacci import server
from tests.patience import PATIENCE

from homebot.bridges.rosapi import RosApi
from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.messages import SetBool, String
from homebot.messages.geometry_msgs import Twist
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse

pytestmark = pytest.mark.system

# Its Twisted reactor cannot be started twice in one process, so each transport gets a process of its own.
CLIENT = textwrap.dedent(
    """
    import json, queue, sys, roslibpy

    port, transport = int(sys.argv[1]), sys.argv[2]
    ros = roslibpy.Ros("127.0.0.1", port, transport=transport)
    ros.run(timeout=40)
    report = {"topics": ros.get_topics(), "time": ros.get_time()["secs"], "type": ros.get_topic_type("/state")}
    report["nodes"], report["params"] = ros.get_nodes(), ros.get_params()
    report["rate"] = ros.get_param("/lamp:rate")
    ros.set_param("/lamp:rate", 9)
    report["details"] = ros.get_message_details("std_msgs/String")["typedefs"][0]["fieldnames"]

    heard = queue.Queue()
    roslibpy.Topic(ros, "/state", "std_msgs/String").subscribe(heard.put)
    report["latched"] = heard.get(timeout=40)["data"]
    images = queue.Queue()
    roslibpy.Topic(ros, "/latched", "std_msgs/String", compression="png").subscribe(images.put)
    report["png"] = images.get(timeout=40)["data"]
    roslibpy.Topic(ros, "/echoed", "std_msgs/String").subscribe(heard.put)
    roslibpy.Topic(ros, "/hello", "std_msgs/String").publish(roslibpy.Message({"data": "hi"}))
    report["echoed"] = heard.get(timeout=40)["data"]

    switch = roslibpy.Service(ros, "/switch", "std_srvs/SetBool")
    report["called"] = switch.call(roslibpy.ServiceRequest({"data": True}), timeout=40)["message"]
    try:
        roslibpy.Service(ros, "/nobody", "std_srvs/SetBool").call(roslibpy.ServiceRequest({}), timeout=40)
    except roslibpy.core.ServiceException as exc:
        report["absent"] = str(exc)

    def serve(request, response):
        response["success"], response["message"] = request["data"], "served by roslibpy"
        return True

    mine = roslibpy.Service(ros, "/mine", "std_srvs/SetBool")
    mine.advertise(serve)
    go = roslibpy.Topic(ros, "/go", "std_msgs/String")
    go.publish(roslibpy.Message({"data": "serving"}))
    report["served"] = heard.get(timeout=40)["data"]
    mine.unadvertise()

    roslibpy.Topic(ros, "/driven", "geometry_msgs/Twist").subscribe(heard.put)
    still = {"x": 0, "y": 0, "z": 0}
    drive = roslibpy.Message({"linear": dict(still, x=0.5), "angular": still})
    roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/Twist").publish(drive)
    report["driven"] = heard.get(timeout=40)["linear"]["x"]

    def add(request, response):
        response["sum"] = request["a"] + request["b"]
        return True

    numbers = ("/add_two_ints", "example_interfaces/AddTwoInts")
    roslibpy.Service(ros, *numbers).advertise(add)
    report["sum"] = roslibpy.Service(ros, *numbers).call(roslibpy.ServiceRequest({"a": 1, "b": 2}), timeout=40)["sum"]
    print(json.dumps(report))
    ros.terminate()
    """
)


@pytest.mark.parametrize("transport", ["twisted", "asyncio"])
async def test_roslibpy_subscribes_publishes_calls_and_serves(transport: str) -> None:
    graph = Graph()
    RosApi(Node(graph, "rosapi"))
    settings = RosbridgeSettings(port=0, scope=("read", "act: harmless", "manage"))  # it sets a parameter
    door = RosbridgeServer(Node(graph, "rosbridge_websocket"), settings)
    heard: list[str] = []
    async with Node(graph, "lamp") as lamp, anyio.create_task_group() as tasks:
        _furnish(lamp, heard)
        await tasks.start(door.run)
        command = [sys.executable, "-c", CLIENT, str(door.port), transport]
        with anyio.fail_after(PATIENCE):
            done = await anyio.run_process(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        tasks.cancel_scope.cancel()
    assert done.returncode == 0, done.stderr.decode()
    report: dict[str, Any] = json.loads(done.stdout)
    assert {"/cmd_vel", "/state", "/hello", "/echoed", "/go"} <= set(report.pop("topics"))
    assert report.pop("time") > 1_700_000_000
    assert "has no server" in report.pop("absent")
    assert report == {
        "type": "std_msgs/msg/String",
        "nodes": ["/lamp", "/rosapi", "/rosbridge_websocket"],
        "params": ["/lamp:rate"],
        "rate": 2.0,
        "details": ["data"],
        "latched": "on",
        "png": "on",
        "echoed": "you said hi",
        "called": "done",
        "served": "served by roslibpy",
        "driven": 0.5,
        "sum": 3,
    }
    assert heard == ["hi"]
    assert lamp.get_parameter("rate").value == 9.0
    assert b"rror" not in done.stderr, done.stderr.decode()


ACTIONS = textwrap.dedent(
    """
    import json, queue, sys, roslibpy

    ros = roslibpy.Ros("127.0.0.1", int(sys.argv[1]))
    ros.run(timeout=40)
    fib = roslibpy.ActionClient(ros, "/fib", "example_interfaces/action/Fibonacci")
    report = []
    for order in (3, 50, 7, -1):
        told, ends = [], queue.Queue()
        goal = fib.send_goal(
            roslibpy.Goal({"order": order}),
            lambda result: ends.put(["result", result]),
            lambda feedback: told.append(feedback["sequence"]),
            lambda error: ends.put(["error", str(error)]),
        )
        if order == 50:
            fib.cancel_goal(goal)
        kind, end = ends.get(timeout=40)
        report.append([kind, [end["status"].value, end["values"]] if kind == "result" else end, told])
    roslibpy.Topic(ros, "/no/such", "no_msgs/Type").publish(roslibpy.Message({}))
    ros.get_time()
    print(json.dumps(report))
    ros.terminate()
    """
)


async def test_roslibpy_sends_goals_and_cancels_them() -> None:
    """A refused publication does not reach it as a frame that it cannot read."""
    graph = Graph()
    RosApi(Node(graph, "rosapi"))
    async with Node(graph, "rosbridge_websocket") as node, server(graph), anyio.create_task_group() as tasks:
        door = RosbridgeServer(node, RosbridgeSettings(port=0))
        await tasks.start(door.run)
        with anyio.fail_after(PATIENCE):
            done = await anyio.run_process(
                [sys.executable, "-c", ACTIONS, str(door.port)], check=False, stderr=subprocess.PIPE
            )
        tasks.cancel_scope.cancel()
    assert done.returncode == 0, done.stderr.decode()
    counted, cancelled, failed, refused = json.loads(done.stdout)
    assert counted == ["result", [4, {"sequence": [0, 1, 1]}], [[0], [0, 1], [0, 1, 2]]]
    assert (cancelled[0], cancelled[1][0]) == ("result", 5)
    assert (failed[0], failed[1]) == ("result", [6, {"sequence": [7]}])
    assert (refused[0], "rejected" in refused[1]) == ("error", True)
    assert b"rror" not in done.stderr, done.stderr.decode()


def _furnish(lamp: Node, heard: list[str]) -> None:
    lamp.declare_parameter("rate", 2.0)
    lamp.create_publisher(String, "/state", qos_profile_latched).publish(String(data="on"))
    lamp.create_publisher(String, "/latched", qos_profile_latched).publish(String(data="on"))
    echoed = lamp.create_publisher(String, "/echoed")
    mine = lamp.create_client(SetBool, "/mine")

    def on_hello(message: String) -> None:
        heard.append(message.data)
        echoed.publish(String(data=f"you said {message.data}"))

    async def on_go(_message: String) -> None:
        await mine.wait_for_service(10)
        echoed.publish(String(data=(await mine.call(SetBoolRequest(data=True))).message))

    def switch(request: SetBoolRequest) -> SetBoolResponse:
        return SetBoolResponse(success=request.data, message="done")

    driven = lamp.create_publisher(Twist, "/driven")
    lamp.create_subscription(Twist, "/cmd_vel", driven.publish)
    lamp.create_subscription(String, "/hello", on_hello)
    lamp.create_subscription(String, "/go", on_go)
    lamp.create_service(SetBool, "/switch", switch)
