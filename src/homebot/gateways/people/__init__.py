"""The people of a house, as devices that tell whether each of them, or anybody, is at home."""

from homebot.gateways.people.gateway import PeopleGateway

__all__ = ["PeopleGateway"]
