"""Models of Shelly BLU, which broadcast BTHome. A table, pure.

Source: Shelly BLU, Common, table of models; BluTRV and Ecowitt WS90, tables of BTHome objects.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from homebot.conventions.bthome.objects import BTHOME_OBJECTS, BTHomeObject

__all__ = ["MODELS", "BluModel", "model_called"]


class BluModel(NamedTuple):
    """A model.

    Attributes:
        code: The name that it advertises.
        keys: Number of its buttons.
        has_wheel: Whether it can be turned.
        objects: Its objects with another meaning, by their usual part.
    """

    code: str
    name: str
    keys: int = 1
    has_wheel: bool = False
    objects: Mapping[str, BTHomeObject] = MappingProxyType({})

    def name_at(self, address: str) -> str:
        """Return the name of a device with that *address* that has no other."""
        return f"{self.name} {address[-5:].replace(':', '').upper()}"

    @property
    def facts(self) -> dict[str, str]:
        """Facts of its devices; none for an unknown model."""
        return {"manufacturer": "Shelly", "model": self.name, "model_id": self.code} if self.code else {}


_VALVE: Final = {
    "temperature": BTHomeObject("target_temperature", "heating_setpoint"),
    "temperature_2": BTHOME_OBJECTS[0x02],
    "temperature_3": BTHomeObject("external_temperature", "temperature"),
}
_WEATHER: Final = {"water_leak": BTHomeObject("rain", "state")}

MODELS: Final[Mapping[int, BluModel]] = {
    1: BluModel("SBBT-002C", "BLU Button1"),
    2: BluModel("SBDW-002C", "BLU Door/Window", keys=0),
    3: BluModel("SBHT-003C", "BLU H&T"),
    4: BluModel("SBDI-003E", "BLU Distance"),
    5: BluModel("SBMO-003Z", "BLU Motion"),
    6: BluModel("SBBT-004CEU", "BLU Wall Switch 4", keys=4),
    7: BluModel("SBBT-004CUS", "BLU RC Button 4", keys=4),
    8: BluModel("SBTR-001AEU", "BLU TRV", keys=0, objects=_VALVE),
    9: BluModel("SBRC-005B", "BLU Remote", keys=2, has_wheel=True),
    11: BluModel("SBWS-90CM", "Ecowitt WS90", keys=0, objects=_WEATHER),
    12: BluModel("SBHT-103C", "BLU H&T Display ZB"),
    17: BluModel("SBHT-203C", "BLU H&T ZB"),
    19: BluModel("SBMO-103Z", "BLU Motion ZB"),
    20: BluModel("SBDW-103C", "BLU Door/Window ZB", keys=0),
    21: BluModel("SBBT-104CEU", "BLU Wall Switch 4 ZB", keys=4),
    22: BluModel("SBBT-104CUS", "BLU RC Button 4 ZB", keys=4),
    23: BluModel("SBBT-102C", "BLU Button Tough 1 ZB"),
}
"""By the number of the model in its broadcasts."""

_OTHER: Final = BluModel("", "Bluetooth device")
_BY_CODE: Final = {model.code: model for model in MODELS.values()}


def model_called(code: str) -> BluModel:
    """Return the model that advertises the name *code*; one without a code if it is unknown."""
    return _BY_CODE.get(code, _OTHER)
