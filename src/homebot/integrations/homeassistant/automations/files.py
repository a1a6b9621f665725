"""Parts of automations in other files: ``!include``, ``!secret`` and blueprints. Pure, but for the given loader.

Source: Home Assistant core 2026.11, ``util/yaml/loader.py`` and ``components/blueprint``.
"""

from contextlib import suppress
from typing import Final

from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.variables import replaced
from homebot.support.located import Located
from homebot.words.automations import Load


def with_files(document: Located, load: Load | None) -> Located:
    """Return *document* with the values of other files in it, as far as *load* finds them."""
    if load is None:
        return document

    def included(node: Located) -> Located:
        try:
            return load(str(node.value))._replace(line=node.line)
        except UsageError:
            return node._replace(tag="!include ")  # it is named where it is used

    def secret(node: Located) -> Located:
        try:
            secrets = load("secrets.yaml").value
        except UsageError:
            secrets = None
        known = secrets.get(str(node.value)) if isinstance(secrets, dict) else None
        return node._replace(tag="!secret ") if known is None else known._replace(line=node.line)

    return replaced(replaced(document, "!include", included), "!secret", secret)


def part_of(document: Located, key: str, load: Load | None) -> dict[str, Located]:
    """Return what a configuration has under *key*, such as ``script``, else the file beside it, by name."""
    part = document.value.get(key) if isinstance(document.value, dict) else None
    if part is None and load is not None:
        with suppress(UsageError):  # a house may have none
            part = with_files(load(f"{key}s.yaml"), load)
    return part.value if part is not None and isinstance(part.value, dict) and not part.tag else {}


def groups_of(document: Located, load: Load | None) -> dict[str, list[str]]:
    """Return the members of the groups of a configuration that are on if any of these is, by the ids of the groups.

    Source: Home Assistant core 2026.11, ``components/group``.
    """
    groups: dict[str, list[str]] = {}
    for name, node in part_of(document, "group", load).items():
        fields = UnreadFields(node if isinstance(node.value, dict) else Located({"entities": node}, node.line), "group")
        with suppress(NotCarriedError):
            if not fields.flag("all", default=False):
                groups[f"group.{name}"] = fields.texts("entities")
    return groups


def from_blueprint(node: Located, blueprint: Located | None, load: Load | None) -> Located:
    """Return the automation that a blueprint makes with the inputs in *node*.

    Raises:
        NotCarriedError: The blueprint is not given, or an input is missing.
    """
    fields = UnreadFields(node, "automation")
    use = fields.inner("use_blueprint")
    path, inputs = use.text("path", ""), use.inner("input").left
    if blueprint is None and load is not None:
        try:
            blueprint = load(f"blueprints/automation/{path}")
        except UsageError:
            blueprint = None
    if blueprint is None and path in _SHIPPED:
        blueprint = _located(_SHIPPED[path])
    if blueprint is None:
        raise NotCarriedError(f"the blueprint {path!r}: give its file, `homebot routine import … --blueprint FILE`")
    if not isinstance(blueprint.value, dict) or "blueprint" not in blueprint.value:
        raise NotCarriedError(f"the blueprint {path!r}: its file has no key `blueprint`")
    own = dict(blueprint.value)
    defaults = _defaults(own.pop("blueprint"))

    def value_of(tagged: Located) -> Located:
        name = str(tagged.value)
        if (given := inputs.get(name, defaults.get(name))) is None:
            raise NotCarriedError(f"the blueprint {path!r}: its input {name!r} is missing")
        return given

    whole = replaced(Located(own, node.line), "!input", value_of)
    kept = {key: value for key, value in fields.left.items() if key != "use_blueprint"}
    return _at_line(Located({**whole.value, **kept}, node.line), node.line) if isinstance(whole.value, dict) else whole


_MOTION: Final = {"trigger": "state", "entity_id": Located("motion_entity", 0, "!input")}
_LIGHT: Final = {"target": Located("light_target", 0, "!input")}
_LIGHT_BY_MOTION: Final = {
    "blueprint": {"input": {"motion_entity": {}, "light_target": {}, "no_motion_wait": {"default": 120}}},
    "mode": "restart",
    "triggers": [{**_MOTION, "from": "off", "to": "on"}],
    "actions": [
        {"action": "light.turn_on", **_LIGHT},
        {"wait_for_trigger": {**_MOTION, "from": "on", "to": "off"}},
        {"delay": Located("no_motion_wait", 0, "!input")},
        {"action": "light.turn_off", **_LIGHT},
    ],
}
_LEFT_ZONE: Final = {
    "blueprint": {"input": {"person_entity": {}, "zone_entity": {}, "notify_device": {}}},
    "variables": {"left": Located("zone_entity", 0, "!input")},
    "triggers": {
        "trigger": "zone",
        "event": "leave",
        "entity_id": Located("person_entity", 0, "!input"),
        "zone": Located("zone_entity", 0, "!input"),
    },
    "actions": {
        "action": "notify.notify",
        "data": {"message": "{{ trigger.to_state.name }} has left {{ left[5:] }}"},
    },
}
_SHIPPED: Final = {
    "homeassistant/motion_light.yaml": _LIGHT_BY_MOTION,
    "homeassistant/notify_leaving_zone.yaml": _LEFT_ZONE,
}
"""The blueprints that each Home Assistant has from the start."""


def _located(value: object) -> Located:
    if isinstance(value, Located):
        return value
    if isinstance(value, dict):
        return Located({key: _located(inner) for key, inner in value.items()}, 0)
    return Located([_located(inner) for inner in value] if isinstance(value, list) else value, 0)


def _defaults(head: Located) -> dict[str, Located]:
    """Return the defaults of the inputs in the head of a blueprint, also of those in sections."""
    found: dict[str, Located] = {}
    inputs = head.value.get("input") if isinstance(head.value, dict) else None
    for name, node in inputs.value.items() if inputs is not None and isinstance(inputs.value, dict) else ():
        if not isinstance(node.value, dict):
            continue
        if "input" in node.value:
            found |= _defaults(node)
        elif "default" in node.value:
            found[name] = node.value["default"]
    return found


def _at_line(node: Located, line: int) -> Located:
    """Return *node* as if all of it stood in *line*, that of the automation that uses it."""
    value = node.value
    if isinstance(value, dict):
        value = {key: _at_line(inner, line) for key, inner in value.items()}
    elif isinstance(value, list):
        value = [_at_line(inner, line) for inner in value]
    return Located(value, line, node.tag)
