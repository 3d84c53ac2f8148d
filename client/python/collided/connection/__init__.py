"""Reaching a daemon: its address, credentials, calls, and one of our own where none is named."""
