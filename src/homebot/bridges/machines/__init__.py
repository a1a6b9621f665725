"""Several machines as one house: the gateways of this one, for the homebot that has the index and the control."""
