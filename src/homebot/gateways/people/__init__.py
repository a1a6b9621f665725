"""The people of a house and their household, as devices that are at home or away."""

from homebot.gateways.people.gateway import PeopleGateway

__all__ = ["PeopleGateway"]
