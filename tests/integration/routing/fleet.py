"""Daemons behind a real HAProxy: an entrance, or deploy/entrance/by_connection.cfg, whose example addresses become loopback ones."""

import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from entrance import PATIENCE, WRITER, Entrance, HaProxy, loopback_net, wait_for  # noqa: E402

PORT, HTTP_PORT = 50551, 9464


class Member:
    """One daemon, which may be started again at the same addresses."""

    def __init__(self, program, folder, name, host, options):
        self.name, self.host = name, host
        self.address = f"{host}:{PORT}"
        self._ready = folder / f"{name}.ready"
        self._log = open(folder / f"{name}.log", "wb")
        self._command = [program, "--backend", "cpu", "--threads", "1", "--name", name, "--address", self.address,
                         "--http-address", f"{host}:{HTTP_PORT}", "--ready-file", str(self._ready), *options]
        self.start()

    def start(self):
        self._ready.unlink(missing_ok=True)
        self.process = subprocess.Popen(self._command, stdout=self._log, stderr=self._log)
        wait_for(lambda: self._ready.exists() or self.process.poll() is not None, f"start of {self.name}")
        if self.process.poll() is not None:
            raise RuntimeError(pathlib.Path(self._log.name).read_text())

    def kill(self):
        """As kill -9 would, in the middle of whatever it does."""
        self.process.kill()
        self.process.wait()

    def drain(self):
        """SIGTERM; the exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE)

    def metric(self, name):
        with urllib.request.urlopen(f"http://{self.host}:{HTTP_PORT}/metrics", timeout=30) as answer:
            return float(re.search(rf"^{name} (\S+)$", answer.read().decode(), re.MULTILINE)[1])

    def close(self):
        self.kill()
        self._log.close()


class Fleet:
    """Runs three daemons, collided-0 to collided-2, behind HAProxy.

    options: of all daemons; own: more of each, by its index. advertise: streams go to the daemons, not through the proxy.
    by_connection: HAProxy forwards connections instead of calls.
    """

    def __init__(self, program, *options, own=None, advertise=True, by_connection=False):
        self._folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self._folder.name)
        net = loopback_net()
        self.members = []
        self.proxy = None
        try:
            for index in range(3):
                host = f"{net}.{10 + index}"
                endpoint = ["--endpoint", f"{host}:{PORT}"] if advertise else []
                more = (own or {}).get(index, [])
                self.members.append(Member(program, folder, f"collided-{index}", host, [*options, *endpoint, *more]))
            self.address = f"{net}.9:{PORT}"
            self.proxy = self._by_connection(folder, net) if by_connection else self._entrance()
        except BaseException:
            self.close()
            raise

    def _entrance(self):
        daemons = [f"{member.name}={member.address},{member.host}:{HTTP_PORT}" for member in self.members]
        return Entrance(daemons, "--plain-text", host=self.address.partition(":")[0])

    def _by_connection(self, folder, net):
        text = (WRITER.parent / "by_connection.cfg").read_text()
        for example, here in (("192.0.2.", f"{net}."), (f"bind :{PORT}", f"bind {self.address}"),
                              ("/run/haproxy/admin.sock", str(folder / "admin.sock"))):
            text = text.replace(example, here)
        return HaProxy(folder, text)

    def weights(self):
        """Of the backend that places new scenes."""
        return [int(self.proxy.ask(f"get weight place/{member.name}").split()[0]) for member in self.members]

    def states(self, backend):
        return self.proxy.states(backend)

    def scenes(self):
        return [int(member.metric("collided_scenes")) for member in self.members]

    def close(self):
        if self.proxy is not None:
            self.proxy.close()
        for member in self.members:
            member.close()
        self._folder.cleanup()
