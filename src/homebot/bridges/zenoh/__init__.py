"""The session of Zenoh with robots and other machines of the house, and the rights in it."""
