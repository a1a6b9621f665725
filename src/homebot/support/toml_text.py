"""Values as TOML. Pure.

Source of the syntax: TOML 1.0, https://toml.io/en/v1.0.0.
"""

import json
import re
from collections.abc import Mapping
from typing import Final

_BARE: Final = re.compile(r"[A-Za-z0-9_-]+")


def toml_value(value: object) -> str:
    """Return a text, number, truth value, sequence or mapping as TOML on one line."""
    match value:
        case str():
            text = value.encode(errors="replace").decode()  # a lone surrogate is not text
            return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")  # TOML allows no raw DEL
        case bool():
            return str(value).lower()
        case list() | tuple():
            return f"[{', '.join(map(toml_value, value))}]"
        case Mapping():
            return f"{{ {', '.join(f'{_key(str(key))} = {toml_value(item)}' for key, item in value.items())} }}"
        case _:
            return repr(value)


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else toml_value(name)
