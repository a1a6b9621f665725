"""What the session with an endpoint takes of a description."""

from homebot.integrations.things.coap_session import with_own_forms
from homebot.integrations.things.formats.parse import CONTEXT, read_thing


def test_a_description_that_was_found_speaks_for_its_own_endpoint_alone() -> None:
    """Else whoever answers a question could make homebot switch the devices of others."""
    forms = [{"href": "/on"}, {"href": "coap://other/on"}, {"href": "coap://H:5683/x"}, {"href": "coap://h:5700/x"}]
    description = {
        "@context": CONTEXT,
        "title": "Lamp",
        "securityDefinitions": {"nosec_sc": {"scheme": "nosec"}},
        "security": "nosec_sc",
        "properties": {"on": {"type": "boolean", "forms": forms}},
    }
    thing = with_own_forms(read_thing(description, "coap://h/td"), "coap://h")
    assert [one.href for one in thing.affordances[0].forms] == ["coap://h/on", "coap://H:5683/x"]
