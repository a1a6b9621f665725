"""The text form of states and commands, as in the topic layout ``HOME/SERVICE_TYPE/DEVICE_ID``. Pure."""
