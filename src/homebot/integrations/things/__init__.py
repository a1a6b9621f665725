"""Devices that describe themselves: W3C Thing Descriptions, and the resources of IPSO.

Reads and commands: the properties, actions and events of Thing Descriptions 1.1 (1.0 is read too), their types by
semantics or units; over CoAP the paths of IPSO, and as text any
other resource that can be observed. It also writes the descriptions of homebot's own devices, and finds devices by
descriptions on tags, in codes and in files.

Transports: HTTP, as a driver of the gateway ``mdns`` (``homebot.drivers``); CoAP, as a session of the gateway ``coap``
(``homebot.coap_sessions``); MQTT, descriptions on ``homebot/things/NAME/td`` (``homebot.mqtt_conventions``);
directories of things, as a gateway (``homebot.gateways``).

Source: W3C Recommendations "Web of Things (WoT) Thing Description 1.1" and "Web of Things (WoT) Discovery", 5 December
2023; drafts of the bindings for HTTP, CoAP and MQTT; https://webthings.io/schemas; OMA LwM2M
registry; RFC 9176.

Tested against: descriptions of real things; the contract of gateways, for things over HTTP and for directories;
libcoap, over CoAP (``tests/peers``).

Not done: forms that lead to another host, over HTTP other credentials than basic and bearer, and payloads other than
JSON and text.
"""
