"""The parameters of one node: declared, typed, checked, announced.

As in ROS, a parameter must be declared, its type is fixed by its default, and a start-up override replaces the default.
Unlike ROS, a double accepts integers. An empty list fits any array; as a default it declares an array of
strings.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, TypeAlias

from homebot.errors import ParameterError
from homebot.messages.rcl_interfaces import Parameter as ParameterMessage
from homebot.messages.rcl_interfaces import ParameterValue
from homebot.support.isolation import crash_of, error_text
from homebot.support.names import did_you_mean

Value: TypeAlias = bool | int | float | str | bytes | Sequence[bool] | Sequence[int] | Sequence[float] | Sequence[str]
Kind: TypeAlias = Literal["new", "changed"]

PARAMETER_SERVICES: Final = {
    name: f"rcl_interfaces/srv/{name.title().replace('_', '')}"
    for name in (
        "describe_parameters",
        "get_parameter_types",
        "get_parameters",
        "list_parameters",
        "set_parameters",
        "set_parameters_atomically",
    )
}
"""The types of the services, below its node, of each parameter set that is used."""


class ParameterDescriptor(NamedTuple):
    """The constraints on a parameter."""

    description: str = ""
    read_only: bool = False
    minimum: float | None = None
    maximum: float | None = None


class Parameter(NamedTuple):
    """A parameter's name and value."""

    name: str
    value: Value

    def to_message(self) -> ParameterMessage:
        """Return the parameter as a ROS message."""
        return ParameterMessage(name=self.name, value=_to_message_value(self.value))


@dataclass(slots=True)
class _Declared:
    value: Value
    kind: str
    descriptor: ParameterDescriptor


class ParameterSet:
    """The declared parameters of one node.

    Args:
        overrides: Start-up values by name; they replace the defaults at declaration.
        on_event: Called with the parameters that are declared or set together.
        on_failure: Called with the name of a parameter and the exception of its check.
        on_use: Called once, before the first declaration.

    Attributes:
        on_event: As above.
        prepare: Returns the values to set in place of those that are given.
    """

    def __init__(
        self,
        node: str,
        overrides: Mapping[str, Value],
        on_event: Callable[[Kind, Sequence[Parameter]], None],
        on_failure: Callable[[str, Exception], None] = lambda _name, _error: None,
        on_use: Callable[[], None] = lambda: None,
    ) -> None:
        self._node = node
        self._overrides = dict(overrides)
        self.on_event = on_event
        self.prepare: Callable[[Mapping[str, Value]], Mapping[str, Value]] = lambda values: values
        self._on_failure = on_failure
        self._on_use: Callable[[], None] | None = on_use
        self._known: dict[str, _Declared] = {}
        self._checks: list[Callable[[Parameter], str | None]] = []
        self._sources: list[Callable[[], None]] = []

    def declare_later(self, declare: Callable[[], None]) -> None:
        """Call *declare*, which declares parameters, when a parameter is first requested."""
        self._use()
        self._sources.append(declare)

    def declare(self, name: str, default: Value, descriptor: ParameterDescriptor | None = None) -> Parameter:
        """Declare a parameter and return it with its start-up value.

        Raises:
            ParameterError: It is already declared, or the start-up value does not fit.
        """
        if not name or name in self._declared:
            raise ParameterError(f"{self._node}: parameter {name!r} is {'declared already' if name else 'nameless'}")
        declared = _Declared(default, _kind_of(default), descriptor or ParameterDescriptor())
        parameter = Parameter(name, self._fitting(name, declared, self._overrides.get(name, default)))
        self._check(parameter)
        declared.value = parameter.value
        self._use()
        self._declared[name] = declared
        self.on_event("new", (parameter,))
        return parameter

    def has(self, name: str) -> bool:
        """Return whether *name* is declared."""
        return name in self._declared

    def get(self, name: str) -> Parameter:
        """Return the parameter *name*.

        Raises:
            ParameterError: It is not declared.
        """
        return Parameter(name, self._find(name).value)

    def describe(self, name: str) -> tuple[int, ParameterDescriptor]:
        """Return the type number of the parameter *name*, from ``rcl_interfaces/msg/ParameterType``, and its limits."""
        declared = self._find(name)
        return _TYPES.index(declared.kind), declared.descriptor

    def set(self, name: str, value: Value) -> Parameter:
        """Set *name* to a new value and return it; an equal value is not announced.

        Raises:
            ParameterError: It is not declared, read-only, of another type, out of its range, or refused by a check.
        """
        (parameter,) = self.set_atomically({name: value})
        return parameter

    def set_atomically(self, values: Mapping[str, Value]) -> tuple[Parameter, ...]:
        """Set all of *values*, or none of them; otherwise as :meth:`set`."""
        parameters = tuple(self._settable(name, value) for name, value in self.prepare(values).items())
        if changed := [
            parameter for parameter in parameters if parameter.value != self._declared[parameter.name].value
        ]:
            for parameter in changed:
                self._declared[parameter.name].value = parameter.value
            self.on_event("changed", changed)
        return parameters

    def names(self) -> tuple[str, ...]:
        """Return the declared names, sorted."""
        return tuple(sorted(self._declared))

    def add_on_set_callback(self, check: Callable[[Parameter], str | None]) -> None:
        """Call *check* before each change; it returns the reason for a refusal, or None.

        An exception refuses the value.
        """
        self._checks.append(check)

    def _use(self) -> None:
        on_use, self._on_use = self._on_use, None
        if on_use is not None:
            on_use()

    @property
    def _declared(self) -> dict[str, _Declared]:
        while self._sources:
            self._sources.pop(0)()
        return self._known

    def _settable(self, name: str, value: Value) -> Parameter:
        declared = self._find(name)
        if declared.descriptor.read_only:
            hint = "set it before its node starts; settings of gateways and apps are in homebot.toml"
            raise ParameterError(f"{self._node}: parameter {name!r} is read-only; {hint}")
        parameter = Parameter(name, self._fitting(name, declared, value))
        self._check(parameter)
        return parameter

    def _find(self, name: str) -> _Declared:
        try:
            return self._declared[name]
        except KeyError:
            hint = did_you_mean(name[:100], self.names(), f"declared: {', '.join(self.names()) or 'none'}", cutoff=0.7)
            raise ParameterError(f"{self._node}: no parameter {name[:100]!r} is declared; {hint}") from None

    def _fitting(self, name: str, declared: _Declared, value: Value) -> Value:
        value = _convert(value, declared.kind)
        kind = _kind_of(value)
        if kind != declared.kind and not (value == () and declared.kind.endswith("[]")):
            raise ParameterError(
                f"{self._node}: parameter {name!r} is of type {declared.kind}, got the {kind} {value!r}"
            )
        low, high = declared.descriptor.minimum, declared.descriptor.maximum
        if (low, high) != (None, None) and isinstance(value, int | float):
            low = -math.inf if low is None else low
            high = math.inf if high is None else high
            if not low <= value <= high:
                raise ParameterError(
                    f"{self._node}: parameter {name!r} must be from {low:g} to {high:g}, got {value!r}"
                )
        return value

    def _check(self, parameter: Parameter) -> None:
        for check in reversed(self._checks):
            try:
                reason = check(parameter)
            except BaseException as exc:  # noqa: BLE001 - a failing check refuses the value
                crash = crash_of(self._node, exc)
                self._on_failure(parameter.name, crash)
                reason = f"its check failed ({error_text(crash)})"
                raise ParameterError(f"{self._node}: parameter {parameter.name!r} was refused: {reason}") from crash
            if reason is not None:
                raise ParameterError(f"{self._node}: parameter {parameter.name!r} was refused: {reason}")


