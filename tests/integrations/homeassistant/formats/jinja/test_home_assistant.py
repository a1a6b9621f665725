"""Real templates, and one of each form, give the text that Home Assistant 2025.4.4 gave for them.

The answers were recorded by running its template environment; null is an error of its own.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from homebot.integrations.homeassistant.formats.jinja import TemplateError, compile_template

RECORDED = json.loads((Path(__file__).parent / "home_assistant_2025_4_4.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("group", RECORDED, ids=lambda group: group["payload"][:40])
def test_the_texts_are_those_of_home_assistant(group: dict[str, Any]) -> None:
    """The ones that differ are listed, so that one run shows all of them."""
    found = {source: rendered(source, group["payload"]) for source in group["answers"]}
    assert found == group["answers"]


def rendered(source: str, payload: str) -> str | None:
    template = compile_template(source)
    assert template.problem == "", source
    try:
        return template.render_value(payload)
    except TemplateError:
        return None


@pytest.mark.parametrize(
    ("source", "text"),
    [
        # Home Assistant gives the address of a Python method here, or refuses the whole template.
        ("{{ value_json.items }}", "5"),
        ("{{ value_json.update.state }}", "idle"),
        ("{{ value_json['values'] }}", ""),
    ],
)
def test_a_key_is_never_taken_for_a_method(source: str, text: str) -> None:
    assert compile_template(source).render_value('{"items": 5, "update": {"state": "idle"}}') == text
