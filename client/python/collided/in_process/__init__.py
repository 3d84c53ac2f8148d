"""The engine in this process: `server="local"`. It needs libcollided.so, and no daemon."""
