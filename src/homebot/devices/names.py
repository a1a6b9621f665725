"""The names shared by the layers on the graph, and the reasons why a gateway sends nothing."""

from homebot.names import escape_token

GET_INDEX_DATA = "/getIndexData"
FIND_DEVICES = "/discovery/find_devices"
QUERY_DEVICES = "/discovery/query"
LIST_DEVICES = "/discovery/list"
LIST_GROUPS = "/discovery/groups"
FORGET_DEVICE = "/discovery/forget"
SPLIT_DEVICE = "/discovery/split"
MERGE_DEVICES = "/discovery/merge"
PLACE_DEVICE = "/discovery/place"
ALIAS_DEVICE = "/discovery/alias"
TEACH_PLACE = "/discovery/teach_place"
TAG_DEVICE = "/discovery/tag"
APPROVE_DEVICE = "/discovery/approve"
CHANGE_ROOM = "/discovery/change_room"
GET_PLACES = "/discovery/places"
EXPORT_PLACES = "/discovery/export_places"
IMPORT_PLACES = "/discovery/import_places"
GET_CHANGES = "/discovery/changes_since"
DEVICE_CHANGES = "/discovery/changes"
DEVICE_STATES = "/discovery/states"
DEVICE_SETTINGS = "/discovery/settings"
APPROVED_COMMANDS = "/discovery/approved"
ALERT_FINDINGS = "/alerts/findings"
DISCOVERY_HEALTH = "/discovery/health"
RUNTIME_HEALTH = "/homebot/health"
EXPORT_INDEX = "/discovery/export_index"
OWNER_REQUESTS = "/discovery/owner_requests"
PERFORM_COMMAND = "/control/perform"
SEND_TEXT = "/control/send_text"
COMMAND_DEVICES = "/devices/command"
PERFORM_COMMANDS = "/devices/perform"
HOLD_DEVICE = "/devices/hold"
HOLD_PART = "/control/hold"
RENEW_LEASE = "/control/renew"
RELEASE_LEASE = "/control/release"
GET_LEASES = "/control/leases"
GET_CAUSES = "/control/causes"
END_LEASES = "/control/end_leases"
COMMAND_EVENTS = "/control/events"
READ_JOURNAL = "/control/journal"
EXPLAIN_DEVICE = "/control/why"
EXPLAIN_MISSING_STATE = "/control/why_not"
GET_UNAPPROVED = "/control/unapproved"
TRUST_DEVICE = "/control/trust"
OPEN_QUESTIONS = "/control/questions"
GET_QUESTIONS = "/control/get_questions"
ANSWER_QUESTION = "/control/answer"
JOURNAL_ENTRIES = "/control/journal_entries"
READ_HISTORY = "/history/read"
READ_ENERGY = "/history/energy"
DEFINE_TYPE = "/homebot/define_type"
LIST_APPS = "/apps/list"
LOAD_APP = "/apps/load"
UNLOAD_APP = "/apps/unload"
RELOAD_APP = "/apps/reload"
HOME_PLACE = "/homebot/place"
LIST_ROUTINES = "/routines/list"
CHANGE_ROUTINE = "/routines/change"
LIST_SCENES = "/scenes/list"
CHANGE_SCENE = "/scenes/change"
APPLY_SCENE = "/scenes/apply"
COPY_FILES = "/homebot/copy_files"
RELOAD = "/homebot/reload"
RESTART_GATEWAY = "/homebot/restart_gateway"
LIST_TOKENS = "/rosbridge_websocket/tokens"
ACCESS_REFUSALS = "/rosbridge_websocket/refusals"
OWN_NAMESPACES = frozenset(
    {
        "apps",
        "broker",
        "control",
        "devices",
        "discovery",
        "gateway",
        "getIndexData",
        "homebot",
        "network_services",
        "parameter_events",
        "robots",
        "rosapi",
        "rosbridge_websocket",
        "rosout",
        "subscribe_to_mqtt_topic",
    }
)
"""First parts of the names of homebot's own topics and services."""

POSE_TOPICS = frozenset({"amcl_pose", "odom", "pose", "room", "tf", "tf_static"})
"""Last parts of the names of the topics on which robots publish their poses."""

ROBOT_POSES = "/robots/poses"
WHERE_IS_ROBOT = "/robots/where"

HOME_HEADER = "Homebot-Home"
"""Header with the percent-encoded name of the home in the door's answer to a handshake."""

DIRECTORY_NODE = "/discovery"
"""The node of the directory, the only one that publishes changes of devices."""

ROBOTS_NODE = "/robots"
"""The node of the tracker of robots, the only one that publishes their poses."""

RUNTIME_NODE = "/homebot"
"""The node of a runtime; all its commands pass the control layer."""

MACHINE_NODE = "/machine"
"""The node of a machine with gateways only, whose index and control are those of the homebot of the house."""

GROUP = "group"
"""The fact of a device that names a group of which it is a member."""

OWNER = "owner"
"""The convention of facts that the owner states."""

SEEN = "seen"
"""The gateway of positions at which a robot saw a device."""

TAG = "tag"
"""The convention of facts from an NFC tag or a code on the device."""

PREFER = "prefer"
"""The owner's fact that names the preferred gateways for commands to a device, best first."""

OWN_MODEL = "homebot"
"""The model of homebot's own bridges to other ecosystems, on the network: its gateways leave them out."""

NEEDS_GATEWAY = "needs_gateway"
"""The fact that names the plug-in of an unconfigured gateway that could use the device."""

NEXT_STEP = "next_step"
"""The fact that says what a person can do so that it is used."""

SEVERAL_NAMES = "several_names"
"""The fact of a device with several names in one convention; its value begins with ``names``."""

