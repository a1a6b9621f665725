"""The access of clients of the rosbridge server: the right that each operation needs. No I/O.

homebot's own topics and services are those below the namespaces of its nodes, and the inboxes to which gateways deliver
raw messages of devices. Reading them is harmless, and so are services that only answer; with the others a client could
impersonate a gateway, the directory or the control layer.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, TypeVar

from homebot.bridges.client_error_log import short_text
from homebot.bridges.rosbridge import protocol
from homebot.devices.client_rights import ALL_ROBOTS, LOCAL_CLIENT, ClientRights, issuer_of_client
from homebot.devices.own_services import is_own, right_to_call
from homebot.errors import PeerError
from homebot.messages.definition import fields_of
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.message import Message
from homebot.rights import Right

if TYPE_CHECKING:
    from homebot.devices.robot_owners import RobotOwners

MessageT = TypeVar("MessageT", bound=Message)

_PUBLISHING: Final = frozenset({"advertise", "advertise_action", "advertise_service", "publish"})
_CALLING: Final = frozenset({"call_service", "send_action_goal"})
_REQUESTS: Final = frozenset(f"/{way}{kind}_requests" for way in ("", "adapter_") for kind in ("door", "lift"))
"""Topics that need a robot's right, because the app that serves them may be allowed to unlock."""

_SEVERAL: Final = "?"
_MAX_NAME: Final = 247
_WORD: Final = re.compile(r"[A-Za-z_ ]{1,40}")
"""A command without a number, so that it contains no code."""


class MissingRightError(PeerError):
    """A client lacks the right for a request."""

    def __init__(self, right: Right, problem: str) -> None:
        super().__init__(problem)
        self.right = right


