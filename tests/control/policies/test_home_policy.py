"""Policies of other packages: the name of their table, what they need, and what happens if one fails."""

from __future__ import annotations

import pytest
from tests.control.policies.houses import make_command, make_device, make_facts

from homebot.control import ControlSettings
from homebot.control.command import IssuedCommand
from homebot.control.policies import Facts, HomePolicy, Policies, Verdict, home_policy
from homebot.devices.query import CanDo, Or

LAMP = make_command(make_device("lamp", "light", settable=("on_off",)), {"on_off": True})


class Dark(HomePolicy):
    """Refuses what turns on, under another name."""

    needs = CanDo("illuminance")

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        del facts
        return Verdict("approval", allowed=command.settings["on_off"] is False, reason="it is to be dark")


class Broken(HomePolicy):
    """Fails."""

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        del facts
        raise KeyError(command.device.id)


def settings(monkeypatch: pytest.MonkeyPatch, name: str, kind: type[object]) -> ControlSettings:
    """Settings in which the policy *name* is the installed class *kind*."""
    monkeypatch.setattr(home_policy, "has_plugin", lambda group, one: (group, one) == ("homebot.policies", name))
    monkeypatch.setattr(home_policy, "load_plugin", lambda _group, _name: kind)
    return ControlSettings.model_validate({"policies": {name: {}}})


def test_a_refusal_has_the_name_of_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    policies = Policies(settings(monkeypatch, "dark", Dark))
    last = policies.check(LAMP, make_facts())[-1]
    assert last == Verdict("dark", allowed=False, reason="it is to be dark")


def test_the_house_is_followed_for_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    read = settings(monkeypatch, "dark", Dark)
    assert read.needs_house
    assert Policies(read).needs == Or((CanDo("illuminance"),))


def test_one_that_fails_refuses_and_is_logged_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    policies = Policies(settings(monkeypatch, "broken", Broken))
    for _ in range(3):
        last = policies.check(LAMP, make_facts())[-1]
        assert last == Verdict("broken", allowed=False, reason="the policy failed: KeyError: 'lamp'")
    assert [one.getMessage() for one in caplog.records] == [
        "the policy broken failed, and refuses every command that it checks"
    ]
    assert caplog.records[0].exc_info is not None


def test_what_is_no_policy_or_not_installed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="int is not a HomePolicy"):
        settings(monkeypatch, "number", int)
    monkeypatch.undo()
    with pytest.raises(ValueError, match=r"no installed package offers the policy 'x\.py:Evil'"):
        ControlSettings.model_validate({"policies": {"x.py:Evil": {}}})
