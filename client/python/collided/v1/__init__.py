"""Messages of the protocol, generated from proto/collided/v1 by client/python/generate."""
