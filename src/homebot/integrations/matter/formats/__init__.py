"""The clusters of Matter in the words of the vocabulary. Pure.

Source: Matter 1.4 Core Specification, Application Clusters and Device Library.
"""
