"""A real daemon for tests of its operation, with its log, its HTTP and its health over gRPC.

Without gRPC for Python, a test that imports this ends as skipped.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request

try:
    import grpc
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-grpcio)")
    sys.exit(77)

SERVICE = "collided.v1.CollisionService"
SERVING, NOT_SERVING = 1, 2


def http(address, path):
    """Status and text."""
    try:
        with urllib.request.urlopen(f"http://{address}{path}", timeout=30) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def channel_to(address, credentials=None):
    """A channel for a `with`. TLS is for the name localhost, whatever the address."""
    options = [("grpc.use_local_subchannel_pool", 1)]
    if credentials:
        options.append(("grpc.ssl_target_name_override", "localhost"))
        return contextlib.closing(grpc.secure_channel(address, credentials, options))
    return contextlib.closing(grpc.insecure_channel(address, options))


def health(address, service="", credentials=None):
    """Returns the status that the standard health service reports. Throws grpc.RpcError."""
    request = b"\x0a" + bytes([len(service)]) + service.encode()
    with channel_to(address, credentials) as channel:
        return channel.unary_unary("/grpc.health.v1.Health/Check")(request, timeout=30)[1]


class Folder(tempfile.TemporaryDirectory):
    def path(self, name):
        return os.path.join(self.name, name)

    def put(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path(name), 0o600)
        return self.path(name)

    def certificates(self):
        """ca, server (localhost), client (sim-1) and stranger (of another CA), each with .pem and .key."""
        for ca in ("ca", "other"):
            self.openssl(f"req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN={ca} "
                         f"-addext keyUsage=critical,keyCertSign -keyout {ca}.key -out {ca}.pem")
        for name, subject, ca in (("server", "localhost", "ca"), ("client", "sim-1", "ca"), ("stranger", "x", "other")):
            self.sign(name, subject, ca)
        return ["--tls-certificate", self.path("server.pem"), "--tls-key", self.path("server.key")]

    def sign(self, name, subject, ca, days=2):
        """A certificate for `subject`, and its key; with 0 days it ends in the second in which it begins."""
        self.openssl(f"req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN={subject} "
                     f"-keyout {name}.key -out {name}.csr")
        # Python 3.13 asks for whose key signed it, and the authority for what its key is for.
        self.put("san", f"subjectAltName=DNS:{subject}\nauthorityKeyIdentifier=keyid\n")
        self.openssl(f"x509 -req -in {name}.csr -CA {ca}.pem -CAkey {ca}.key -CAcreateserial -extfile san -days {days} "
                     f"-out {name}.pem")

    def openssl(self, arguments):
        subprocess.run(["openssl", *arguments.split()], cwd=self.name, check=True, capture_output=True)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()


class Daemon:
    """Waits until it serves; kills it at the end if it still runs."""

    def __init__(self, program, *options, address="127.0.0.1:0", backend="cpu"):
        self.folder = Folder()
        self.log_path = self.folder.path("log")
        ready = self.folder.path("ready")
        command = [program, "--backend", backend, "--address", address, "--http-address", "127.0.0.1:0",
                   "--ready-file", ready, *options]
        with open(self.log_path, "wb") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log)
        self.wait_for(lambda: os.path.exists(ready) or self.process.poll() is not None, "start")
        if self.process.poll() is not None:
            said = self.log()
            self.folder.cleanup()
            raise RuntimeError(said)
        with open(ready, encoding="ascii") as file:
            self.address = file.read().split()[0].replace("127.0.0.1", "localhost")
        self.http_address = re.search(r"metrics and health on ([0-9.:]+)", self.log())[1]

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.folder.cleanup()

    def log(self):
        with open(self.log_path, encoding="utf-8") as file:
            return file.read()

    def signal(self, number):
        self.process.send_signal(number)

    def halt(self):
        """Stops all its threads until it is continued."""
        self.signal(signal.SIGSTOP)
        os.waitpid(self.process.pid, os.WUNTRACED)

    def go_on(self):
        self.signal(signal.SIGCONT)

    def stop(self):
        self.signal(signal.SIGTERM)
        return self.process.wait(60)

    def wait_for(self, condition, what):
        for _ in range(3000):
            if condition():
                return
            time.sleep(0.01)
        raise TimeoutError(f"{what}: {self.log()}")

    def reload(self):
        """SIGHUP; what it added to the log."""
        before = len(self.log())
        self.signal(signal.SIGHUP)
        self.wait_for(lambda: re.search("read again.*\n", self.log()[before:]), "reload")
        return self.log()[before:]

    def http(self, path):
        return http(self.http_address, path)

    def calls_in_work(self):
        return int(re.search(r"^collided_calls_in_work (\d+)$", self.http("/metrics")[1], re.MULTILINE)[1])

    def channel(self, credentials=None):
        return channel_to(self.address, credentials)

    def health(self, service="", credentials=None):
        return health(self.address, service, credentials)

    def info(self, credentials=None, metadata=()):
        """GetServerInfo, as bytes; throws grpc.RpcError."""
        with self.channel(credentials) as channel:
            return channel.unary_unary(f"/{SERVICE}/GetServerInfo")(b"", timeout=30, metadata=metadata)


class DaemonCase(unittest.TestCase):
    """A test with its own folder, and daemons of `program` that are gone at its end."""

    program = None

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def start(self, *options, **more):
        daemon = Daemon(self.program, *options, **more)
        self.addCleanup(daemon.__exit__)
        return daemon

    def hold(self, daemon):
        """An upload that goes on until its client ends it."""
        over = threading.Event()
        self.addCleanup(over.set)

        def chunks():
            over.wait(120)
            yield from ()

        channel = grpc.insecure_channel(daemon.address)
        self.addCleanup(channel.close)
        call = channel.stream_unary(f"/{SERVICE}/UploadMesh").future(chunks(), timeout=120)
        daemon.wait_for(lambda: daemon.calls_in_work() == 1, "upload")
        return over, call
