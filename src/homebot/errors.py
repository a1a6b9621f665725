"""Every error that homebot raises, in one tree, split by how a caller can react.

::

    HomebotError
    ├── UsageError                  our own mistake: fix the program or the configuration
    │   ├── InvalidNameError        a name breaks the rules for names
    │   ├── DuplicateNameError      the name is already taken
    │   ├── TypeMismatchError       a message is not of the type of its topic or service
    │   ├── UnknownTypeError        a message, service or action has no definition
    │   ├── QosError                a QoS profile contradicts itself
    │   ├── ParameterError          a parameter is unknown, read-only or out of its range
    │   ├── ClosedError             the node, topic or connection was closed before
    │   ├── ConfigError             a configuration file, key or value is wrong
    │   └── PluginError             a plug-in cannot be found, loaded or created
    ├── PeerError                   an external peer is wrong or refuses: repeating does not help
    │   ├── WireError               bytes that do not follow their protocol
    │   ├── RefusedError            a login, subscription, publish or command was refused
    │   └── UnableError             a part cannot do that as described; nothing was sent
    ├── LinkError                   the connection to an external peer is down: try again later
    │   ├── BusyError               the peer did not process the request now
    │   ├── UnansweredError         a request was sent but not answered: it may still have an effect
    │   └── CertificateError        the peer has an untrusted certificate
    ├── ExitError                   a component called sys.exit(), which counts as its crash
    ├── AbortError                  a component awaited a cancelled task, or raised an exit exception of Python
    └── ServiceError                a service call got no response
        ├── ServiceUnavailableError no server has this name, or its queue is full
        ├── ServiceFailedError      the server raised
        ├── ServiceGoneError        the server was closed while it worked
        ├── ServiceTimeoutError     the server was too slow
        └── GoalError               a goal of an action ended without success
            ├── GoalRejectedError   the server did not accept the goal
            ├── GoalAbortedError    the server aborted the goal, or forgot it
            └── GoalCanceledError   the goal was cancelled
"""

from collections.abc import Collection, Iterable


class HomebotError(Exception):
    """The base of all errors that homebot raises."""


class UsageError(HomebotError):
    """A mistake in the program or its configuration; the message names the change to make."""


class InvalidNameError(UsageError):
    """A name breaks the rules for its kind of name.

    Attributes:
        position: Index of the first bad character; None if the whole name is wrong.
    """

    def __init__(self, kind: str, name: str, problem: str, position: int | None = None) -> None:
        where = "" if position is None else f" at character {position + 1} ({name[position : position + 1]!r})"
        super().__init__(f"{kind} {name!r} {problem}{where}")
        self.name = name
        self.problem = problem
        self.position = position


class DuplicateNameError(UsageError):
    """A name that must be unique is already taken."""


class TypeMismatchError(UsageError):
    """A message, or an endpoint, is not of the type of its topic or service."""


class UnknownTypeError(UsageError):
    """A message, service or action has no definition."""

    def __init__(self, ros_type: str, kind: str, similar: Collection[str]) -> None:
        hint = f"; similar: {', '.join(similar)}" if similar else ""
        super().__init__(f"unknown {kind} type {ros_type!r}{hint}")
        self.ros_type = ros_type


class QosError(UsageError):
    """A QoS profile contradicts itself."""


class ParameterError(UsageError):
    """A parameter is not declared, declared twice, read-only, of another type, or out of its range."""


class ClosedError(UsageError):
    """A node, topic, service or connection was used after it was closed."""


class ConfigError(UsageError):
    """A configuration cannot be used.

    Attributes:
        source: The file or option from which the value came.
        key: Dotted path of the wrong value, for example ``gateways.mqtt.url``; empty for the whole file.
        reason: The problem and its remedy; begins with a verb if it concerns the whole file.
        others: Further problems.
    """

    def __init__(self, source: str, key: str, reason: str) -> None:
        super().__init__(f"{source}: {key}: {reason}" if key else f"{source} {reason}")
        self.source = source
        self.key = key
        self.reason = reason
        self.others: tuple[ConfigError, ...] = ()

    @classmethod
    def joined(cls, errors: Iterable["ConfigError"]) -> "ConfigError":
        """Return the first of *errors*, with the rest as its others."""
        first, *others = errors
        first.others = tuple(others)
        return first


class PluginError(UsageError):
    """A plug-in cannot be found, loaded or created."""

    def __init__(self, name: str, reason: str) -> None:
        super().__init__(f"plug-in {name!r} {reason}")
        self.name = name


class PeerError(HomebotError):
    """A device, broker or client sent something invalid or refused a request; repeating it fails again."""


