"""What /rosapi answers, as clients on the graph and through the door see it."""

import json
from typing import Any

import anyio
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs

from homebot.bridges.rosapi import RosApi
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.errors import ServiceFailedError
from homebot.graph import Graph, Node, ParameterDescriptor
from homebot.graph.actions import ActionClient, ActionServer
from homebot.messages import Int32, String, Trigger
from homebot.messages.action import ActionType
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

COOK = ActionType("test_msgs/action/Cook", String, Int32, String)


class Asker:
    """Calls services of a graph by their names, as the door does."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.node = Node(graph, "asker")

    async def __call__(self, question: str, /, **fields: Any) -> dict[str, Any]:
        service_type = self.graph.get_service_type(f"/rosapi/{question}")
        assert service_type is not None
        client = self.node.create_client(service_type, f"/rosapi/{question}")
        try:
            return message_to_json(await client.call(message_from_json(service_type.Request, fields)))
        finally:
            client.close()


@pytest.fixture
async def ask() -> Asker:
    graph = Graph()
    RosApi(Node(graph, "rosapi"))
    talker = Node(graph, "talker", parameters={"rate": 3.0})
    talker.create_publisher(String, "/chatter")
    talker.create_publisher(Int32, "/_hidden")
    talker.declare_parameter("rate", 1.0, ParameterDescriptor(minimum=0))
    talker.declare_parameter("names", ["a", "b"])
    talker.declare_parameter("key", b"\x01\x02")
    listener = Node(graph, "listener")
    listener.create_subscription(String, "/chatter")

    def reset(_request: TriggerRequest) -> SuccessResponse:
        return SuccessResponse(success=True, message="")

    listener.create_service(Trigger, "/reset", reset)
    Node(graph, "_secret")
    return Asker(graph)


@pytest.mark.parametrize(
    ("question", "fields", "answer"),
    [
        ("topics_for_type", {"type": "std_msgs/String"}, {"topics": ["/chatter"]}),
        ("topics_for_type", {"type": "std_msgs/msg/String"}, {"topics": ["/chatter"]}),
        ("topics_for_type", {"type": "std_msgs/Bool"}, {"topics": []}),
        ("topic_type", {"topic": "chatter"}, {"type": "std_msgs/msg/String"}),
        ("topic_type", {"topic": "/nothing"}, {"type": ""}),
        ("service_type", {"service": "/reset"}, {"type": "std_srvs/srv/Trigger"}),
        ("service_type", {"service": "/nothing"}, {"type": ""}),
        ("services_for_type", {"type": "std_srvs/Trigger"}, {"services": ["/reset"]}),
        ("service_node", {"service": "/reset"}, {"node": "/listener"}),
        ("service_node", {"service": "/nothing"}, {"node": ""}),
        ("service_providers", {"service": "std_srvs/srv/Trigger"}, {"providers": ["/listener"]}),
        ("publishers", {"topic": "/chatter"}, {"publishers": ["/talker"]}),
        ("subscribers", {"topic": "/chatter"}, {"subscribers": ["/listener"]}),
        ("nodes", {}, {"nodes": ["/asker", "/listener", "/rosapi", "/talker"]}),
        ("node_details", {"node": "/nobody"}, {"subscribing": [], "publishing": [], "services": []}),
        ("has_param", {"name": "/talker:rate"}, {"exists": True}),
        ("has_param", {"name": "/talker:nothing"}, {"exists": False}),
        ("has_param", {"name": "nonsense"}, {"exists": False}),
    ],
)
async def test_a_question_is_answered_without_hidden_names(
    ask: Asker, question: str, fields: dict[str, str], answer: dict[str, object]
) -> None:
    assert await ask(question, **fields) == answer


async def test_topics_services_and_nodes_are_listed_with_what_belongs_to_them(ask: Asker) -> None:
    types = ["std_msgs/msg/String", "rcl_interfaces/msg/ParameterEvent"]
    assert await ask("topics") == {"topics": ["/chatter", "/parameter_events"], "types": types}
    assert "/reset" in (await ask("services"))["services"]
    publishing = ["/parameter_events"]
    assert await ask("node_details", node="/listener") == {
        "subscribing": ["/chatter"],
        "publishing": publishing,
        "services": ["/reset"],
    }


async def test_raw_types_are_the_texts_of_the_types(ask: Asker) -> None:
    answer = await ask("topics_and_raw_types")
    assert answer["typedefs_full_text"][0] == "string data\n"
    assert "MSG: rcl_interfaces/ParameterValue" in answer["typedefs_full_text"][1]


async def test_interfaces_are_all_that_have_a_definition(ask: Asker) -> None:
    found = (await ask("interfaces"))["interfaces"]
    assert {"std_msgs/msg/String", "nav_msgs/srv/GetMap", "nav2_msgs/action/Spin", "homebot/msg/Device"} <= set(found)


async def test_message_details_describe_nested_types_too(ask: Asker) -> None:
    typedefs = (await ask("message_details", type="homebot/Device"))["typedefs"]
    assert [one["type"] for one in typedefs] == [
        "homebot/Device",
        "homebot/Endpoint",
        "builtin_interfaces/Time",
        "diagnostic_msgs/KeyValue",
        "homebot/DevicePart",
        "homebot/Part",
        "homebot/Capability",
        "homebot/SceneValue",
        "homebot/Value",
        "homebot/Route",
        "homebot/Fact",
        "homebot/Reachability",
        "homebot/State",
    ]
    device = typedefs[0]
    assert device["fieldnames"] == list(Device.model_fields)
    assert device["fieldtypes"][3] == "homebot/Endpoint"
    assert device["fieldarraylen"][:4] == [-1, -1, -1, 0]
    assert len(device["examples"]) == len(device["fieldnames"])
    assert (device["constnames"], device["constvalues"]) == ([], [])


async def test_the_constants_of_a_type_come_with_it(ask: Asker) -> None:
    typedef = (await ask("message_details", type="diagnostic_msgs/DiagnosticStatus"))["typedefs"][0]
    assert typedef["constnames"] == ["OK", "WARN", "ERROR", "STALE"]
    assert typedef["constvalues"] == ["0", "1", "2", "3"]
    known = (await ask("message_details", type="action_msgs/GoalStatus"))["typedefs"][0]
    assert dict(zip(known["constnames"], known["constvalues"], strict=True))["STATUS_ABORTED"] == "6"


async def test_bytes_are_an_array_of_uint8(ask: Asker) -> None:
    typedef = (await ask("message_details", type="homebot/msg/RawMessage"))["typedefs"][0]
    payload = typedef["fieldnames"].index("payload")
    assert (typedef["fieldtypes"][payload], typedef["fieldarraylen"][payload]) == ("uint8", 0)


async def test_a_standard_type_is_described_with_all_that_is_in_it(ask: Asker) -> None:
    typedefs = (await ask("message_details", type="geometry_msgs/TwistStamped"))["typedefs"]
    assert [(one["type"], one["fieldnames"], one["fieldtypes"]) for one in typedefs] == [
        ("geometry_msgs/TwistStamped", ["header", "twist"], ["std_msgs/Header", "geometry_msgs/Twist"]),
        ("std_msgs/Header", ["stamp", "frame_id"], ["builtin_interfaces/Time", "string"]),
        ("builtin_interfaces/Time", ["sec", "nanosec"], ["int32", "uint32"]),
        ("geometry_msgs/Twist", ["linear", "angular"], ["geometry_msgs/Vector3"] * 2),
        ("geometry_msgs/Vector3", ["x", "y", "z"], ["float64"] * 3),
    ]


async def test_service_details_describe_request_and_response(ask: Asker) -> None:
    def find(_request: FindDevicesRequest) -> FindDevicesResponse:
        return FindDevicesResponse(devices=(), sequence=0)

    ask.node.create_service(FindDevices, FIND_DEVICES, find)
    request = (await ask("service_request_details", type="homebot/FindDevices"))["typedefs"]
    assert request[0]["fieldnames"] == ["service_type", "query", "ids", "is_checked"]
    response = (await ask("service_response_details", type="homebot/srv/FindDevices"))["typedefs"]
    assert "homebot/Device" in [one["type"] for one in response]


async def test_an_unknown_type_is_an_error_that_names_similar_ones(ask: Asker) -> None:
    problem = "unknown message type 'std_msgs/Strin'; similar: std_msgs/msg/String"
    with pytest.raises(ServiceFailedError, match=problem):
        await ask("message_details", type="std_msgs/Strin")


async def test_time_is_spelled_both_ways(ask: Asker) -> None:
    time = (await ask("get_time"))["time"]
    assert time["sec"] == time["secs"] > 1_700_000_000
    assert time["nanosec"] == time["nsecs"]


async def test_actions_come_with_their_types(ask: Asker) -> None:
    assert await ask("get_ros_version") == {"version": 2, "distro": "jazzy"}
    assert await ask("action_servers") == {"action_servers": []}
    async with Node(ask.graph, "cook") as cook:
        ActionServer(cook, COOK, "/cook", lambda _: anyio.lowlevel.checkpoint())
        ActionClient(cook, COOK, "/absent")
        assert await ask("action_servers") == {"action_servers": ["/cook"]}
        assert await ask("action_type", action="cook") == {"type": "test_msgs/action/Cook"}
        for part, message in (("goal", String), ("result", Int32), ("feedback", String)):
            details = await ask(f"action_{part}_details", type="test_msgs/Cook")
            assert details == await ask("message_details", type=message.ros_type)


async def test_the_services_for_the_parameters_of_a_node_are_listed_before_they_are_used(ask: Asker) -> None:
    """A node without parameters has none."""
    listed = (await ask("node_details", node="/talker"))["services"]
    names = ("describe_parameters", "get_parameter_types", "get_parameters", "list_parameters", "set_parameters")
    assert listed == [f"/talker/{name}" for name in (*names, "set_parameters_atomically")]
    ros_type = "rcl_interfaces/srv/GetParameters"
    assert await ask("service_type", service="/talker/get_parameters") == {"type": ros_type}
    assert await ask("services_for_type", type=ros_type) == {"services": ["/talker/get_parameters"]}


async def test_parameters_are_read_as_json(ask: Asker) -> None:
    assert (await ask("get_param_names"))["names"] == ["/talker:key", "/talker:names", "/talker:rate"]
    values = {name: (await ask("get_param", name=f"/talker:{name}"))["value"] for name in ("rate", "names", "key")}
    assert {name: json.loads(value) for name, value in values.items()} == {
        "rate": 3.0,
        "names": ["a", "b"],
        "key": [1, 2],
    }


async def test_parameters_are_set_from_json(ask: Asker) -> None:
    assert await ask("set_param", name="/talker:rate", value="7") == {"successful": True, "reason": ""}
    assert await ask("set_param", name="/talker:key", value="[3]") == {"successful": True, "reason": ""}
    talker = ask.graph.get_node("/talker")
    assert talker is not None
    assert talker.get_parameter("rate").value == 7.0
    assert talker.get_parameter("key").value == b"\x03"


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("/talker:rate", "-1", "must be from 0"),
        ("/talker:rate", '"fast"', "double"),
        ("/talker:rate", "{", "Expecting property name"),
        ("/talker:rate", "null", "cannot be a parameter's value"),
        ("/talker:key", "[300]", "range"),
        ("/talker:nothing", "1", "no parameter 'nothing' is declared"),
        ("/nobody:rate", "1", "there is no node '/nobody'"),
        ("rate", "1", "a parameter is named /node:parameter, got 'rate'"),
    ],
)
async def test_a_parameter_that_cannot_be_set_says_why(ask: Asker, name: str, value: str, problem: str) -> None:
    """Also in the log, as neither roslibpy nor roslib passes the answer on."""
    with capture_logs() as lines:
        answer = await ask("set_param", name=name, value=value)
    assert not answer["successful"]
    assert problem in answer["reason"]
    assert [line["message"] for line in lines] == [f"set_param was refused: {answer['reason']}"]


async def test_an_absent_parameter_is_null_or_the_default(ask: Asker) -> None:
    answer = await ask("get_param", name="/talker:nothing")
    assert (answer["value"], answer["successful"]) == ("null", False)
    assert (await ask("get_param", name="/talker:nothing", default_value="5"))["value"] == "5"


async def test_a_parameter_cannot_be_deleted(ask: Asker) -> None:
    answer = await ask("delete_param", name="/talker:rate")
    assert not answer["successful"]
    assert "ends with the node" in answer["reason"]
    assert "there is no node" in (await ask("delete_param", name="/nobody:x"))["reason"]


async def test_endpoints_tell_everything_hidden_ones_too(ask: Asker) -> None:
    found = (await ask("endpoints", name="/chatter"))["endpoints"]
    assert [(one["kind"], one["node"]) for one in found] == [("publisher", "/talker"), ("subscription", "/listener")]
    assert (found[0]["reliability"], found[0]["durability"], found[0]["depth"]) == ("reliable", "volatile", 10)
    assert [one["name"] for one in (await ask("endpoints", kind="node"))["endpoints"]] == [
        "/_secret",
        "/asker",
        "/listener",
        "/rosapi",
        "/talker",
    ]
    with pytest.raises(ServiceFailedError, match=r"field 'kind' is one of .*client, node, .*got 'nodes'"):
        await ask("endpoints", kind="nodes")
