"""Components that people and gateways added to a device, which it tells page by page when it is asked for them."""

import json

import pytest
from tests.integrations.announced_parts import Say, device_in, part_in
from tests.integrations.shelly.formats.rpc_documents import ANSWERS, ID

from homebot.conventions.description import AnnouncementEvent, DeviceRequest


def sensor(number: int, value: float) -> dict[str, object]:
    config = {"id": number, "name": f"Shelf {number}", "access": "cr"}
    return {"key": f"number:{number}", "status": {"id": number, "value": value}, "config": config}


def page(offset: int, total: int, *components: object) -> dict[str, object]:
    result = {"components": list(components), "cfg_rev": 3, "offset": offset, "total": total}
    return {"id": 1, "src": ID, "dst": f"homebot/{ID}", "result": result}


def asked(request: AnnouncementEvent) -> list[tuple[str, object]]:
    assert isinstance(request, DeviceRequest)
    frames = [json.loads(one.payload) for one in request.publications]
    return [(frame["method"], frame.get("params")) for frame in frames]


def test_an_added_component_is_a_part_with_its_given_name(gateway: Say) -> None:
    found = part_in(gateway(ANSWERS, page(0, 1, sensor(200, 21.5))), "number:200")
    assert (found.part.service_type, found.part.name) == ("x_sensor", "Shelf 200")


def test_a_water_valve_has_its_role_in_the_attributes_beside_its_configuration(gateway: Say) -> None:
    """As devices with the module of Shelly answer, such as LinkedGo ST802 (source: ShellyScanner, ``PbSXT1St802``)."""
    config = {"id": 200, "name": "Position", "owner": "service:0", "access": "crw", "min": 0, "max": 100}
    attributes = {"owner": "service:0", "role": "position"}
    valve = {"key": "number:200", "status": {"value": 40}, "config": config, "attrs": attributes}
    found = part_in(gateway(ANSWERS, page(0, 1, valve)), "number:200").part
    assert (found.service_type, found.category, found.name) == ("water_valve", "", "Position")


def test_the_pages_are_asked_for_one_after_the_other_and_count_together(gateway: Say) -> None:
    (more,) = gateway(ANSWERS, page(0, 3, sensor(200, 21.5), sensor(201, 4.0)))
    params = {"dynamic_only": True, "include": ["status", "config"], "offset": 2}
    assert asked(more) == [("Shelly.GetComponents", params)]
    device = device_in(gateway(ANSWERS, page(2, 3, sensor(202, -18.0))))
    assert [one.part.id for one in device.parts] == [f"number:{number}" for number in (200, 201, 202)]
    methods = [json.loads(one.payload) for one in device.parts[0].state_requests]
    assert [(one["method"], one.get("params", {}).get("offset")) for one in methods] == [
        ("Shelly.GetStatus", None),
        ("Shelly.GetComponents", 0),
        ("Shelly.GetComponents", 2),
    ]


def test_the_request_of_the_next_page_replaces_no_other(gateway: Say) -> None:
    """Who is asked again, as after a new link, may be telling the first page meanwhile."""
    gateway(ANSWERS, page(0, 1, sensor(200, 21.5)))
    (again,) = gateway(f"{ID}/online", "true")
    (more,) = gateway(ANSWERS, page(0, 3, sensor(200, 21.5), sensor(201, 4.0)))
    assert isinstance(again, DeviceRequest)
    assert isinstance(more, DeviceRequest)
    assert again.key != more.key


def test_the_same_pages_report_the_status(gateway: Say) -> None:
    found = part_in(gateway(ANSWERS, page(0, 1, sensor(200, 21.5))), "number:200")
    message = json.dumps(page(0, 1, sensor(200, 22.0))).encode()
    assert found.codec.read(ANSWERS, message, retained=False) == {"measurement": 22.0}
    other = json.dumps(page(0, 1, sensor(201, 22.0))).encode()
    assert found.codec.read(ANSWERS, other, retained=False) == {}
    assert gateway(ANSWERS, page(0, 1, sensor(200, 22.0))) == ()


def test_a_removed_component_is_gone_with_the_next_list(gateway: Say) -> None:
    gateway(ANSWERS, page(0, 2, sensor(200, 1.0), sensor(201, 2.0)))
    device = device_in(gateway(ANSWERS, page(0, 1, sensor(201, 2.0))))
    assert [one.part.id for one in device.parts] == ["number:201"]


@pytest.mark.parametrize("offset", [0, 1, 7, "x", None, -1])
def test_a_device_that_never_ends_its_list_is_not_asked_for_ever(gateway: Say, offset: object) -> None:
    frame = page(0, 9, sensor(200, 1.0))
    result = {"components": [sensor(200, 1.0)], "total": 9, "offset": offset}
    gateway(ANSWERS, frame)
    heard = [gateway(ANSWERS, {**frame, "result": result}) for _ in range(200)]
    assert len([one for one in heard if one]) <= 100
    assert heard[-1] == ()


def test_older_firmware_has_no_such_list(gateway: Say) -> None:
    error = {"id": 1, "src": ID, "error": {"code": 404, "message": "No handler for Shelly.GetComponents"}}
    assert gateway(ANSWERS, error) == ()
