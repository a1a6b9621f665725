"""Parameters: declared, typed, checked, announced."""

import math

import pytest

from homebot.errors import ParameterError
from homebot.graph import Graph, Node, Parameter, ParameterDescriptor, ParameterSet
from homebot.graph.parameters import Value
from homebot.messages import ParameterEvent, ParameterValue, Time


@pytest.fixture
def events() -> list[tuple[object, ...]]:
    return []


@pytest.fixture
def parameters(events: list[tuple[object, ...]]) -> ParameterSet:
    return ParameterSet("/node", {"given": 7, "wrong": "x"}, lambda kind, given: events.append((kind, *given)))


def test_a_declared_parameter_has_its_default(parameters: ParameterSet) -> None:
    assert parameters.declare("rate", 2.5) == Parameter("rate", 2.5)
    assert parameters.get("rate").value == 2.5
    assert parameters.has("rate")
    assert parameters.names() == ("rate",)


def test_a_start_up_value_replaces_the_default(parameters: ParameterSet) -> None:
    assert parameters.declare("given", 1).value == 7


def test_a_start_up_value_of_another_type_is_refused(parameters: ParameterSet) -> None:
    with pytest.raises(ParameterError, match="/node: parameter 'wrong' is of type integer, got the string 'x'"):
        parameters.declare("wrong", 1)
    assert not parameters.has("wrong")


@pytest.mark.parametrize("use", [lambda set_: set_.get("rat"), lambda set_: set_.set("rat", 1)])
def test_an_undeclared_parameter_is_refused_with_those_that_are(parameters: ParameterSet, use: object) -> None:
    assert callable(use)
    with pytest.raises(ParameterError, match=r"/node: no parameter 'rat' is declared; declared: none"):
        use(parameters)
    parameters.declare("rate", 1)
    with pytest.raises(ParameterError, match=r"did you mean rate\?"):
        use(parameters)


def test_a_parameter_is_declared_once(parameters: ParameterSet) -> None:
    parameters.declare("rate", 1)
    with pytest.raises(ParameterError, match="/node: parameter 'rate' is declared already"):
        parameters.declare("rate", 1)


def test_a_parameter_needs_a_name(parameters: ParameterSet) -> None:
    with pytest.raises(ParameterError, match="/node: parameter '' is nameless"):
        parameters.declare("", 1)


@pytest.mark.parametrize(
    ("default", "value", "kept"),
    [
        (1.0, 2, 2.0),
        ([1.0], [2, 3.5], (2.0, 3.5)),
        ([1], [], ()),
        ([1], [2], (2,)),
        (["a"], ("b",), ("b",)),
        ([], ["b"], ("b",)),
        (True, False, False),
        (b"a", b"b", b"b"),
        (1.0, math.inf, math.inf),
    ],
)
def test_a_fitting_value_is_taken(parameters: ParameterSet, default: Value, value: Value, kept: Value) -> None:
    parameters.declare("p", default)
    assert parameters.set("p", value).value == kept
    assert parameters.get("p").value == kept
    assert type(parameters.get("p").value) is type(kept)


@pytest.mark.parametrize(
    ("default", "value", "problem"),
    [
        (1, 2.0, "is of type integer, got the double 2.0"),
        (1, True, "is of type integer, got the bool True"),
        (1.0, True, "is of type double, got the bool True"),
        ("a", 1, "is of type string, got the integer 1"),
        ([1.0], [True], "got the bool"),
        ([1], ["a"], "got the string"),
        ([1], [1, "a"], "cannot be a parameter's value"),
        ([1], [b"x"], "cannot be a parameter's value"),
        ("a", None, "None cannot be a parameter's value"),
        (1, 2**63, "cannot be a parameter's value"),
        ("a", [], "is of type string, got the string"),
    ],
)
def test_a_value_of_another_type_is_refused(
    parameters: ParameterSet, default: Value, value: Value, problem: str
) -> None:
    parameters.declare("p", default)
    with pytest.raises(ParameterError) as caught:
        parameters.set("p", value)
    assert problem in str(caught.value)
    assert parameters.get("p").value == (tuple(default) if isinstance(default, list) else default)