_KINDS: dict[type, str] = {bool: "bool", int: "integer", float: "double", str: "string", bytes: "byte[]"}
_TYPES = ("not set", "bool", "integer", "double", "string", "byte[]", "bool[]", "integer[]", "double[]", "string[]")
"""The kinds by their number in ``rcl_interfaces/msg/ParameterType``."""


def _convert(value: Value, kind: str) -> Value:
    """Return *value* with lists as tuples, and integers as floats if *kind* is a double."""
    if isinstance(value, list):
        value = tuple(value)
    if kind == "double" and type(value) is int:
        return float(value)
    if kind == "double[]" and isinstance(value, tuple) and {type(item) for item in value} <= {int, float}:
        return tuple(float(item) for item in value)
    return value


def _kind_of(value: Value) -> str:
    if isinstance(value, list | tuple):
        kinds = {_kind_of_one(item) for item in value} or {"string"}
        if len(kinds) == 1 and (kind := kinds.pop()) and kind != "byte[]":
            return f"{kind}[]"
    elif kind := _kind_of_one(value):
        return kind
    raise ParameterError(f"{value!r} cannot be a parameter's value")


def _kind_of_one(value: object) -> str:
    """Return the kind of a single value; empty if it has none, as an integer beyond 64 bits."""
    if type(value) is int and not -(2**63) <= value < 2**63:
        return ""
    return _KINDS.get(type(value), "")


def value_of(message: ParameterValue) -> Value:
    """Return the value in *message*."""
    if not 0 < message.type < len(_TYPES):
        raise ParameterError(f"a value has a type from 1 to 9, got {message.type}; a parameter cannot be unset")
    kind = _TYPES[message.type]
    value = getattr(message, _field_name(kind))
    plain: Value = bytes(value) if kind == "byte[]" else tuple(value) if kind.endswith("[]") else value
    return plain


def _to_message_value(value: Value) -> ParameterValue:
    kind = _kind_of(value)
    plain = tuple(value) if isinstance(value, list) else value
    return ParameterValue.model_validate({"type": _TYPES.index(kind), _field_name(kind): plain})


def _field_name(kind: str) -> str:
    return f"{kind.replace('[]', '_array')}_value"
