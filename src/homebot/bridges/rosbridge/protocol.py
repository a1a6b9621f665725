"""The frames of rosbridge v2: JSON text in, typed operations out, and the JSON that goes back. No I/O.

Clients get failures in ``status`` frames, unless they turned these off with ``set_level``; calls and goals are always
answered.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, sections 1 to 3.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, ValidationError
from pydantic_core import PydanticCustomError

from homebot.bridges.rosbridge.json_pieces import MAX_NESTING, RefusedJsonError, parse_in_pieces
from homebot.errors import PeerError
from homebot.messages.json import JsonObject, message_to_text, validation_problem
from homebot.messages.message import Message
from homebot.support.strict_json import DuplicateKeyError

Identifier: TypeAlias = "str | int | None"
Level: TypeAlias = Literal["none", "error", "warning", "info"]
COMPRESSIONS = ("none", "cbor", "cbor-raw")
_NAMES = ("service", "action", "topic")

_MAX_ID = 1000
Name = Annotated[str, Field(min_length=1, max_length=500)]
Milliseconds = Annotated[float, Field(ge=0, le=3_600_000, allow_inf_nan=False)]
Seconds = Annotated[float, Field(allow_inf_nan=False)]


def _arguments(value: object) -> object:
    if not isinstance(value, dict | list):
        raise PydanticCustomError("arguments", "has to be an object, or a list of the fields in order")
    return value


def _identifier(value: object) -> object:
    if not _is_identifier(value):
        raise PydanticCustomError("identifier", f"has to be a whole number or a text of up to {_MAX_ID} characters")
    return value


Id = Annotated[str | int, PlainValidator(_identifier)]
Arguments = Annotated[dict[str, Any] | list[Any], BeforeValidator(_arguments)]


class FrameError(PeerError):
    """A frame is not an operation of the protocol.

    Attributes:
        op: Its operation, as far as recognizable; otherwise empty.
        id: The identifier for the answer, if it has one.
        name: Its service, action or topic, as far as recognizable; otherwise empty.
        problem: The problem with the operation; without an operation, a clause after "a frame that".
    """

    def __init__(self, problem: str, op: str = "", identifier: Identifier = None, name: str = "") -> None:
        super().__init__(f"{op}: {problem}" if op else f"the frame {problem}")
        self.op = op
        self.id = identifier
        self.name = name
        self.problem = problem


_CLASSES: dict[str, type[Operation]] = {}
"""The operations of clients, by their names in the protocol."""


class Operation(BaseModel):
    """An operation of a client.

    Operations of this class itself are ignored: clients log in when they connect, and the server of an action knows its
    goals.

    Attributes:
        id: The client's identifier of the interaction; answers repeat it.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True, defer_build=True)

    op: str
    id: Id | None = None

    def __init_subclass__(cls, ops: tuple[str, ...] = (), **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        _CLASSES.update(dict.fromkeys(ops, cls))

    @property
    def name(self) -> str:
        """The topic, service or action concerned; empty for none."""
        return next((getattr(self, key) for key in _NAMES if hasattr(self, key)), "")


_CLASSES |= dict.fromkeys(("auth", "status", "action_status"), Operation)


class TopicOperation(Operation, ops=("unadvertise", "unsubscribe")):
    """The client stops publishing on, or reading, ``topic``; without an id, under all its ids."""

    topic: Name


class Qos(BaseModel):
    """The quality of service that rosbridge_suite from 2.7 takes, as far as it has an effect here.

    Attributes:
        durability: ``transient_local`` for messages before the subscription; in ROS it is written in capitals too.
        depth: Messages that are kept, or may wait; 0 for what other fields say.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", strict=True, defer_build=True)

    durability: Annotated[str, AfterValidator(str.lower)] = ""
    depth: Annotated[int, Field(ge=0)] = 0


class _Publishing(TopicOperation):
    """An operation of a client that publishes on ``topic``."""

    latch: bool = False
    qos: Qos = Field(default_factory=Qos)

    @property
    def kept(self) -> int:
        """Return the number of messages that late subscribers receive; 0 for those of the last second."""
        is_latched = self.latch or self.qos.durability == "transient_local"
        return max(1, self.qos.depth) if is_latched else 0


class Advertise(_Publishing, ops=("advertise",)):
    """The client will publish messages of ``type`` on ``topic``."""

    type: Name


class PublishOperation(_Publishing, ops=("publish",)):
    """A message for a topic."""

    msg: dict[str, Any]
    type: str = ""


class SubscribeOperation(TopicOperation, ops=("subscribe",)):
    """The client wants the messages of ``topic``.

    Attributes:
        throttle_rate: Least milliseconds between two messages.
        queue_length: Messages that may wait while throttled, the oldest dropped first; 0 drops all. The depth of
            ``qos`` takes its place.
        compression: The form of messages: JSON, CBOR, or ROS 2's own encoding (``cbor-raw``); others get JSON.
    """

    type: str = ""
    throttle_rate: Milliseconds = 0
    queue_length: Annotated[int, Field(ge=0)] = 0
    qos: Qos = Field(default_factory=Qos)
    compression: str = "none"


class Request(Operation):
    """A service call or a goal.

    Attributes:
        args: The fields of the request, by name or as a list in order.
        compression: The form of answers that the client wants; all get JSON.
    """

    args: Arguments = Field(default_factory=dict)
    compression: str = "none"


class ServiceOperation(Operation, ops=("unadvertise_service",)):
    """The client stops providing ``service``."""

    service: Name


class CallService(Request, ServiceOperation, ops=("call_service",)):
    """A service call; ``type`` may be empty.

    Attributes:
        sent: When the client sent it, in seconds by a clock of its own, from any beginning; 0 for unknown.
        patience: The seconds after which the client gives it up; if it arrives later than that, by *sent*, it is not
            carried out. 0 for ever.
    """

    type: str = ""
    timeout: Seconds = 0
    sent: Seconds = 0
    patience: Seconds = 0


class ServiceResponse(Operation, ops=("service_response",)):
    """The answer to a call of a service that the client provides; ``values`` is a text if ``result`` is false."""

    service: str = ""
    values: Any = None
    result: bool = False


class AdvertiseService(ServiceOperation, ops=("advertise_service",)):
    """The client provides a service."""

    type: Name


class SetLevel(Operation, ops=("set_level",)):
    """The least level of status messages for the client."""

    level: Level


class ActionOperation(Operation, ops=("cancel_action_goal", "unadvertise_action")):
    """The client cancels its goal with this id, or stops executing goals of ``action``."""

    action: Name


class SendActionGoal(Request, ActionOperation, ops=("send_action_goal",)):
    """A goal for an action."""

    action_type: str = ""
    feedback: bool = False


class ActionFeedback(ActionOperation, ops=("action_feedback",)):
    """Feedback of a goal that the client executes."""

    values: dict[str, Any] = Field(default_factory=dict)


class ActionResult(ActionOperation, ops=("action_result",)):
    """The end of a goal that the client executes; ``values`` is a text if ``result`` is false.

    Attributes:
        status: 4 succeeded, 5 canceled, 6 aborted; 0 for the one that ``result`` says.
    """

    values: Any = None
    status: int = 0
    result: bool = False


class AdvertiseAction(ActionOperation, ops=("advertise_action",)):
    """The client executes the goals of an action."""

    type: Name


def parse_frame(text: str) -> Generator[None, None, Operation]:
    """Return the operation in the frame *text*; null fields count as missing, and 1.0 is 1.

    Other tasks may run between its steps.

    Raises:
        FrameError: It is not a JSON object, is nested more than 100 deep, is not valid Unicode, has an unknown
            operation, or a field is missing or wrong; the message names the field and its value.
    """
    value = yield from _load(text)
    if not isinstance(value, dict):
        raise FrameError(f"is not a JSON object: {text[:60]!r}")
    fields = {name: _as_whole(item) for name, item in value.items() if item is not None}
    field: Any = fields.get("id")
    op, known_id = _op_in(fields), field if _is_identifier(field) else None
    cls = _CLASSES.get(op)
    if cls is None:
        problem = f"uses the unknown operation {op[:60]!r}; known are {', '.join(sorted(_CLASSES))}"
        raise FrameError(problem, "", known_id)
    try:
        return cls.model_validate(fields)
    except ValidationError as exc:
        name = next((item for key in _NAMES if isinstance(item := fields.get(key), str)), "")
        raise FrameError(validation_problem(exc), op, known_id, name) from exc


def _op_in(fields: Mapping[str, object]) -> str:
    op = fields.get("op")
    if isinstance(op, str):
        return op
    raise FrameError(
        "lacks the field 'op'" if op is None else f"needs a string in its field 'op', got {str(op)[:60]!r}"
    )


def _is_identifier(value: object) -> bool:
    return isinstance(value, int) or (isinstance(value, str) and len(value) <= _MAX_ID)


def frame_text(op: str, identifier: Identifier, fields: JsonObject, /, **texts: str) -> str:
    """Return the frame of the operation *op* for a client, in ASCII, which no client can mistake for broken Unicode.

    Args:
        texts: Further fields as JSON text.
    """
    known = {"op": op, **fields} | ({} if identifier is None else {"id": identifier})
    begin = json.dumps(known, separators=(",", ":"), allow_nan=False)[:-1]
    return "".join((begin, *(f',"{name}":{text}' for name, text in texts.items()), "}"))


def publish_frame(topic: str, message: Message, lost: int = 0) -> str:
    """Return the frame with *message*; ``lost`` (an extension) is the number dropped before it."""
    losses = f',"lost":{lost}' if lost else ""
    return f'{{"op":"publish","topic":{json.dumps(topic)},"msg":{message_to_text(message)}{losses}}}'


def failure_frame(op: Operation | FrameError, problem: str, status: int = 0) -> str:
    """Return the frame with the reason for the failure of a call or goal; a goal of *status* 0 was not accepted."""
    failure: JsonObject = {"values": problem, "result": False}
    if op.op == "call_service":
        return frame_text("service_response", op.id, {"service": op.name, **failure})
    return frame_text("action_result", op.id, {"action": op.name, "status": status, **failure})


def _as_whole(item: Any) -> Any:
    """Return a number without a fraction as an integer: some languages, such as Godot's, have one kind of number."""
    return int(item) if isinstance(item, float) and item.is_integer() else item


def _load(text: str) -> Generator[None, None, object]:
    try:
        return (yield from parse_in_pieces(text))
    except RecursionError:
        raise FrameError(f"is nested more than {MAX_NESTING} deep") from None
    except DuplicateKeyError as exc:
        raise FrameError(f"is ambiguous: {exc}") from exc
    except RefusedJsonError as exc:
        raise FrameError(str(exc)) from exc
    except ValueError as exc:
        raise FrameError(f"is not JSON: {exc}") from exc
