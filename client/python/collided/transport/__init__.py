"""How a session's frames reach the daemon: over gRPC, or through memory that both share."""
