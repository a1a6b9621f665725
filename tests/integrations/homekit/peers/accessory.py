"""A HomeKit accessory by HAP-python: a bridge with a lamp and a lock. Each write that comes to it is printed.

Arguments: its address, its port, the file that it keeps its pairings in, and the seconds that its description takes.
"""

import sys
import time
from functools import partial

from pyhap.accessory import Accessory, Bridge
from pyhap.accessory_driver import AccessoryDriver
from pyhap.const import CATEGORY_DOOR_LOCK, CATEGORY_LIGHTBULB

PIN = "031-45-154"


class Lamp(Accessory):  # type: ignore[misc]
    """A lamp; a brightness of 13 % is a hand that turns it off."""

    category = CATEGORY_LIGHTBULB

    def __init__(self, driver: AccessoryDriver, name: str) -> None:
        super().__init__(driver, name)
        self.set_info_service("homebot", "Peer lamp", name, "SN-4711-42")
        lamp = self.add_preload_service("Lightbulb", chars=["Brightness", "Hue", "Saturation"])
        self.on = lamp.get_characteristic("On")
        for kind in ("On", "Brightness", "Hue", "Saturation"):
            lamp.configure_char(kind, setter_callback=lambda value, kind=kind: self.obey(kind, value))

    def obey(self, kind: str, value: float) -> None:
        print(f"lamp {kind} {value:g}", flush=True)
        if (kind, value) == ("Brightness", 13):
            self.driver.loop.call_later(0.5, self.on.set_value, False)


class Lock(Accessory):  # type: ignore[misc]
    """A lock that takes half a second, and timed writes only."""

    category = CATEGORY_DOOR_LOCK

    def __init__(self, driver: AccessoryDriver, name: str) -> None:
        super().__init__(driver, name)
        lock = self.add_preload_service("LockMechanism")
        self.state = lock.configure_char("LockCurrentState", value=0)
        target = lock.configure_char("LockTargetState", value=0, setter_callback=self.obey)
        target.properties["Permissions"] = [*target.properties["Permissions"], "tw"]

    def obey(self, value: int) -> None:
        print(f"lock {value}", flush=True)
        self.driver.loop.call_later(0.5, self.state.set_value, value)


class Driver(AccessoryDriver):  # type: ignore[misc]
    def get_accessories(self, **limits: bool) -> object:
        """Describe the accessories; that for its own announcement takes no time."""
        time.sleep(0.0 if limits else float(slowness))
        return super().get_accessories(**limits)


address, port, file, slowness = sys.argv[1:]
driver = Driver(
    address=address,
    listen_address=address,
    advertised_address=address,
    interface_choice=[address],
    port=int(port),
    persist_file=file,
    pincode=PIN.encode(),
    mac="12:34:56:78:9A:BC",
)
bridge = Bridge(driver, "Peer bridge")
bridge.add_accessory(Lamp(driver, "Peer lamp"))
bridge.add_accessory(Lock(driver, "Peer lock"))
driver.add_accessory(bridge)
driver.add_job(partial(print, "ready", flush=True))
driver.start()
