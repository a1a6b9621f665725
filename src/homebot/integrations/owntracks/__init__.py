"""OwnTracks: where the phones of people are, by the regions that they enter.

Reads: ``place`` of each phone, ``home`` in a region of that name, otherwise the region or ``not_home``, and its
battery. A message that is older than the phone's newest one (``tst``) is late, and not read. Name the phone in
``[people]`` (``docs/people.md``).

Transport: MQTT, JSON on ``owntracks/USER/DEVICE`` and ``…/event`` (``homebot.mqtt_conventions``). ``prefix`` in its
table names another first level.

Source: owntracks.org/booklet, "JSON" (``_type=location``, ``_type=transition``) and "Topics".

Tested against: the messages of that page, and hostile ones.

Not done: encrypted messages, which are named, coordinates, waypoints, cards and commands. It has no simulated devices.
"""
