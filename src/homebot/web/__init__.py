"""The web page of homebot: its files, and the list of devices that it begins with."""