@pytest.mark.parametrize(
    ("descriptor", "value", "problem"),
    [
        (ParameterDescriptor(minimum=1, maximum=5), 6.0, "must be from 1 to 5, got 6.0"),
        (ParameterDescriptor(minimum=1), 0.5, "must be from 1 to inf, got 0.5"),
        (ParameterDescriptor(maximum=5), 5.1, "must be from -inf to 5, got 5.1"),
        (ParameterDescriptor(maximum=5), math.nan, "must be from -inf to 5, got nan"),
    ],
)
def test_a_value_out_of_range_is_refused(
    parameters: ParameterSet, descriptor: ParameterDescriptor, value: float, problem: str
) -> None:
    parameters.declare("p", 2.0, descriptor)
    with pytest.raises(ParameterError, match=f"/node: parameter 'p' {problem}"):
        parameters.set("p", value)
    with pytest.raises(ParameterError, match=problem):
        parameters.declare("q", value, descriptor)


def test_the_ends_of_a_range_belong_to_it(parameters: ParameterSet) -> None:
    parameters.declare("p", 2, ParameterDescriptor(minimum=1, maximum=5))
    assert [parameters.set("p", value).value for value in (1, 5)] == [1, 5]


def test_a_read_only_parameter_keeps_its_start_up_value(parameters: ParameterSet) -> None:
    parameters.declare("given", 1, ParameterDescriptor(read_only=True))
    with pytest.raises(ParameterError, match="/node: parameter 'given' is read-only"):
        parameters.set("given", 1)
    assert parameters.get("given").value == 7


def test_the_newest_check_is_asked_first_and_the_first_no_counts(parameters: ParameterSet) -> None:
    asked: list[str] = []

    def check(name: str, reason: str | None) -> None:
        def ask(parameter: Parameter) -> str | None:
            asked.append(f"{name} {parameter.value!r}")
            return reason

        parameters.add_on_set_callback(ask)

    parameters.declare("p", 1)
    check("old", None)
    check("strict", "too odd")
    check("new", None)
    with pytest.raises(ParameterError, match="/node: parameter 'p' was refused: too odd"):
        parameters.set("p", 3)
    assert asked == ["new 3", "strict 3"]
    assert parameters.get("p").value == 1
    with pytest.raises(ParameterError, match="too odd"):
        parameters.declare("q", 1)


def test_only_changes_are_announced_and_those_made_together_at_once(
    parameters: ParameterSet, events: list[tuple[object, ...]]
) -> None:
    parameters.declare("p", 1)
    parameters.set("p", 1)
    parameters.set("p", 2)
    assert events == [("new", Parameter("p", 1)), ("changed", Parameter("p", 2))]
    parameters.declare("q", 1)
    parameters.set_atomically({"p": 3, "q": 4})
    assert events[-1] == ("changed", Parameter("p", 3), Parameter("q", 4))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (True, ParameterValue(type=1, bool_value=True)),
        (1, ParameterValue(type=2, integer_value=1)),
        (1.5, ParameterValue(type=3, double_value=1.5)),
        ("a", ParameterValue(type=4, string_value="a")),
        (b"a", ParameterValue(type=5, byte_array_value=b"a")),
        ([True], ParameterValue(type=6, bool_array_value=(True,))),
        ((1, 2), ParameterValue(type=7, integer_array_value=(1, 2))),
        ([1.5], ParameterValue(type=8, double_array_value=(1.5,))),
        (["a"], ParameterValue(type=9, string_array_value=("a",))),
    ],
)
def test_a_parameter_is_a_ros_message_too(value: Value, message: ParameterValue) -> None:
    assert Parameter("p", value).to_message().value == message


async def test_a_node_announces_its_parameters_to_all(graph: Graph) -> None:
    with_events = Node(graph, "listener")
    events = with_events.create_subscription(ParameterEvent, "/parameter_events")
    node = Node(graph, "lamp", namespace="/kitchen", parameters={"level": 3})
    assert node.declare_parameter("level", 1).value == 3
    node.parameters.set("level", 4)
    assert node.get_parameter("level").value == 4
    new, changed = await events.receive(), await events.receive()
    assert (new.node, new.new_parameters[0].value.integer_value, new.changed_parameters) == ("/kitchen/lamp", 3, ())
    assert (changed.changed_parameters[0].value.integer_value, changed.new_parameters) == (4, ())
    assert new.stamp.sec >= Time.from_seconds(1_700_000_000).sec