@dataclass(frozen=True, slots=True)
class ClientAccess:
    """Name and rights of a client.

    Attributes:
        name: The name of its token, or ``local`` without one.
        owners: The robots of the house, with their topics and frames.
        is_page: Whether it is homebot's own page without a token, which may neither manage homebot, nor impersonate its
            parts or a robot.
        is_program: Whether nobody is known to command by it: neither homebot's own page, nor
            the owner.
        owner_file: The file with the owner's token; empty for none.
    """

    name: str
    rights: ClientRights
    owners: RobotOwners
    is_page: bool = False
    is_program: bool = False
    owner_file: str = ""

    @classmethod
    def of(
        cls,
        name: str,
        rights: ClientRights,
        owners: RobotOwners,
        *,
        is_page: bool,
        is_program: bool = False,
        owner_file: str = "",
    ) -> ClientAccess:
        """Return the access of a client, or of homebot's own page without a token."""
        if is_page:
            own = rights.kinds - {Right.MANAGE, Right.RAW, Right.ROBOT}
            rights = rights._replace(kinds=own, robots=())
        return cls(name, rights, owners, is_page, is_program, owner_file)

    @property
    def issuer(self) -> str:
        """The issuer of its commands."""
        return issuer_of_client(self.name)

    def stamped(self, message_type: type[Message], values: Mapping[str, object]) -> Mapping[str, object]:
        """Return *values* of a message, with the client's own issuer, scope and rights in place of any in it.

        A listener is removed, as the client is not a node.
        """
        fields = _stamped_fields(message_type)
        own: dict[str, object] = {"issuer": self.issuer, "scope": list(self.rights.act_scope), "listener": ""}
        own["rights"] = sorted(kind.value for kind in self.rights.kinds)
        own["override"] = values.get("override") is True and (
            not self.rights.robots or Right.MANAGE in self.rights.kinds  # the owner, who may be any robot too
        )
        own["trigger"] = {"kind": "program"} if self.is_program else {}  # only homebot's own nodes know more
        return {**values, **{name: own[name] for name in fields}} if fields else values

    def as_own(self, message: MessageT) -> MessageT:
        """Return *message* as :meth:`stamped` has it."""
        message_type, values = type(message), message.__dict__
        if self.stamped(message_type, values) is values:
            return message
        return message_from_json(message_type, self.stamped(message_type, message_to_json(message)))

    def wishes(self, name: str) -> bool:
        """Return whether a call of the service or action *name* counts as a person's wish.

        It does not for a client that may only command some devices, as the app might command others.
        """
        return not is_own(name) and self.rights.acts_on_harmless

    @staticmethod
    def command_in(op: protocol.Operation) -> tuple[str, str]:
        """Return the target and content of a command in words in *op*, if there is one."""
        match op:
            case protocol.PublishOperation():
                return _text(op.msg, "address"), _word(op.msg, "payload")
            case protocol.CallService(args=dict() as args):
                return _text(args, "device") or _text(args, "target"), _word(args, "command")
        return "", ""

    def check(self, op: protocol.Operation, resolve: Callable[[str], str]) -> None:
        """Refuse *op* if the client lacks the right to it; *resolve* makes names absolute.

        Raises:
            MissingRightError: It lacks a right; the message says which, and how to get it.
        """
        if op.op in _PUBLISHING:
            self.check_publishing(resolve(op.name))
        elif op.op in _CALLING:
            self.check_calling(resolve(op.name))
        elif op.op == "subscribe":  # others end earlier operations, or only concern the client
            self._check_right(Right.READ)

    def check_publishing(self, name: str) -> None:
        """Refuse to publish on the topic, or to serve, the full *name*, as :meth:`check` does."""
        self._check_right(self._right_to_publish(name))

    def check_calling(self, name: str) -> None:
        """Refuse calls of the full *name*, as :meth:`check` does."""
        self._check_right(right_to_call(name))

    def check_robot(self, topic: str, message: Message) -> None:
        """Refuse *message* on the full name *topic* if it concerns a robot that the client may not be."""
        own = self.owners.names if self.rights.may_be(ALL_ROBOTS) else self.rights.robots
        if foreign := self.owners.foreign(topic, message, own):
            raise MissingRightError(
                Right.ROBOT, f"{foreign} is not of the robot {' or '.join(own) or 'of this client'}"
            )

    def _check_right(self, right: Right) -> None:
        if not self.rights.has(right):
            raise MissingRightError(right, self._problem(right))

    def _right_to_publish(self, name: str) -> Right:
        """Return the right that the client needs to publish, after checking its right to be the robot of *name*."""
        right = right_to_publish(name)
        robot = "" if name in _REQUESTS else self.owners.of_topic(name)
        if right is Right.RAW or robot is None:
            return right
        if robot != _SEVERAL and self.rights.may_be(robot):
            return Right.ROBOT
        is_plain = bool(robot) and not name.startswith(f"/{robot}/")
        if robot == _SEVERAL or (is_plain and len(self.owners.names) > 1):
            problem = f"this house has several robots ({', '.join(self.owners.names)}); publish below /NAME"
            raise MissingRightError(Right.ROBOT, problem)
        raise MissingRightError(Right.ROBOT, self._problem(Right.ROBOT, robot))

    def _problem(self, right: Right, robot: str = "") -> str:
        wanted = {Right.ACT: "act: harmless", Right.ROBOT: f"robot: {robot or self.owners.sole or 'NAME'}"}.get(
            right, right.value
        )
        if self.name == LOCAL_CLIENT:
            client = f"a {'web page' if self.is_page else 'client'} without a token"
            scopes = "".join(f" --scope {json.dumps(scope)}" for scope in dict.fromkeys(("read", wanted)))
            own = f"use the owner's token, which the user of homebot finds in {self.owner_file} (--token-file), or "
            advice = f"{own if self.owner_file else ''}make a token: homebot token new NAME{scopes}"
        else:
            client = f"the token {self.name}"
            advice = f'add "{wanted}" to its scope, in the table [door.tokens.{self.name}] of homebot.toml'
        return f"the right {right.value} is missing; {client} has: {self.rights.text}. To give it, {advice}"


@lru_cache(maxsize=256)
def _stamped_fields(message_type: type[Message]) -> tuple[str, ...]:
    fields = {field.name for field in fields_of(message_type)}
    stamped = sorted(fields & {"issuer", "scope", "listener", "rights", "trigger", "override"})
    return tuple(stamped) if fields & {"issuer", "listener"} else ()


@lru_cache(maxsize=1024)
def right_to_publish(name: str) -> Right:
    """Return the right needed to publish on the topic, or to provide the service, with the full *name*."""
    return Right.RAW if is_own(name) or name.endswith("/inbox") else Right.ACT


def _text(values: Mapping[str, object], key: str) -> str:
    value = values.get(key)
    return short_text(value, _MAX_NAME) if isinstance(value, str) else ""


def _word(values: Mapping[str, object], key: str) -> str:
    text = _text(values, key).strip()
    return text if _WORD.fullmatch(text) else ""
