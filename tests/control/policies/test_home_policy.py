"""Policies of other packages: the name of their table, what they need, and what happens if one fails."""

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.control.policies.houses import make_command, make_device, make_facts

from homebot.control import ControlSettings
from homebot.control.command import IssuedCommand
from homebot.control.policies import Facts, HomePolicy, Verdict
from homebot.control.policy_engine import Policies
from homebot.devices.query.terms import CanDo, Or

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


Install = Callable[[str, str], ControlSettings]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Install a package that offers a policy under a name; return settings with its table."""
    monkeypatch.syspath_prepend(tmp_path)

    def settings(name: str, kind: str) -> ControlSettings:
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[homebot.policies]\n{name} = {kind}\n")
        return ControlSettings.model_validate({"policies": {name: {}}})

    return settings


def test_a_refusal_has_the_name_of_the_table(install: Install) -> None:
    policies = Policies(install("dark", f"{__name__}:Dark"))
    last = policies.check(LAMP, make_facts())[-1]
    assert last == Verdict("dark", allowed=False, reason="it is to be dark")


def test_the_house_is_followed_for_what_it_needs(install: Install) -> None:
    read = install("dark", f"{__name__}:Dark")
    assert read.needs_house
    assert Policies(read).needs == Or((CanDo("illuminance"),))


def test_one_that_fails_refuses_and_is_logged_once(install: Install, caplog: pytest.LogCaptureFixture) -> None:
    policies = Policies(install("broken", f"{__name__}:Broken"))
    for _ in range(3):
        last = policies.check(LAMP, make_facts())[-1]
        assert last == Verdict("broken", allowed=False, reason="the policy failed: KeyError: 'lamp'")
    assert [one.getMessage() for one in caplog.records] == [
        "the policy broken failed, and refuses every command that it checks"
    ]
    assert caplog.records[0].exc_info is not None


def test_what_is_no_policy_or_not_installed_is_refused(install: Install) -> None:
    with pytest.raises(ValueError, match="int is not a HomePolicy"):
        install("number", "builtins:int")
    with pytest.raises(ValueError, match=r"no installed package offers the policy 'x\.py:Evil'"):
        ControlSettings.model_validate({"policies": {"x.py:Evil": {}}})
