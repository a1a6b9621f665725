"""Recordings: messages of gateways, and commands, in a file; and their replay, with the same or changed apps."""

from typing import Final

from homebot.feature import Feature, RunOption, Verb
from homebot.rights import OfferedService, Right

START_RECORDER: Final = OfferedService("/homebot/start_recorder", Right.MANAGE, "std_srvs/srv/Trigger")
READ_RECORDING: Final = OfferedService("/homebot/recorder/read", Right.MANAGE)
"""Offered while a recorder runs."""

FEATURE: Final = Feature(
    name="recording",
    server="homebot.features.recording.recording_server:RecordingServer",
    services=(START_RECORDER, READ_RECORDING),
    verbs={
        "record": Verb(
            "record the house, for a replay", "homebot.features.recording.command:add_arguments", after="journal"
        ),
        "replay": Verb(
            "replay a recorded day, and show which commands differ",
            "homebot.features.recording.command_replay:add_arguments",
            after="record",
        ),
    },
    run_options={
        "record": RunOption(
            "FILE",
            "record the whole run into a new file, for `homebot replay`",
            "homebot.features.recording.recording_server:record_into_file",
        )
    },
)
