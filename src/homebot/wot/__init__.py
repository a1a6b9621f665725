"""W3C Thing Descriptions 1.1: read, understood and written. Pure."""
