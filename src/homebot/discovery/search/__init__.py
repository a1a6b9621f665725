"""Search in the index: postings, ranking and unknown words. Pure."""
