"""W3C Thing Descriptions 1.1: parsing, classification and export. Pure."""
