"""The computation graph: nodes, typed topics with QoS, services, parameters and the directory of them all."""

from homebot.graph.client import Client
from homebot.graph.endpoint import ActionInfo, EndpointInfo, EntityKind, GraphChange
from homebot.graph.graph import Graph
from homebot.graph.mailbox import Mailbox
from homebot.graph.node import Node
from homebot.graph.parameters import Parameter, ParameterDescriptor, ParameterSet
from homebot.graph.publisher import Publisher
from homebot.graph.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_incompatibilities,
    qos_profile_default,
    qos_profile_latched,
    qos_profile_parameter_events,
    qos_profile_rosout,
    qos_profile_sensor_data,
    qos_profile_services_default,
)
from homebot.graph.rosout import RosoutFeed
from homebot.graph.service import Service
from homebot.graph.subscription import OTHERS, Subscription
from homebot.graph.timer import Timer

__all__ = [
    "OTHERS",
    "ActionInfo",
    "Client",
    "DurabilityPolicy",
    "EndpointInfo",
    "EntityKind",
    "Graph",
    "GraphChange",
    "HistoryPolicy",
    "LivelinessPolicy",
    "Mailbox",
    "Node",
    "Parameter",
    "ParameterDescriptor",
    "ParameterSet",
    "Publisher",
    "QoSProfile",
    "ReliabilityPolicy",
    "RosoutFeed",
    "Service",
    "Subscription",
    "Timer",
    "qos_incompatibilities",
    "qos_profile_default",
    "qos_profile_latched",
    "qos_profile_parameter_events",
    "qos_profile_rosout",
    "qos_profile_sensor_data",
    "qos_profile_services_default",
]
