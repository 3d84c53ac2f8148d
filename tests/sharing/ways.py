"""The ways to a daemon: its own port and shared memory, or the entrance of deploy/entrance with TLS."""

import pathlib
import re

from ops_daemon import Daemon

from attacks.catalogue import Target
from honest import Server

MAX_MB = 300  # of the daemon and the entrance together


def peak_mb(process):
    """Returns the peak memory of a process; None if it has ended."""
    found = re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="ascii"))
    return int(found[1]) // 1024 if found else None


class Way:
    """A daemon with whatever is in front of it. `processes` are by name."""

    max_mb = None

    def log(self):
        return self.daemon.log()

    def peak_mb(self):
        return {name: peak_mb(process) or 0 for name, process in self.processes.items()}


class Direct(Way):
    def __init__(self, folder, program, *options, backend):
        self.local = folder.path("local")
        self.daemon = Daemon(program, "--local-socket", self.local, *options, backend=backend)
        self.server = Server(self.daemon.address)
        self.processes = {"daemon": self.daemon.process}

    def target(self, token, source=""):
        port, http_port = (int(address.rsplit(":", 1)[1]) for address in (self.daemon.address, self.daemon.http_address))
        return Target(port, http_port, token, self.local, self.daemon.process.pid, source)

    def close(self):
        self.daemon.__exit__()


class Entered(Way):
    """Through HAProxy, over a Unix socket. Without HAProxy the program ends as skipped here."""

    max_mb = MAX_MB

    def __init__(self, folder, program, *options, backend):
        from entrance import Entrance
        folder.certificates()
        both = folder.put("both.pem", (folder.read("server.pem") + folder.read("server.key")).decode())
        self.ca = folder.path("ca.pem")
        self.daemon = Daemon(program, "--name", "one", *options, address=f"unix:{folder.path('socket')}", backend=backend)
        self.entrance = Entrance([f"one={self.daemon.address},{self.daemon.http_address}"], "--certificate", both)
        self.server = Server(self.entrance.address, {"tls_ca": self.ca, "tls_server_name": "localhost"}, ("grpc",))
        self.processes = {"daemon": self.daemon.process, "entrance": self.entrance.process}

    def target(self, token, source=""):
        (host, port), http = self.entrance.address.split(":"), self.entrance.http_address
        return Target(int(port), int(http.rsplit(":", 1)[1]), token, "", self.daemon.process.pid, source, host, self.ca)

    def close(self):
        self.entrance.close()
        self.daemon.__exit__()
