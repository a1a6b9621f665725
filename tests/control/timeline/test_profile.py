"""What a profile knows of the routes to a device."""

import pytest

from homebot.control.learnt import Profiles
from homebot.control.timeline.profile import ENOUGH, KEPT, DeviceProfile


def test_a_route_is_ineffective_after_two_commands_in_a_row_and_until_it_works() -> None:
    profile = DeviceProfile()
    profile.learn_routes(["hub", "radio"], "radio")
    profile.learn_routes(["hub", "hub"])
    assert profile.ineffective == {"hub"}
    profile.learn_routes(["radio", "radio", "hub"], "hub")
    assert profile.ineffective == frozenset()
    profile.learn_routes(["hub"])
    profile.learn_routes(["hub"], "hub")
    profile.learn_routes(["hub"])
    assert profile.ineffective == frozenset()


def test_only_news_of_a_route_is_saved() -> None:
    profile = DeviceProfile()
    profile.learn_routes(["hub"], "hub")
    assert not profile.is_changed
    profile.learn_routes(["hub"])
    profile.learn_routes(["hub"])
    profile.is_changed = False
    profile.learn_routes(["hub"])
    assert not profile.is_changed


def test_the_oldest_of_many_routes_is_forgotten() -> None:
    profile = DeviceProfile()
    profile.learn_routes([str(number) for number in range(KEPT + 1)])
    assert set(profile.failures) == {str(number) for number in range(1, KEPT + 1)}


def test_an_ineffective_route_is_known_after_a_restart() -> None:
    saved: dict[str, str] = {}
    before, after = (Profiles(lambda name, record: saved.update({name: record})) for _ in range(2))
    before.of("lamp").failures = {"hub": 2}
    before.of("lamp").is_changed = True
    before.save("lamp", before.of("lamp"))
    after.restore("lamp", saved["lamp"])
    assert after.of("lamp").ineffective == {"hub"}


def test_timers_and_parts_that_change_along_are_known_after_a_restart() -> None:
    saved: dict[str, str] = {}
    before, after = (Profiles(lambda name, record: saved.update({name: record})) for _ in range(2))
    for _ in range(ENOUGH):
        before.of("lamp").learn_stay("on_off", value=True, seconds=60.0)
        before.of("lamp").learn_pair("group", is_missed=False)
    before.save("lamp", before.of("lamp"))
    after.restore("lamp", saved["lamp"])
    assert after.of("lamp").learn_stay("on_off", value=True, seconds=60.0) == ENOUGH
    assert after.of("lamp").learn_stay("on_off", value=False, seconds=60.0) == 0
    assert after.of("lamp").learn_pair("group", is_missed=False)


def test_a_timer_may_be_long_and_end_a_number() -> None:
    """Times of an hour differ by more than half a second, as clocks drift."""
    profile = DeviceProfile()
    for count in range(ENOUGH + 1):
        assert profile.learn_stay("on_off", value=True, seconds=3600.0 + count) == count
        assert profile.learn_stay("level", value=40.0, seconds=60.0) == count
    assert profile.learn_stay("on_off", value=True, seconds=3700.0) == 0
    assert profile.learn_stay("color", value=(0.0, 100.0), seconds=60.0) == 0


@pytest.mark.parametrize(("seconds", "is_timer"), [(20.0, False), (60.0, False), (300.0, True), (1800.0, True)])
def test_a_long_timer_is_known_though_persons_are_often_sooner(seconds: float, *, is_timer: bool) -> None:
    """Half a second is hit by chance the seldomer the longer a value lasts."""
    profile, count = DeviceProfile(), 0
    for number in range(12):
        count = profile.learn_stay("on_off", value=True, seconds=seconds)
        for share in (0.1, 0.3):
            profile.learn_stay("on_off", value=True, seconds=seconds * share + 7.0 * number)
    assert (count >= ENOUGH) == is_timer


def test_answers_of_this_run_outlast_records_that_are_read_late() -> None:
    saved: dict[str, str] = {}
    before, after = (Profiles(lambda name, record: saved.update({name: record})) for _ in range(2))
    for profiles, answer in ((before, 48.0), (after, 49.0)):
        profiles.of("lamp").answers["level"] = [(50.0, answer)]
    before.of("lamp").is_changed = True
    before.save("lamp", before.of("lamp"))
    after.restore("lamp", saved["lamp"])
    assert after.of("lamp").answers["level"] == [(50.0, 49.0)]
