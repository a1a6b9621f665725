"""Thing Descriptions on tags, in codes and in files."""

from collections.abc import Mapping

from homebot.conventions.described_thing import DescribedThing
from homebot.conventions.payload import clean_text
from homebot.devices import Device
from homebot.integrations.things.formats.export import to_thing
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.thing import facts_of, identifiers_of


class ThingDocuments:
    """The format W3C Thing Description 1.1; see :class:`homebot.conventions.described_thing.ThingFormat`."""

    def read(self, document: object) -> DescribedThing:
        """Return the described thing; raise WireError if it is invalid."""
        thing = read_thing(document)
        title, area = clean_text(thing.title), clean_text(thing.area)
        return DescribedThing(thing.id, title, area, identifiers_of(thing), facts_of(thing))

    def describe(self, device: Device, brokers: Mapping[str, str]) -> dict[str, object]:
        """Return the description of *device*, with its topics at the *brokers*."""
        return to_thing(device, brokers)
