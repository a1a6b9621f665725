"""ROS's services for the parameters of a node."""

from typing import Any

import pytest

from homebot.graph import Graph, Node, ParameterDescriptor
from homebot.messages.interfaces import find_service
from homebot.messages.rcl_interfaces import Parameter, ParameterValue


class Tool:
    """A tool of ROS, which calls the services of ``/robot``."""

    def __init__(self, graph: Graph) -> None:
        self.node = Node(graph, "robot")
        self.node.declare_parameter("speed", 0.5, ParameterDescriptor("Metres per second.", minimum=0.0, maximum=2.0))
        self.node.declare_parameter("steps", 3, ParameterDescriptor(minimum=0, maximum=9, read_only=True))
        self.node.declare_parameter("arm.reach", 0.8)
        self.node.declare_parameter("arm.hand.grip", ())
        self._tool = Node(graph, "tool")

    async def call(self, name: str, ros_name: str, **request: Any) -> Any:
        service = find_service(f"rcl_interfaces/srv/{ros_name}")
        return await self._tool.create_client(service, f"/robot/{name}").call(service.Request(**request))


@pytest.fixture
async def tool() -> Tool:
    return Tool(Graph())


def double(name: str, value: float) -> Parameter:
    return Parameter(name=name, value=ParameterValue(type=3, double_value=value))


@pytest.mark.parametrize(
    ("prefixes", "depth", "names"),
    [
        ((), 0, ("arm.hand.grip", "arm.reach", "speed", "steps")),
        ((), 1, ("speed", "steps")),
        (("arm",), 0, ("arm.hand.grip", "arm.reach")),
        (("arm",), 1, ("arm.reach",)),
        (("arm.hand", "speed"), 0, ("arm.hand.grip", "speed")),
        (("ar",), 0, ()),
    ],
)
async def test_names_are_listed_by_prefix_and_depth(
    tool: Tool, prefixes: tuple[str, ...], depth: int, names: tuple[str, ...]
) -> None:
    response = await tool.call("list_parameters", "ListParameters", prefixes=prefixes, depth=depth)
    assert response.result.names == names


async def test_values_and_types_are_those_of_the_parameters_and_none_with_an_unknown_name(tool: Tool) -> None:
    """An empty list has the type that it was declared with."""
    names = ("speed", "arm.hand.grip")
    response = await tool.call("get_parameters", "GetParameters", names=names)
    assert [(one.type, one.double_value) for one in response.values] == [(3, 0.5), (9, 0.0)]
    assert bytes((await tool.call("get_parameter_types", "GetParameterTypes", names=names)).types) == bytes((3, 9))
    assert (await tool.call("get_parameters", "GetParameters", names=("speed", "sped"))).values == ()
    assert (await tool.call("describe_parameters", "DescribeParameters", names=("sped",))).descriptors == ()


async def test_a_parameter_is_described_with_its_range(tool: Tool) -> None:
    names = ("speed", "steps")
    speed, steps = (await tool.call("describe_parameters", "DescribeParameters", names=names)).descriptors
    assert (speed.name, speed.type, speed.description, speed.read_only) == ("speed", 3, "Metres per second.", False)
    assert [(one.from_value, one.to_value) for one in speed.floating_point_range] == [(0.0, 2.0)]
    assert [(one.from_value, one.to_value) for one in steps.integer_range] == [(0, 9)]
    assert steps.read_only


async def test_parameters_are_set_one_by_one_or_all_or_none(tool: Tool) -> None:
    """The second one is out of its range."""
    wanted = (double("arm.reach", 1.0), double("speed", 3.0))
    response = await tool.call("set_parameters_atomically", "SetParametersAtomically", parameters=wanted)
    assert not response.result.successful
    assert "must be from 0 to 2, got 3.0" in response.result.reason
    assert tool.node.get_parameter("arm.reach").value == 0.8
    response = await tool.call("set_parameters", "SetParameters", parameters=wanted)
    assert [one.successful for one in response.results] == [True, False]
    assert tool.node.get_parameter("arm.reach").value == 1.0


async def test_a_value_that_is_not_set_is_refused(tool: Tool) -> None:
    wanted = (Parameter(name="speed", value=ParameterValue(type=0)),)
    (result,) = (await tool.call("set_parameters", "SetParameters", parameters=wanted)).results
    assert result.reason == "a value has a type from 1 to 9, got 0; a parameter cannot be unset"
