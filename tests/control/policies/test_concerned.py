"""Which policies concern a part is remembered, and forgotten as soon as anything changes that they look at."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.policies.houses import make_command, make_device, make_facts
from tests.generated_examples import examples

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.control.command import IssuedCommand
from homebot.control.policies import Facts, Policies, Verdict
from homebot.control.policies.approval import judge_approval
from homebot.control.policies.grants import judge_grants
from homebot.control.policies.interlock import InterlockRule, judge_interlocks
from homebot.control.policies.presence_guard import judge_presence
from homebot.control.policies.quiet_hours import judge_quiet_hours

TABLE: dict[str, object] = {
    "presence_guard": {"commands": ["turn off in hall", "turn off on lights", "use stale plugs"]},
    "quiet_hours": [
        {"start": "00:00", "end": "23:59", "commands": ["turn on lamp name=one", "use not fresh and not open"]}
    ],
    "interlocks": [{"commands": ["use tag=fragile", "use reachable locks"], "while": "open contact sensor"}],
}
SETTINGS = parse_settings(ControlSettings, TABLE, "homebot.toml", "control")

VALUES: dict[str, tuple[object, ...]] = {
    "kind": ("light", "plug", "door_lock"),
    "room": ("hall", "bath", ""),
    "name": ("Lamp one", "Oven", ""),
    "tags": ((), ("fragile",), ("always_ask",)),
    "is_approved": (True, False),
    "freshness": ("fresh", "stale", "unconfirmed"),
    "on": (True, False, None),
    "wanted": (True, False),
    "issuer": ("/app", "client:local"),
    "scope": (("act: all",), (), ("act: light in hall",), ("act: on plug",)),
}
CHANGES = st.lists(
    st.sampled_from(sorted(VALUES)).flatmap(lambda name: st.tuples(st.just(name), st.sampled_from(VALUES[name]))),
    min_size=1,
    max_size=12,
)


def command_of(facts: dict[str, Any]) -> IssuedCommand:
    device = make_device(
        "it",
        facts["kind"],
        room=facts["room"],
        settable=("on_off",),
        freshness=facts["freshness"],
        values={} if facts["on"] is None else {"on_off": facts["on"]},
        approved="digest" if facts["is_approved"] else "",
    )
    device = device.model_copy(update={"name": facts["name"], "tags": facts["tags"]})
    return make_command(device, {"on_off": facts["wanted"]}, facts["issuer"], facts["scope"])


def refusal(command: IssuedCommand, facts: Facts) -> Verdict | None:
    """Return the first refusal where every policy is asked."""
    guard = SETTINGS.presence_guard
    assert guard is not None
    asked = (
        judge_grants(SETTINGS.approvals, command, facts),
        judge_approval(command, facts),
        judge_interlocks(map(InterlockRule.of, SETTINGS.interlocks), command, facts),
        judge_quiet_hours(SETTINGS.quiet_hours, command, facts),
        judge_presence(guard, command, facts),
    )
    return next((one for one in asked if not one.allowed), None)


@settings(max_examples=examples(200), deadline=None)
@given(CHANGES)
def test_to_ask_those_concerned_is_to_ask_all(changes: list[tuple[str, object]]) -> None:
    """Also when one thing after the other changes of a device whose concerned policies are known."""
    policies = Policies(SETTINGS)
    facts = make_facts(make_device("window", "contact_sensor", room="hall", values={"contact": False}))
    now: dict[str, Any] = {name: values[0] for name, values in VALUES.items()}
    for name, value in (("on", True), *changes):
        now[name] = value
        command = command_of(now)
        last = policies.judge(command, facts)[-1]
        assert (None if last.allowed else last) == refusal(command, facts)
