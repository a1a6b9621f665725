"""The owner's limits of readings: a value outside them is no reading. Pure."""

from collections.abc import Iterable, Mapping
from typing import Annotated, Final, NamedTuple, TypeAlias, final

from pydantic import BaseModel, ConfigDict, Field, field_validator

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import Reading
from homebot.support.folding import fold
from homebot.support.names import did_you_mean

_Number: TypeAlias = Annotated[float, Field(allow_inf_nan=False)]
_Bounds: TypeAlias = tuple[_Number, _Number]

_NUMBERS: Final = frozenset(name for name, capability in CAPABILITIES.items() if capability.kind == "number")


class LimitSettings(BaseModel):
    """The table ``[devices.NAME]``; NAME is the id or a name of a device.

    Attributes:
        limits: The lowest and the highest value of a capability, in its unit; others are no readings.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    limits: dict[str, _Bounds] = Field(default_factory=dict)

    @field_validator("limits")
    @classmethod
    def _are_limits(cls, limits: dict[str, _Bounds]) -> dict[str, _Bounds]:
        for name, (low, high) in limits.items():
            if name not in _NUMBERS:
                hint = did_you_mean(name, _NUMBERS, "`homebot show DEVICE` lists its values")
                raise ValueError(f"{name!r} is no capability with numbers; {hint}")
            if low >= high:
                raise ValueError(f"{name} from {low:g} to {high:g} leaves nothing; the lower limit comes first")
        return limits


class ReadingLimits(NamedTuple):
    """The limits for one device, with the name that the configuration gives it."""

    name: str
    bounds: Mapping[str, _Bounds]

    def problem(self, reading: Reading) -> str:
        """Return why *reading* is none; empty if it is within the limits."""
        bounds, value = self.bounds.get(reading.capability), reading.value.plain()
        if bounds is None or not isinstance(value, float) or bounds[0] <= value <= bounds[1]:
            return ""
        limits = f"{bounds[0]:g} to {bounds[1]:g}"
        said = f"the last had {reading.capability} {value:g}"
        return f"payloads outside the limits {limits} of [devices.{self.name}]: {said}"


@final
class LimitsOfDevices:
    """The limits of all devices.

    Attributes:
        capabilities: The capabilities with limits.
    """

    def __init__(self, tables: Mapping[str, LimitSettings]) -> None:
        self._by_name = {fold(name): ReadingLimits(name, table.limits) for name, table in tables.items()}
        self.capabilities = frozenset(name for table in tables.values() for name in table.limits)

    def of(self, names: Iterable[str]) -> ReadingLimits | None:
        """Return the limits of the device with these *names*; None for none."""
        return next((self._by_name[name] for name in map(fold, names) if name in self._by_name), None)
