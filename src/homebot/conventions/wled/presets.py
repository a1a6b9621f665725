"""The presets and playlists of a WLED controller: their names, and which of them it shows. Pure.

Source: WLED, https://kno.wled.ge/features/presets and /interfaces/json-api; ``/presets.json`` of 0.13 to 16.
"""

from __future__ import annotations

from collections.abc import Mapping

from homebot.conventions.payload import as_fields, clean_text

__all__ = ["preset_names", "shown_preset"]

_MOST = 250
_LONGEST = 60


def preset_names(document: object) -> dict[int, str]:
    """Return the names of the presets and playlists by number, each name once; of two, the later has its number too.

    Args:
        document: The answer to ``/presets.json``: objects by number. The one of 0 is none.
    """
    names: dict[int, str] = {}
    for key, fields in as_fields(document).items():
        if not (isinstance(fields, dict) and key.isascii() and key.isdecimal() and 0 < int(key[:4]) <= _MOST):
            continue
        own = fields.get("n")
        name = clean_text(own, _LONGEST) if isinstance(own, str) and own.strip() else f"Preset {key}"
        names[int(key)] = f"{name} ({key})" if name in names.values() else name
    return names


def shown_preset(state: Mapping[str, object], names: Mapping[int, str]) -> str | None:
    """Return the name of the playlist that runs, or else of the preset that was chosen last; None if none was."""
    for field in ("pl", "ps"):
        number = state.get(field)
        if isinstance(number, int) and number in names:
            return names[number]
    return None
