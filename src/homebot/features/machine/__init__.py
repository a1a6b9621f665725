"""Other machines of the house that run homebot with gateways only, each gateway of which is one here.

Reads: the devices, reports, states, answers, quarantines and raw messages of that gateway. Commands: as it does, within
the time that the command has; its services of pairing and health.

Transport: Zenoh, by the session of ``[ros]``, with a secret that both machines have.

Tested against: the contract of gateways, with the gateway in memory on the other side; two machines in networks of
their own whose link is cut, slow and lossy. Not with a radio between two computers.

Not done: devices of homebot that are exposed to other systems through a gateway of another machine, readers of tags.
"""

from typing import Final

from homebot.feature import Feature, Verb

FEATURE: Final = Feature(
    name="machine",
    over_zenoh="homebot.features.machine.serving:serve",
    verbs={
        "join": Verb(
            "let another machine, with gateways only, become part of the house",
            "homebot.features.machine.command:add_arguments",
            after="broker",
        )
    },
)
