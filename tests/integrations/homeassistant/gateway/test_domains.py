"""Entities of each domain, as parts and values: ``entities.jsonl`` has a line per domain.

In ``capabilities``, ``r`` marks a readable capability, ``w`` a settable one, ``e`` an echo.
"""

import json
from pathlib import Path
from typing import Any

import pytest
from tests.integrations.homeassistant.gateway.test_entities import home, state

from homebot.integrations.homeassistant.formats.states.domains import DOMAINS

LINES = [json.loads(line) for line in Path(__file__).with_name("entities.jsonl").read_text().splitlines()]


def test_every_domain_has_its_line() -> None:
    assert [line["domain"] for line in LINES] == list(DOMAINS)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line["domain"])
def test_an_entity_is_described_and_its_state_is_read(line: dict[str, Any]) -> None:
    entities = home()
    entities.put(f"{line['domain']}.one", state(line["state"]) | {"a": line["attributes"]}, is_new=True)
    ((entity,),) = entities.regroup().values()
    part = entity.part()
    assert part.service_type == line["type"]
    capabilities = {}
    for one in part.capabilities:
        flags = zip("rwe", (one.readable, one.settable, one.echoed), strict=True)
        further = {key: value for key in ("unit", "bounds", "options") if (value := getattr(one, key))}
        capabilities[one.name] = ["".join(flag for flag, is_set in flags if is_set), *([further] if further else [])]
    assert json.loads(json.dumps(capabilities)) == line["capabilities"]
    assert json.loads(json.dumps(dict(entity.read(is_change=True)))) == line["values"]