UNREADABLE = "unreadable"
"""The fact of a device that sent what its announcement does not explain: how often, and why the last time.

Its value begins with ``payloads``.
"""

_GATEWAYS = "/gateway/"

GATEWAY_READING = frozenset({"health", "read_tag", "scan", "subscribe_to_mqtt_topic", "subscribe_to_topic", "unpaired"})
"""Last parts of the names of read-only gateway services: no device notices a call."""
TEXT_SCHEME = "words:"
"""The beginning of a text address."""

SENDS_NOTHING = "homebot runs with --dry-run, so nothing is sent"

ONLY_OBSERVES = "the gateway only observes; start with --act, or set act = true in the gateway's table"


class GatewayNames:
    """The graph names of one gateway.

    Attributes:
        node: Full name of its node.
        received_topics: Topic of its sightings.
        out: Topic of the raw commands for its devices.
        readings: Topic of the reports of its devices, as :class:`homebot.devices.gateway_messages.Report`.
        answers: Topic of the answers of devices to commands, as
            :class:`homebot.devices.gateway_messages.CommandAnswer`.
        state: Topic of its own state.
        quarantine: Topic of the peers in quarantine, as :class:`homebot.devices.health.Quarantine`.
        health: Service that returns its counters and the peers in quarantine.
        offers: Topic of the devices that homebot exposes to other systems through it, as
            :class:`homebot.devices.exposure.ExposedDevice`.
        offer_reports: Topic of their states, as :class:`homebot.devices.exposure.ExposedState`.
        offer_commands: Topic of the commands of these systems, as :class:`homebot.devices.gateway_messages.Command`.
        send_command: Service that takes commands in terms of the vocabulary.
        describe_commands: Service that returns the messages that commands would publish, as
            :data:`homebot.devices.approval_messages.DescribeCommands`.
        refresh: Service that asks a part for its values, as :data:`homebot.devices.gateway_messages.RefreshPart`; only
            of gateways that can.
        picture: Service that returns the newest picture of a part, as
            :data:`homebot.devices.picture_messages.GetPicture`; only of gateways that have some.
        subscribe: Service that starts mirroring raw messages.
    """

    def __init__(self, gateway: str) -> None:
        base = f"{_GATEWAYS}{gateway}"
        self.node = base
        self.received_topics = f"{base}/received_topics"
        self.out = f"{base}/out"
        self.readings = f"{base}/readings"
        self.answers = f"{base}/answers"
        self.state = f"{base}/state"
        self.quarantine = f"{base}/quarantine"
        self.health = f"{base}/health"
        self.offers = f"{base}/offers"
        self.offer_reports = f"{base}/offer_reports"
        self.offer_commands = f"{base}/offer_commands"
        self.send_command = f"{base}/send_command"
        self.describe_commands = f"{base}/describe_commands"
        self.refresh = f"{base}/refresh"
        self.picture = f"{base}/picture"
        self.subscribe = f"{base}/subscribe_to_topic"
        self._received_data = f"{base}/received_data"

    def received_data(self, *device: str) -> str:
        """Return the topic that mirrors a device's raw messages; illegal tokens in its name are escaped."""
        return "/".join((self._received_data, *(escape_token(part) for part in device)))


class TagNames:
    """The additional graph names of a gateway of tags.

    Attributes:
        taps: Topic of the tags that were held to a reader, as :class:`homebot.devices.tags.TagTap`.
        scan: Service :data:`homebot.devices.tags.ScanCode`.
        read_tag: Service :data:`homebot.devices.tags.ReadTag`.
        write_tag: Service :data:`homebot.devices.tags.WriteTag`.
    """

    def __init__(self, gateway: str) -> None:
        base = f"{_GATEWAYS}{gateway}"
        self.taps = f"{base}/taps"
        self.scan = f"{base}/scan"
        self.read_tag = f"{base}/read_tag"
        self.write_tag = f"{base}/write_tag"


class PairingNames:
    """The additional graph names of a gateway that pairs devices.

    Attributes:
        pair: Service :data:`homebot.gateways.pairing.Pair`.
        unpair: Service :data:`homebot.gateways.pairing.Unpair`.
        unpaired: Service :data:`homebot.gateways.pairing.ListUnpaired`.
    """

    def __init__(self, gateway: str) -> None:
        base = f"{_GATEWAYS}{gateway}"
        self.pair = f"{base}/pair"
        self.unpair = f"{base}/unpair"
        self.unpaired = f"{base}/unpaired"


def gateway_of(node: str) -> str:
    """Return the name of the gateway whose node has the full name *node*; empty if it is not a gateway."""
    name = node.removeprefix(_GATEWAYS)
    return "" if name == node or "/" in name else name


def text_address(key: str, part_id: str) -> str:
    """Return the text address of the part *part_id* of the device with the gateway's *key*."""
    if not ("%" in key or "#" in key or "%" in part_id or "#" in part_id):
        return f"{TEXT_SCHEME}{key}#{part_id}"
    return f"{TEXT_SCHEME}{_escape(key)}#{_escape(part_id)}"


def is_text_address(address: str) -> bool:
    """Return whether *address* is the text address of a part."""
    return address.startswith(TEXT_SCHEME) and address.count("#") == 1


def read_text_address(address: str) -> tuple[str, str] | None:
    """Return the key and the part of a text address; None for any other address."""
    if not address.startswith(TEXT_SCHEME) or address.count("#") != 1:
        return None
    key, _, part_id = address[len(TEXT_SCHEME) :].partition("#")
    return (_unescape(key), _unescape(part_id)) if "%" in address else (key, part_id)


def _escape(text: str) -> str:
    return text.replace("%", "%25").replace("#", "%23")


def _unescape(text: str) -> str:
    return text.replace("%23", "#").replace("%25", "%")
