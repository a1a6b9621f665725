"""The gateway to a gateway of another machine of the house."""

from homebot.integrations.machines.gateway.gateway import MachineGateway, MachineGatewaySettings

__all__ = ["MachineGateway", "MachineGatewaySettings"]
