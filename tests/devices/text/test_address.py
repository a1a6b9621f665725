"""Where a device is told a word."""

from homebot.devices import Device, DevicePart, Endpoint, Route
from homebot.devices.names import text_address
from homebot.devices.part import Capability, Part
from homebot.devices.text.commands import command_address, others_at
from homebot.messages import Time

OWN, OTHER = text_address("own", "state"), text_address("other", "x")
NEVER = Time(sec=0, nanosec=0)


def lamp(*routes: Route) -> Device:
    """A lamp that can be dimmed; nobody knows by which way."""
    capabilities = (Capability(name="on_off", settable=True), Capability(name="level", settable=True))
    part = Part(id="state", service_type="light", capabilities=capabilities)
    return Device(
        id="lamp",
        name="Lamp",
        service_type="light",
        endpoints=(Endpoint(gateway="mqtt", key="own", address=OWN, command_address=OWN),),
        metadata=(),
        first_seen=NEVER,
        last_seen=NEVER,
        expires=NEVER,
        freshness="fresh",
        parts=(DevicePart(id="state", part=part, routes=routes),),
    )


def at(device: Device, said: str) -> str:
    return command_address(device, device.endpoints[0], said)


def test_a_text_goes_by_the_route_that_accepts_its_command() -> None:
    """Of its gateway; a word that means nothing is for that to refuse."""
    device = lamp(
        Route(gateway="mqtt", key="own", part="state", takes=("on_off",)),
        Route(gateway="far", key="far", part="y"),
        Route(gateway="mqtt", key="other", part="x"),
    )
    assert [at(device, said) for said in ("on", "0.5", "0", "2700 K", "")] == [OWN, OTHER, OWN, OWN, OWN]


def test_a_word_that_no_way_of_the_gateway_takes_goes_where_the_device_listens() -> None:
    device = lamp(
        Route(gateway="mqtt", key="own", part="state", takes=("on_off",)), Route(gateway="far", key="far", part="y")
    )
    assert at(device, "0.5") == OWN


def test_a_device_with_one_way_listens_where_it_says() -> None:
    """And so does one that speaks plain words, whatever its parts."""
    assert at(lamp(Route(gateway="mqtt", key="own", part="state", takes=("on_off",))), "0.5") == OWN
    plain = lamp(Route(gateway="mqtt", key="own", part="state"), Route(gateway="mqtt", key="other", part="x"))
    endpoint = Endpoint(gateway="mqtt", key="own", address="home/lamp/out", command_address="home/lamp/in")
    assert command_address(plain, endpoint, "0.5") == "home/lamp/in"


def wall(*parts: Part) -> Device:
    routes = [Route(gateway="mqtt", key="wall", part=one.id) for one in parts]
    found = tuple(DevicePart(id=one.id, part=one, routes=(route,)) for one, route in zip(parts, routes, strict=True))
    return lamp().model_copy(update={"parts": found})


def gang(part_id: str, *, name: str = "", service_type: str = "switch", **more: object) -> Part:
    made = Part(
        id=part_id, name=name, service_type=service_type, capabilities=(Capability(name="on_off", settable=True),)
    )
    return made.model_copy(update=more)


def test_the_others_are_those_that_would_have_taken_the_word_as_well() -> None:
    """What is of another type, a setting, or cannot be told that, is no other gang."""
    device = wall(
        gang("a"),
        gang("b", name="Right"),
        gang("c"),
        gang("lock", category="config"),
        gang("lamp", service_type="light"),
        gang("deaf", capabilities=(Capability(name="on_off"),)),
    )
    assert others_at(device, text_address("wall", "a"), "off") == ("Right", "c")
    assert others_at(device, text_address("wall", "b"), "off") == ("a", "c")
    assert others_at(device, text_address("wall", "lamp"), "off") == ()
    assert others_at(device, text_address("wall", "a"), "0.5") == ()
    assert others_at(device, "home/wall/in", "off") == ()
