"""Numbers with units, changes by them, and yes or no. Pure."""

import re
from typing import Final, NamedTuple

FLAGS: Final = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}
"""The words for a value that is true or false."""


class Amount(NamedTuple):
    """A number as text, with a unit that is perhaps empty."""

    number: str
    unit: str


_AMOUNT: Final = re.compile(r"([+-]?(?:\d{1,15}(?:\.\d{1,15})?|\.\d{1,15}))\s*(\D*)", re.ASCII)
_SYMBOLS: Final = (
    *("%", "K", "°C", "C", "°F", "F", "W", "mW", "kW", "Wh", "kWh", "MWh", "V", "mV", "A", "mA", "Hz", "dB", "dBm"),
    *("lx", "hPa", "kPa", "Pa", "mbar", "bar", "ppm", "ppb", "µg/m³", "m³/h", "l/min", "m/s", "km/h", "kg"),
)
UNITS: Final = {
    **{symbol: symbol for symbol in _SYMBOLS},
    **dict.fromkeys(("percent", "per cent"), "%"),
    **dict.fromkeys(("°", "degree", "degrees", "celsius"), "°C"),
    "fahrenheit": "°F",
    **dict.fromkeys(("k", "kelvin"), "K"),
    **dict.fromkeys(("watt", "watts"), "W"),
    **dict.fromkeys(("volt", "volts"), "V"),
}
"""Units that may follow a number, also by name. A capability has one, and any other is refused rather than ignored."""


def read_amount(text: str) -> Amount | None:
    """Return the number *text*, such as ``21``, ``-0.5`` or ``21 °C``; None if it is none."""
    found = _AMOUNT.fullmatch(text)
    if found is None:
        return None
    unit = found[2]
    return Amount(found[1], UNITS.get(unit) or UNITS.get(unit.casefold(), unit))


class Change(NamedTuple):
    """A change of a value.

    Attributes:
        before: The words before it, such as the name of the value; perhaps empty.
        sign: ``+`` or ``-``.
    """

    before: str
    sign: str
    amount: str


_CHANGE: Final = re.compile(r"(?P<before>.* )?(?P<sign>[+-]) ?(?P<amount>[\d.]++ ?(?:per cent|\S*))")
_BRIGHTER: Final = re.compile(r"(?P<word>brighter|darker)(?: by)?(?: (?P<amount>\d.*))?", re.IGNORECASE)
_USUAL_CHANGE: Final = "20 %"
_COMMA: Final = re.compile(r",(?! ?[\d.]+ ?(?:,|$))")
"""Not that between the hue and the saturation of a colour."""


def read_change(text: str) -> Change | None:
    """Return the change *text*, such as ``+10 %``, ``level -5`` or ``darker``; None if it is none."""
    if (word := _BRIGHTER.fullmatch(text)) is not None:
        text = f"{'+' if word['word'].casefold() == 'brighter' else '-'}{word['amount'] or _USUAL_CHANGE}"
    found = _CHANGE.fullmatch(text)
    return Change(found["before"] or "", found["sign"], found["amount"]) if found else None


def split_commands(text: str) -> list[str]:
    """Return the commands in ``on, 40 %``."""
    return [command.strip() for command in _COMMA.split(text)]
