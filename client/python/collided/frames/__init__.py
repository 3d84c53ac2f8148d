"""One frame: what a caller says, what goes on the wire, and where it leaves the scene."""
