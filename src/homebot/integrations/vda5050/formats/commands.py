"""Orders and instant actions for a robot. Pure.

Source: VDA 5050 2.1 and 3.0, ``order.schema``, ``instantActions.schema`` and "Predefined actions".
"""

import math
from collections.abc import Iterator, Mapping
from datetime import UTC
from typing import Final, final

from homebot.clock import home_time
from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import JsonMessage, compact_json, parse_object
from homebot.errors import RefusedError
from homebot.integrations.vda5050.formats.state import RobotState, entries_of, reference_of

_DEVIATION: Final = 0.5
"""Metres around the position of a robot in which it stands on the first node of its order."""

_HERE: Final = "here"
"""The id of that node if the robot stands on none."""

_ACTIONS: Final = {"paused": "startPause", "working": "stopPause"}


@final
class RobotCommands:
    """Writer of the commands for one robot.

    Args:
        base: The topic above those of the robot.
        major: The major version of its topics, such as ``v2``.
        nodes: Where it may be sent; see :class:`homebot.integrations.vda5050.formats.Vda5050Settings`.
        charger: The node where it charges; empty if it charges where it stands.

    Attributes:
        state: Its last state; None before the first.
    """

    def __init__(self, base: str, major: str, nodes: Mapping[str, tuple[float, ...]], charger: str) -> None:
        self.state: RobotState | None = None
        self._base, self._major, self._nodes, self._charger = base, major.removeprefix("v"), nodes, charger
        self._sent: dict[str, int] = {}

    def go(self, node: str) -> Publications:
        """Return the order to drive to *node*, one of the nodes.

        Raises:
            RefusedError: The robot cannot take an order now.
        """
        return self._order(node, "destination")

    def act(self, activity: str) -> Publications:
        """Return what makes the robot ``idle``, ``working``, ``paused`` or ``charging``.

        Raises:
            RefusedError: It cannot do so now.
        """
        state = self._known("option", activity)
        if activity == "charging":
            if self._charger:
                return self._order(self._charger, "option", charge=True)
            self._require_free(state, "option", activity)
            return self._instantly("startCharging")
        if activity == "idle":
            if state.has_order:
                return self._instantly("cancelOrder")
            return self._instantly("stopPause" if state.is_paused else "stopCharging")
        if activity == "working" and not state.has_order:
            raise RefusedError(f"option {activity!r}", "it has no order to go on with; set its destination")
        return self._instantly(_ACTIONS[activity])

    def request(self) -> Publications:
        """Return the request to tell the state now, as a robot may be silent about it for 30 seconds."""
        return self._instantly("stateRequest", self.state or RobotState({}))

    def refusal(self, sent: Publications) -> str:
        """Return why the robot refuses the order or action that was *sent*, by its last state; empty if it does not."""
        known = {} if self.state is None else self.state.refusals
        return next((known[name] for one in sent for name in _ids(parse_object(one.payload)) if name in known), "")

    def _known(self, capability: str, wanted: str) -> RobotState:
        if self.state is None:
            raise RefusedError(f"{capability} {wanted!r}", "the robot has not told its state yet")
        return self.state

    def _require_free(self, state: RobotState, capability: str, wanted: str) -> None:
        if state.is_by_hand:
            raise RefusedError(f"{capability} {wanted!r}", f"the robot takes no orders in its mode {state.mode}")
        if state.has_order:
            raise RefusedError(f"{capability} {wanted!r}", "the robot has an order; set its option to idle first")

    def _order(self, target: str, capability: str, *, charge: bool = False) -> Publications:
        state = self._known(capability, target)
        self._require_free(state, capability, target)
        if state.is_lost:
            raise RefusedError(f"{capability} {target!r}", "the robot does not know where it is; localize it first")
        if state.charging and not charge:
            return self._instantly("stopCharging")  # it takes no order before; sent again, the command is the order
        order_id = f"homebot {state.timestamp} {target}"  # the same for the same state: sent again, it acts once
        here = state.last_node or _HERE
        start: dict[str, object] = {"nodeId": here, "sequenceId": 0, "released": True, "actions": []}
        if state.position is not None:
            position = state.position
            start["nodePosition"] = self._position(state, (position.x, position.y), _DEVIATION)
        end: dict[str, object] = {"nodeId": target, "sequenceId": 2, "released": True, "actions": []}
        if (place := self._nodes[target]) and state.position is not None:  # else it needs the node alone
            end["nodePosition"] = self._position(state, place)
        if charge:
            end["actions"] = [_action("startCharging", f"{order_id} charge", "HARD")]
        edge: dict[str, object] = {
            "edgeId": f"{here}-{target}",
            "sequenceId": 1,
            "released": True,
            "startNodeId": here,
            "endNodeId": target,
            "actions": [],
        }
        if self._major != "2":
            del edge["startNodeId"], edge["endNodeId"]
        order = {"orderId": order_id, "orderUpdateId": 0, "nodes": [start, end], "edges": [edge]}
        return self._message("order", order)

    def _position(self, state: RobotState, place: tuple[float, ...], deviation: float = 0.0) -> Mapping[str, object]:
        position: dict[str, object] = {"x": place[0], "y": place[1], "mapId": state.map}
        if len(place) > 2:
            position["theta"] = math.remainder(place[2], math.tau)
        if deviation:
            round_ = {"a": deviation, "b": deviation, "theta": 0.0}
            position["allowedDeviationXY"] = deviation if self._major == "2" else round_
        return position

    def _instantly(self, action: str, state: RobotState | None = None) -> Publications:
        number = self._sent.get("instantActions", -1) + 1
        state = state or self._known("option", action)
        named = _action(action, f"homebot {self._now(state)} {action} {number}", "NONE")
        # 2.0 and its schema have two names for the list
        keys = (
            ("actions", "instantActions") if (state.version or f"{self._major}.0").startswith("2.0") else ("actions",)
        )
        return self._message("instantActions", {key: [named] for key in keys}, state)

    def _message(self, topic: str, content: Mapping[str, object], state: RobotState | None = None) -> Publications:
        state = state or self._known(topic, "")
        number = self._sent[topic] = self._sent.get(topic, -1) + 1
        maker, serial = self._base.rsplit("/", 2)[1:]
        header = {
            "headerId": number,
            "timestamp": self._now(state),
            "version": state.version or f"{self._major}.0.0",
            "manufacturer": maker,
            "serialNumber": serial,
        }
        return (Publication(f"{self._base}/{topic}", compact_json({**header, **content}).encode()),)

    @staticmethod
    def _now(state: RobotState) -> str:
        now = home_time.get()
        told_at = state.timestamp if now is None else now().astimezone(UTC).isoformat(timespec="milliseconds")
        return told_at.replace("+00:00", "Z")


def _ids(message: JsonMessage) -> Iterator[str]:
    """Yield the ids of an order and of its actions, or of instant actions."""
    yield reference_of(message.get("orderId"))
    for holder in (message, *entries_of(message, "nodes")):
        yield from (reference_of(action.get("actionId")) for action in entries_of(holder, "actions"))


def _action(name: str, action_id: str, blocking: str) -> dict[str, object]:
    return {"actionType": name, "actionId": action_id, "blockingType": blocking, "actionParameters": []}
