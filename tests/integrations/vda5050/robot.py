"""A simulated robot of VDA 5050, of version 2 or 3, that obeys orders and instant actions. Pure."""

import json
from dataclasses import dataclass, field
from typing import Any

from homebot.conventions.description import Publication

_SECONDS = 30


@dataclass
class FleetRobot:
    """A robot that stands on a node until it gets an order, and reaches one node of it with each :meth:`drive`.

    Attributes:
        closed: Nodes to which it takes no orders.
        refused: Why it refused orders, in the order of these.
    """

    major: int = 2
    interface: str = "uagv"
    node: str = "dock"
    x: float = 0.0
    y: float = 0.0
    mode: str = "AUTOMATIC"
    charge: float = 80.0
    charging: bool = False
    paused: bool = False
    order: dict[str, Any] = field(default_factory=dict)
    ahead: list[dict[str, Any]] = field(default_factory=list)
    actions: list[dict[str, str]] = field(default_factory=list)
    errors: list[dict[str, Any]] = field(default_factory=list)
    stop: str = "NONE"
    closed: tuple[str, ...] = ()
    refused: list[str] = field(default_factory=list)
    sent: int = 0

    @property
    def base(self) -> str:
        """The topic above its own."""
        return f"{self.interface}/v{self.major}/KIT/0001"

    def connection(self, state: str = "ONLINE") -> Publication:
        """What it says when it connects; see :attr:`last_will`."""
        payload = json.dumps(self._header() | {"connectionState": state}).encode()
        return Publication(f"{self.base}/connection", payload, 1, retain=True)

    @property
    def last_will(self) -> Publication:
        """What the broker says when its connection breaks."""
        return self.connection("CONNECTIONBROKEN" if self.major == 2 else "CONNECTION_BROKEN")

    def factsheet(self) -> Publication:
        """What it says about its make."""
        kind = {"typeSpecification": {"seriesName": "Transporter 7", "localizationTypes": ["NATURAL"]}}
        return Publication(f"{self.base}/factsheet", json.dumps(self._header() | kind).encode(), retain=True)

    def state(self) -> Publication:
        """What it says after each change."""
        return Publication(f"{self.base}/state", json.dumps(self.told()).encode())

    def told(self) -> dict[str, Any]:
        """The state that it tells next."""
        at = {"x": self.x, "y": self.y, "theta": 0.0, "mapId": "ground"}
        nodes = [{key: node[key] for key in ("nodeId", "sequenceId", "released")} for node in self.ahead]
        message = self._header() | {
            "orderId": self.order.get("orderId", ""),
            "orderUpdateId": self.order.get("orderUpdateId", 0),
            "lastNodeId": self.node,
            "lastNodeSequenceId": 0,
            "nodeStates": nodes,
            "edgeStates": [],
            "driving": bool(nodes) and not self.paused,
            "paused": self.paused,
            "actionStates": [action for action in self.actions if self.major == 2 or "instant" not in action],
            "operatingMode": self.mode,
            "errors": self.errors,
        }
        if self.major == 2:
            return message | {
                "agvPosition": at | {"positionInitialized": True},
                "batteryState": {"batteryCharge": self.charge, "charging": self.charging},
                "safetyState": {"eStop": self.stop, "fieldViolation": False},
            }
        return message | {
            "instantActionStates": self.actions,
            "mobileRobotPosition": at | {"localized": True},
            "powerSupply": {"stateOfCharge": self.charge, "charging": self.charging},
            "safetyState": {"activeEmergencyStop": self.stop, "fieldViolation": False},
        }

    def take(self, topic: str, payload: bytes) -> None:
        """Take what homebot publishes, as the standard has it."""
        message = json.loads(payload)
        if topic == f"{self.base}/order":
            self._take_order(message)
        elif topic == f"{self.base}/instantActions":
            for action in message["actions"]:
                self._act(action)

    def drive(self) -> None:
        """Reach the next node of the order."""
        if not self.ahead or self.paused:
            return
        node = self.ahead.pop(0)
        self.node = node["nodeId"]
        self.x, self.y = (node.get("nodePosition", {}).get(axis, getattr(self, axis)) for axis in "xy")
        for action in node["actions"]:
            self._act(action)

    def _take_order(self, order: dict[str, Any]) -> None:
        if order["orderId"] == self.order.get("orderId"):
            return  # sent again
        first, goal = order["nodes"][0], order["nodes"][-1]["nodeId"]
        if self.ahead:
            self._refuse(order, "it has an order")
        elif self.charging:
            self._refuse(order, "it charges")
        elif first["nodeId"] != self.node:
            self._refuse(order, f"it does not stand on {first['nodeId']}")
        elif goal in self.closed:
            self._refuse(order, f"no way to {goal}")
        else:
            self.order, self.ahead, self.errors = order, order["nodes"][1:], []

    def _refuse(self, order: dict[str, Any], why: str) -> None:
        self.refused.append(why)
        about = [{"referenceKey": "orderId", "referenceValue": order["orderId"]}]
        self.errors = [
            {"errorType": "orderError", "errorLevel": "WARNING", "errorDescription": why, "errorReferences": about}
        ]

    def _act(self, action: dict[str, Any]) -> None:
        match action["actionType"]:
            case "startPause" | "stopPause" as kind:
                self.paused = kind == "startPause"
            case "startCharging" | "stopCharging" as kind:
                self.charging = kind == "startCharging"
            case "cancelOrder":
                self.ahead = []
        self.actions.append({"actionId": action["actionId"], "actionStatus": "FINISHED"})

    def _header(self) -> dict[str, Any]:
        self.sent += 1
        minutes, seconds = divmod(self.sent, _SECONDS)
        return {
            "headerId": self.sent,
            "timestamp": f"2026-11-30T10:{minutes % 60:02}:{seconds * 2:02}.000Z",
            "version": f"{self.major}.0.0",
            "manufacturer": "KIT",
            "serialNumber": "0001",
        }