class WireError(PeerError):
    """A peer sent bytes that do not follow their protocol.

    Attributes:
        frame: The rejected bytes; at most the first 64 are shown in the message.
    """

    def __init__(self, problem: str, frame: bytes = b"") -> None:
        shown = frame[:64].hex(" ") + (" …" if len(frame) > 64 else "")
        super().__init__(f"{problem} (frame: {shown})" if frame else problem)
        self.problem = problem
        self.frame = frame


class RefusedError(PeerError):
    """A device, broker or gateway refused a request.

    Attributes:
        reason: The reason, for people; never contains a secret.
        code: The protocol's reason code, if there is one.
    """

    def __init__(self, what: str, reason: str, code: int | None = None) -> None:
        super().__init__(f"{what} was refused: {reason}")
        self.what = what
        self.reason = reason
        self.code = code


class WrongCodeError(RefusedError):
    """A device requires a code and got none, or a wrong one. The message never shows it."""

    @classmethod
    def missing(cls, what: str) -> "WrongCodeError":
        """Return the error for a command without a code; it says how to give one."""
        return cls(what, "it needs a code: `homebot do` asks for it with --ask-code, the page has a field")


class UnableError(PeerError):
    """A part cannot carry out a command as described; nothing was sent, and another route may work."""


class LinkError(HomebotError):
    """A connection to a broker or gateway is missing, was lost or timed out; it may work later."""


class BusyError(LinkError):
    """A peer did not process a request, and says that it may work later."""


class UnansweredError(LinkError):
    """A request was sent but not answered: it may still have an effect."""


class CertificateError(LinkError):
    """A peer has an untrusted certificate; nothing was sent."""


class ExitError(HomebotError):
    """A component called ``sys.exit()``, which would have ended all others."""

    def __init__(self, who: str, exit_: SystemExit) -> None:
        super().__init__(f"{who} called sys.exit({exit_.code!r}); to end it, let it return")


class AbortError(HomebotError):
    """A component awaited a cancelled task, or raised an exception reserved to Python; the others continue."""

    def __init__(self, who: str, error: BaseException) -> None:
        # By its name, because this module is independent of the event loop.
        if type(error).__name__ == "CancelledError":
            what = "awaited something that was cancelled; catch asyncio.CancelledError there"
        else:
            what = f"raised {type(error).__name__}; raise a subclass of Exception instead"
        super().__init__(f"{who} {what}")
        self.error = error


class ServiceError(HomebotError):
    """A service call got no response."""

    def __init__(self, service: str, problem: str) -> None:
        super().__init__(f"service {service} {problem}")
        self.service = service


class ServiceUnavailableError(ServiceError):
    """The service has no server, or its queue is full; nothing was done."""

    def __init__(
        self, service: str, problem: str = "has no server; wait for it with `await client.wait_for_service(timeout)`"
    ) -> None:
        super().__init__(service, problem)


class ServiceFailedError(ServiceError):
    """The server raised an exception, which is chained as the cause."""

    def __init__(self, service: str, reason: str) -> None:
        super().__init__(service, f"failed: {reason}")
        self.reason = reason


class ServiceGoneError(ServiceError):
    """The server was closed while it served the call; whether it acted is unknown."""

    def __init__(self, service: str) -> None:
        super().__init__(service, "was closed during the call; whether it acted is unknown")


class ServiceTimeoutError(ServiceError, TimeoutError):
    """The server did not answer in time; whether it acted is unknown.

    Attributes:
        timeout: The limit that passed, in seconds.
    """

    def __init__(self, service: str, timeout: float) -> None:
        super().__init__(service, f"did not answer within {timeout:g} s; whether it acted is unknown")
        self.timeout = timeout


_MAX_REASON = 500


class GoalError(ServiceError):
    """A goal of an action ended without success; ``service`` is the name of the action.

    The text of the result, if it has one, is part of the error's.

    Attributes:
        result: The result message, perhaps partial; None without one.
    """

    def __init__(self, action: str, problem: str, result: object = None) -> None:
        reason = str(getattr(result, "error_msg", "") or getattr(result, "message", ""))[:_MAX_REASON]
        problem = f"{problem}: {reason}" if reason else problem
        super().__init__(action, problem)
        self.args = (f"action {action} {problem}",)
        self.result = result


class GoalRejectedError(GoalError):
    """The server did not accept the goal; nothing was done."""

    def __init__(self, action: str) -> None:
        super().__init__(action, "rejected the goal")


class GoalAbortedError(GoalError):
    """The server aborted the goal, or no longer knows it."""

    def __init__(self, action: str, result: object) -> None:
        super().__init__(action, "aborted the goal", result)


class GoalCanceledError(GoalError):
    """The goal was cancelled."""

    def __init__(self, action: str, result: object) -> None:
        super().__init__(action, "cancelled the goal", result)
