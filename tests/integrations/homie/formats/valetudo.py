"""A robot with Valetudo 2026.02.0 (``backend/lib/mqtt``), by Homie 4: of its 13 nodes those that may mislead."""

from collections.abc import Mapping

from homebot.conventions.description import DeviceAnnounced
from homebot.integrations.homie.formats import Homie, HomieSettings

VALETUDO = {
    "BatteryStateAttribute": ("Battery state", {
        "level": ("Battery level", {"$datatype": "integer", "$unit": "%"}),
        "status": ("Battery status", {"$datatype": "enum", "$format": "none,charging,discharging,charged"}),
    }),
    "AttachmentStateAttribute": ("Attachment state", {
        "dustbin": ("Dust bin", {"$datatype": "boolean"}),
        "watertank": ("Water tank", {"$datatype": "boolean"}),
        "mop": ("Mop", {"$datatype": "boolean"}),
    }),
    "FanSpeedControlCapability": ("Fan speed control", {
        "preset": ("Fan speed", {"$datatype": "enum", "$format": "off,low,medium,high,max", "$settable": "true"}),
    }),
    "WaterUsageControlCapability": ("Water grade control", {
        "preset": ("Water grade", {"$datatype": "enum", "$format": "off,low,medium,high", "$settable": "true"}),
    }),
    "BasicControlCapability": ("Basic control", {
        "operation": ("Operation", {"$datatype": "enum", "$format": "START,STOP,PAUSE,HOME", "$settable": "true"}),
    }),
    "KeyLockCapability": ("Lock Keys", {
        "enabled": ("Lock Keys", {"$datatype": "enum", "$format": "ON,OFF", "$settable": "true"}),
    }),
    "SpeakerVolumeControlCapability": ("Speaker volume control", {
        "value": ("Speaker volume", {"$datatype": "integer", "$format": "0:100", "$settable": "true"}),
    }),
}  # fmt: skip
STATUS = ("Vacuum status", {
    "status": ("Status", {
        "$datatype": "enum", "$format": "error,docked,idle,returning,cleaning,paused,manual_control,moving",
    }),
})  # fmt: skip


def robot(
    base: str, nodes: Mapping[str, tuple[str, Mapping[str, tuple[str, Mapping[str, str]]]]], domain: str = "homie"
) -> DeviceAnnounced:
    """The robot with *nodes* below the topic *base*, as it is described at last."""
    messages = {"$homie": "4.0.0", "$name": "Rocky", "$nodes": ",".join(nodes), "$extensions": ""}
    for node, (name, props) in nodes.items():
        messages |= {f"{node}/$name": name, f"{node}/$type": "Capability", f"{node}/$properties": ",".join(props)}
        for prop, (called, attributes) in props.items():
            messages |= {f"{node}/{prop}/{key}": value for key, value in {"$name": called, **attributes}.items()}
    homie = Homie(HomieSettings(domains=(domain,)))
    heard = [
        one
        for suffix, text in {**messages, "$state": "ready"}.items()
        for one in homie.read_message(f"{base}/{suffix}", text.encode(), retained=True)
    ]
    return [one for one in heard if isinstance(one, DeviceAnnounced)][-1]
