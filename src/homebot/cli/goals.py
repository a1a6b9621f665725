"""Goals of commands: feedback is shown as it comes, and Ctrl-C cancels."""

from collections.abc import Callable, Iterable, Mapping
from typing import Final

from homebot.cli.door_client import DoorClient, ReceivedMessage
from homebot.cli.remarks import remark
from homebot.errors import PeerError
from homebot.support.printable import printable

_CANCEL_WITHIN: Final = 25.0
_WIDEST: Final = 1000


def perform_goal(
    door: DoorClient,
    action: str,
    ros_type: str,
    goal: Mapping[str, object],
    on_feedback: Callable[[Mapping[str, object]], None],
) -> Mapping[str, object]:
    """Send *goal*, and return its result. After Ctrl-C, it is cancelled, and its end is printed.

    Raises:
        PeerError: It was refused, or failed without a result.
    """
    identifier = door.send_goal(action, ros_type, goal)
    try:
        return _result(iter(door.next, None), on_feedback)
    except KeyboardInterrupt:
        door.cancel_goal(action, identifier)
        values = _result(door.until(_CANCEL_WITHIN), lambda _: None)
        remark(printable(str(values.get("message", "not cancelled yet")), _WIDEST), as_json=door.as_json)
        raise


def _result(
    received: Iterable[ReceivedMessage], on_feedback: Callable[[Mapping[str, object]], None]
) -> Mapping[str, object]:
    for _, frame, _ in received:
        values = frame.get("values")
        if not isinstance(values, dict):
            raise PeerError(f"the goal failed: {values}")
        if frame["op"] == "action_result":
            return values
        on_feedback(values)
    return {}
