"""No policy is ever violated by a command that was sent: random houses, people, times and commands."""

from datetime import UTC, datetime

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.policies.houses import START, make_command, make_device, make_facts
from tests.sizes import examples

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.control.policy_engine import Policies
from homebot.devices import Device

ROOMS = ("hall", "bath", "")
TABLE: dict[str, object] = {
    "presence_guard": {"absent_after": 60},
    "quiet_hours": [{"start": "22:00", "end": "06:30", "commands": ["turn on plugs"]}],
    "interlocks": [{"commands": ["heat"], "while": "open contact sensor"}],
}
POLICIES = Policies(parse_settings(ControlSettings, TABLE, "homebot.toml", "control"))

FRESHNESS = st.sampled_from(["fresh", "stale", "unconfirmed"])
SENSORS = st.builds(
    lambda kind, room, value, freshness, is_live, age: (kind, room, value, freshness, is_live, age),
    st.sampled_from(["motion", "contact"]),
    st.sampled_from(ROOMS),
    st.sampled_from([True, False, None]),
    FRESHNESS,
    st.booleans(),
    st.floats(0, 200),
)
COMMANDS = st.sampled_from(
    [
        ("light", "on_off", True),
        ("light", "on_off", False),
        ("light", "level", 0.0),
        ("light", "level", 30.0),
        ("plug", "on_off", True),
        ("plug", "on_off", False),
        ("thermostat", "heating_setpoint", 22.0),
        ("door_lock", "lock", "unlocked"),
    ]
)


@settings(max_examples=examples(500), deadline=None)
@given(st.lists(SENSORS, max_size=5), COMMANDS, st.sampled_from(ROOMS), st.floats(0, 86_400))
def test_what_is_allowed_violates_no_policy(
    sensors: list[tuple[str, str, bool | None, str, bool, float]],
    wanted: tuple[str, str, bool | float | str],
    room: str,
    second: float,
) -> None:
    now = START + second
    house: list[Device] = []
    for number, (kind, where, value, freshness, is_live, age) in enumerate(sensors):
        service_type, capability = (
            ("occupancy_sensor", "occupancy") if kind == "motion" else ("contact_sensor", "contact")
        )
        house.append(
            make_device(
                f"{kind}{number}",
                service_type,
                room=where,
                freshness=freshness,  # type: ignore[arg-type]
                is_live=is_live,
                since=now - age,
                values={capability: value},
            )
        )
    kind, capability, setting = wanted
    device = make_device("it", kind, room=room, settable=(capability,))
    verdict = POLICIES.check(make_command(device, {capability: setting}), make_facts(*house, now=now))[-1]
    assert verdict.allowed or verdict.reason
    if not verdict.allowed:
        return
    beside = [one for one in sensors if one[1] == room]
    is_off = kind in {"light", "plug"} and setting in (False, 0.0)
    if is_off:  # all sensors of its room are alive and have been quiet for a minute
        motion = [one for one in beside if one[0] == "motion"]
        assert room
        assert motion
        assert all(one[2:5] == (False, "fresh", True) and one[5] > 59.9 for one in motion)
    if kind == "thermostat":
        assert room
        assert all(one[2:5] == (False, "fresh", True) for one in beside if one[0] == "contact")
    if kind == "plug" and setting is True:
        local = datetime.fromtimestamp(now, UTC).time()
        assert datetime(2027, 1, 1, 6, 30, tzinfo=UTC).time() <= local < datetime(2027, 1, 1, 22, tzinfo=UTC).time()
    assert kind != "door_lock"
