"""Messages of real products, in ``NAME/formats/real_devices.jsonl``; ``real_devices.md`` says where lines come from."""

import json
from pathlib import Path
from typing import Any

_NAME = "formats/real_devices.jsonl"


def announcing() -> list[str]:
    """The conventions of which there are real products."""
    return sorted(file.parents[1].name for file in Path(__file__).parent.glob(f"*/{_NAME}"))


def rows_of(convention: str) -> list[dict[str, Any]]:
    """The real devices that are known to speak *convention*."""
    lines = (Path(__file__).parent / convention / _NAME).read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]
