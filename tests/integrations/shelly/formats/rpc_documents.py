"""Answers of Shelly's devices to GetDeviceInfo, GetConfig, GetStatus and GetComponents, as firmware 1.x sends them.

Source: Shelly Gen2+ API, pages of the devices and components; values are made up, and what no part needs is shortened.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ID = "shellyblugwg3-a8032abe54dc"
ANSWERS = f"homebot/{ID}/rpc"
"""Of a gateway, and the topic of its answers."""

Fields = dict[str, Any]


@dataclass(frozen=True)
class Model:
    """One device: its answers, and what homebot is to make of them: parts with their types, and values by part."""

    info: Fields
    config: Fields
    status: Fields
    components: list[Fields]
    parts: dict[str, str]
    values: dict[str, Fields]


_LINES = (Path(__file__).parent / "models.jsonl").read_text().splitlines()
MODELS = {fields.pop("name"): Model(**fields) for fields in map(json.loads, _LINES)}
