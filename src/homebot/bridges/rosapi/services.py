"""The services of ``/rosapi`` as rows: type, fields of request and response as in ``rosapi_msgs``, and the answer.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from importlib import import_module
from typing import Any, Final, TypeAlias

from pydantic import create_model

from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.rosbridge.types import (
    define_type,
    find_action_type,
    find_message_type,
    find_service_type,
    interfaces_of,
    same_type,
)
from homebot.devices.access_messages import DefineType
from homebot.devices.names import DEFINE_TYPE
from homebot.graph import EntityKind, Graph, Node
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import FieldDefinition, definition_text, fields_of, nested_types
from homebot.messages.message import Int32, Message, ServiceType, UInt8, UInt32
from homebot.names import absolute_name, is_hidden

_Answer: TypeAlias = Mapping[str, object]
_Answerer: TypeAlias = Callable[[Graph, Any], object]

_OWN: Final = {"doctor": "Examine", "endpoints": "FindEndpoints", "load": "MeasureLoad", "rights": "GetRights"}
"""The types of the services of our own, each in a module of its name, as few runs are asked."""

_EXAMPLES: Final = {"bool": "False", "string": "", "wstring": "", "float32": "0.0", "float64": "0.0"}


class TimeOfBothKinds(Message):
    """A point in time as ROS 2 and as ROS 1 spell it, since clients of both ask."""

    sec: Int32
    nanosec: UInt32
    secs: Int32
    nsecs: UInt32


class TypeDef(Message, ros_type="rosapi_msgs/msg/TypeDef"):
    """The fields of a message type.

    Attributes:
        type: Its name, as ``package/Name``.
        fieldtypes: The fields' types; of one element where the field is an array.
        fieldarraylen: -1 for one value, 0 for any number of values, else exactly that many.
        examples: A value of each field, as text.
    """

    type: str
    fieldnames: tuple[str, ...]
    fieldtypes: tuple[str, ...]
    fieldarraylen: tuple[Int32, ...]
    examples: tuple[str, ...]
    constnames: tuple[str, ...]
    constvalues: tuple[str, ...]


def _topics(graph: Graph, _request: Message) -> _Answer:
    types = graph.get_topic_names_and_types()
    topics = _visible(types)
    return {"topics": topics, "types": tuple(types[topic] for topic in topics)}


def _topics_with_texts(graph: Graph, request: Message) -> _Answer:
    topics = _topics(graph, request)
    carried = (graph.get_message_type(topic) for topic in _visible(graph.get_topic_names_and_types()))
    return {
        **topics,
        "typedefs_full_text": tuple(definition_text(message_type) for message_type in carried if message_type),
    }


def _topics_of_type(graph: Graph, request: Any) -> tuple[str, ...]:
    types = (known.ros_type for known in graph.get_message_types() if same_type(known.ros_type, request.type))
    return _visible(_unique(name for ros_type in types for name in graph.get_topics_of_type(ros_type)))


def _type_of_topic(graph: Graph, request: Any) -> str:
    message_type = graph.get_message_type(absolute_name(request.topic))
    return message_type.ros_type if message_type else ""


def _type_of_action(graph: Graph, request: Any) -> str:
    return graph.get_action_names_and_types().get(absolute_name(request.action), "")


def _action_servers(graph: Graph, _request: Message) -> tuple[str, ...]:
    return tuple(action.name for action in graph.actions() if action.servers)


def _of_service(fact: str) -> _Answerer:
    """Return the function that answers with a *fact* of the server of a service; empty without one."""

    def answer(graph: Graph, request: Any) -> str:
        servers = graph.get_endpoints(kind=EntityKind.SERVICE, name=absolute_name(request.service))
        return next((getattr(server, fact) for server in servers), "")

    return answer


def _typedefs(find: Callable[[Graph, str], Any], part: str = "") -> _Answerer:
    """Return the function that describes the type that *find* finds, or a *part* of it such as its Request."""

    def answer(graph: Graph, request: Any) -> tuple[TypeDef, ...]:
        definition = find(graph, request.type)
        message_type: type[Message] = getattr(definition, part) if part else definition
        return tuple(_typedef(nested) for nested in (message_type, *nested_types(message_type)))

    return answer


def _typedef(message_type: type[Message]) -> TypeDef:
    fields = fields_of(message_type)
    constants = {name: str(value) for name, value in vars(message_type).items() if name.isupper()}
    return TypeDef(
        type=_short(message_type.ros_type),
        fieldnames=tuple(field.name for field in fields),
        fieldtypes=tuple(_short(field.ros_type) for field in fields),
        fieldarraylen=tuple(field.size or 0 if field.is_array else -1 for field in fields),
        examples=tuple(_example(field) for field in fields),
        constnames=tuple(constants),
        constvalues=tuple(constants.values()),
    )


def _short(ros_type: str) -> str:
    package, slash, rest = ros_type.partition("/")
    return f"{package}{slash}{rest.rpartition('/')[2]}"


def _example(field: FieldDefinition) -> str:
    if field.is_array:
        return "[]"
    return "{}" if field.message is not None else _EXAMPLES.get(field.ros_type, "0")


def _node_details(graph: Graph, request: Any) -> _Answer:
    """Return the subscriptions, publications and services of a node; empty for an unknown one."""
    ends = graph.get_endpoints(node=absolute_name(request.node))
    return {
        "subscribing": _unique(info.name for info in ends if info.kind is EntityKind.SUBSCRIPTION),
        "publishing": _unique(info.name for info in ends if info.kind is EntityKind.PUBLISHER),
        "services": _unique(info.name for info in ends if info.kind is EntityKind.SERVICE),
    }


def _version(graph: Graph, _request: Message) -> _Answer:
    """Return the version of ROS that has these types: clients choose their own by it."""
    return {"version": 2, "distro": graph.interfaces.distribution}


def _time(graph: Graph, _request: Message) -> TimeOfBothKinds:
    now = Time.from_seconds(graph.clock.now())
    return TimeOfBothKinds(sec=now.sec, nanosec=now.nanosec, secs=now.sec, nsecs=now.nanosec)


def _serve_fact(fact: str, type_field: str) -> _Answerer:
    """Return the function that answers with a *fact* of each server of the type in a field."""

    def answer(graph: Graph, request: Any) -> tuple[str, ...]:
        wanted = getattr(request, type_field)
        types = [known.ros_type for known in graph.get_service_types(partial(same_type, wanted))]
        return _visible(
            _unique(getattr(service, fact) for known in types for service in graph.get_services_of_type(known))
        )

    return answer


def _users(kind: EntityKind) -> _Answerer:
    """Return the function that answers with the nodes that have an end of *kind* on a topic."""
    return lambda graph, asked: _unique(
        endpoint.node for endpoint in graph.get_endpoints(kind=kind, name=absolute_name(asked.topic))
    )


def _nodes(graph: Graph) -> list[str]:
    """Return the full names of all nodes, also of those that a link shows."""
    return sorted({endpoint.name for endpoint in graph.get_endpoints(kind=EntityKind.NODE)})


def _visible(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(name for name in names if not is_hidden(name))


def _unique(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(set(names)))


def _parameters(name: str) -> _Answerer:
    """Return a function that answers about parameters; its module is loaded with the first question."""

    def answer(graph: Graph, request: Any) -> object:
        return getattr(import_module("homebot.bridges.rosapi.parameters"), name)(graph, request)

    return answer


_DONE: Final = "bool successful, string reason"
_TYPES: Final[Mapping[str, object]] = {
    "bool": bool,
    "string": str,
    "string[]": tuple[str, ...],
    "time": TimeOfBothKinds,
    "TypeDef[]": tuple[TypeDef, ...],
    "uint8": UInt8,
}

_SERVICES: Final[Mapping[str, tuple[str, str, _Answerer]]] = {
    "action_feedback_details": ("string type", "TypeDef[] typedefs", _typedefs(find_action_type, "Feedback")),
    "action_goal_details": ("string type", "TypeDef[] typedefs", _typedefs(find_action_type, "Goal")),
    "action_result_details": ("string type", "TypeDef[] typedefs", _typedefs(find_action_type, "Result")),
    "action_servers": ("", "string[] action_servers", _action_servers),
    "action_type": ("string action", "string type", _type_of_action),
    "delete_param": ("string name", _DONE, _parameters("delete_parameter")),
    "get_param": ("string name, string default_value ''", f"string value, {_DONE}", _parameters("get_parameter")),
    "get_param_names": ("", "string[] names", _parameters("list_parameters")),
    "get_ros_version": ("", "uint8 version, string distro", _version),
    "get_time": ("", "time time", _time),
    "has_param": ("string name", "bool exists", _parameters("has_parameter")),
    "interfaces": ("", "string[] interfaces", lambda graph, _: interfaces_of(graph).names()),
    "message_details": ("string type", "TypeDef[] typedefs", _typedefs(find_message_type)),
    "node_details": ("string node", "string[] subscribing, string[] publishing, string[] services", _node_details),
    "nodes": ("", "string[] nodes", lambda graph, _: _visible(_nodes(graph))),
    "publishers": ("string topic", "string[] publishers", _users(EntityKind.PUBLISHER)),
    "service_node": ("string service", "string node", _of_service("node")),
    "service_providers": ("string service", "string[] providers", _serve_fact("node", "service")),
    "service_request_details": ("string type", "TypeDef[] typedefs", _typedefs(find_service_type, "Request")),
    "service_response_details": ("string type", "TypeDef[] typedefs", _typedefs(find_service_type, "Response")),
    "service_type": ("string service", "string type", _of_service("ros_type")),
    "services": ("", "string[] services", lambda graph, _: _visible(graph.get_service_names_and_types())),
    "services_for_type": ("string type", "string[] services", _serve_fact("name", "type")),
    "set_param": ("string name, string value", _DONE, _parameters("set_parameter")),
    "subscribers": ("string topic", "string[] subscribers", _users(EntityKind.SUBSCRIPTION)),
    "topic_type": ("string topic", "string type", _type_of_topic),
    "topics": ("", "string[] topics, string[] types", _topics),
    "topics_and_raw_types": ("", "string[] topics, string[] types, string[] typedefs_full_text", _topics_with_texts),
    "topics_for_type": ("string type", "string[] topics", _topics_of_type),
}
"""Fields of request and response as in ``.srv`` files, with commas between them, and the function that answers: with
the fields of the response, or with the value if it has one field."""

_OTHER_NAMES: Final = {"action_servers": "GetActionServers", "get_ros_version": "GetROSVersion"}
"""The types that have not the name of the service in CamelCase."""


class RosApi:
    """Offers the rosapi services on *node*, and the definition of types; they go with it.

    Names that begin with an underscore are hidden, as in ROS; ``/rosapi/endpoints`` and ``/rosapi/load``, which are
    ours as ``/rosapi/doctor`` and ``/rosapi/rights`` are, show them too.

    Args:
        node: The node that serves; its name should be ``rosapi``, though the services have that name in any case.
        vacuums: The topics of vacuums that are robots, for the doctor.
    """

    def __init__(self, node: Node, vacuums: Collection[str] = ()) -> None:
        error_log = ClientErrorLog(node)
        for name in _SERVICES:
            node.offer_service(_ros_type(name), f"/rosapi/{name}", partial(_serve, node, name, error_log))
        node.create_service(DefineType, DEFINE_TYPE, partial(define_type, node.graph))
        facts = {"doctor": (vacuums,)}
        for name, kind in _OWN.items():
            load = partial(import_module, f"homebot.bridges.rosapi.{name}")
            serve = partial(_serve_own, node, load, *facts.get(name, ()))
            node.offer_service(f"homebot/srv/{kind}", f"/rosapi/{name}", serve, load)


def _serve_own(node: Node, load: Callable[[], Any], *facts: Collection[str]) -> None:
    """Offer a service of our own, from the module that is called as it, which takes the *facts*."""
    load().serve(node, *facts)


def _serve(node: Node, name: str, error_log: ClientErrorLog) -> None:
    """Offer a service on *node*; log why a parameter was not set, as the libraries of clients do not read it."""
    request_fields, response_fields, answer = _SERVICES[name]
    ros_type = _ros_type(name)
    response = _message_type(f"{ros_type}_Response", response_fields)
    service_type = ServiceType(ros_type, _message_type(f"{ros_type}_Request", request_fields), response)

    def handle(request: Message) -> Message:
        answered: Any = answer(node.graph, request)
        fields = answered if isinstance(answered, dict) else dict.fromkeys(response.model_fields, answered)
        if response_fields is _DONE and not fields["successful"]:
            error_log.log(name, "rosapi.refused", f"{name} was refused: {fields['reason']}")
        return response(**fields)

    node.create_service(service_type, f"/rosapi/{name}", handle)


def _ros_type(name: str) -> str:
    return f"rosapi_msgs/srv/{_OTHER_NAMES.get(name) or name.title().replace('_', '')}"


def _message_type(ros_type: str, fields: str) -> type[Message]:
    definitions: dict[str, Any] = {}
    for field in filter(None, fields.split(", ")):
        kind, name, *default = field.split(" ")
        definitions[name] = (_TYPES[kind], "" if default else ...)
    name = ros_type.rpartition("/")[2].replace("_", "")
    return create_model(name, __base__=Message, __cls_kwargs__={"ros_type": ros_type}, **definitions)
