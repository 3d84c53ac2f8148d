"""What every attack is made of: its name and kind, the daemon that it is for, and a count of what became of its tries."""

import collections
import dataclasses
import functools
import socket
import ssl

ATTACKS = {}  # by name, in the order in which they are defined
SELF_CHECK = "self-check"  # a kind that the catalogue leaves out
STORM = "storms"
APART = "http2 clients"  # a kind whose attacks have a source each


@dataclasses.dataclass
class Attack:
    name: str
    kind: str
    round: object  # called with (target, told, over) again and again until `over`; what it raises is counted

    @property
    def about(self):
        return self.round.__doc__

    @property
    def source(self):
        """Its address, which no honest client has."""
        return f"127.0.0.{2 + list(ATTACKS).index(self.name)}" if self.kind == APART else "127.0.0.2"


def attack(kind):
    """The function is an attack of this kind, by its own name."""
    def add(function):
        ATTACKS[function.__name__] = Attack(function.__name__, kind, function)
        return function
    return add


@dataclasses.dataclass
class Target:
    port: int
    http_port: int
    token: str
    local_socket: str
    pid: int
    source: str = ""  # of connections over TCP; empty: the attack's own
    host: str = "127.0.0.1"
    tls_ca: str = ""  # file; empty: `port` is plain text

    @property
    def address(self):
        return f"{self.host}:{self.port}"

    def bytes(self, port=None):
        """A connection from the attack's source, without TLS."""
        return socket.create_connection((self.host, port or self.port), 5, source_address=(self.source, 0))

    def tcp(self):
        """The same, ready for HTTP/2."""
        connection = self.bytes()
        return context(self.tls_ca).wrap_socket(connection) if self.tls_ca else connection

    def local(self):
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        connection.settimeout(1)
        connection.connect(self.local_socket)
        return connection


@functools.lru_cache
def context(ca):
    """Trusts certificates of this CA, whatever name they have."""
    made = ssl.create_default_context(cafile=ca)
    made.check_hostname = False
    made.set_alpn_protocols(["h2"])
    return made


class Told(collections.Counter):
    """How often one attack did each thing, and in `met` what the daemon did about it."""

    def __init__(self):
        super().__init__()
        self.met = collections.Counter()
        self.bug = None  # of the attack itself

    def of(self, error):
        code = getattr(error, "code", None)
        name = code().name if callable(code) else type(error).__name__
        self.met[name] += 1

    def attempt(self, function, *arguments):
        """Its result; None if it was refused, which is counted by its code."""
        import grpc  # raw attacks do without
        self["calls"] += 1
        try:
            result = function(*arguments)
        except grpc.RpcError as error:
            self.of(error)
            return None
        self.met["OK"] += 1
        return result


def hold(connections, told, over, name="held"):
    told[name] += len(connections)
    over.wait()
    for connection in connections:
        connection.close()


