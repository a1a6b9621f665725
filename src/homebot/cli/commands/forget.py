"""``homebot forget``."""

from __future__ import annotations

import argparse

from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient
from homebot.cli.publishing import GatewayPublisher
from homebot.cli.table import printable
from homebot.cli.with_client import with_client
from homebot.devices.names import FORGET_DEVICE
from homebot.devices.services import ForgetDeviceResponse
from homebot.errors import PeerError
from homebot.messages.json import message_from_json

__all__ = ["forget"]


def forget(options: argparse.Namespace) -> int:
    """Take a device out of the index, and on request its announcements off the broker."""

    async def run(door: DoorClient) -> int:
        device = await named_device(door, options.device)
        outbox = GatewayPublisher(door)
        if options.purge:  # before anything is done, so that nothing is done by halves
            for gateway in sorted({one.gateway for one in device.endpoints}):
                await outbox.check(gateway)
        answer = message_from_json(ForgetDeviceResponse, await door.call(FORGET_DEVICE, {"device": device.id}))
        if not answer.success:
            raise PeerError(answer.message)
        print(f"forgot {printable(device.id)}")
        for one in answer.announced_on:
            if options.purge:
                await outbox.publish(one.gateway, one.topic, "", retain=True)
                print(f"deleted the retained message on {printable(one.topic)}")
            else:
                print(f"it was announced on {printable(one.topic)}; --purge deletes the retained message there")
        return 0

    return with_client(options, run)
