"""The text form of states and commands in the topic layout ``HOME/SERVICE_TYPE/DEVICE_ID``. Pure."""
