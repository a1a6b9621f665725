"""Finds devices in the index: postings, ranks and unknown words. Pure."""
