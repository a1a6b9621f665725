"""One folder for each maker or ecosystem, with all that is its own; ``homebot new integration`` writes another.

A folder has the messages of its devices (``formats``, pure), its driver or gateway, its simulated devices, and one page
about them in ``__init__.py``. It is cut by maker and not by transport: Shelly speaks MQTT, HTTP and Bluetooth. It may
import the kit (``conventions``, ``gateways``, ``house``), devices and messages, and no other integration; code for
several of them belongs into the kit. No other package imports a folder: its ``entry_points.txt`` names its classes, in
the form of a distribution's. To take one out, remove its folder and its tests.
"""
