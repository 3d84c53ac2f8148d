"""Daemons behind a real HAProxy, with the files of deploy/routing, whose example addresses become loopback ones."""

import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

HAPROXY = shutil.which("haproxy", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
if not HAPROXY:
    print("skipped: haproxy is not installed (Debian: haproxy)")
    sys.exit(77)

PATIENCE = 60
PORT, HTTP_PORT = 50551, 9464


def wait_for(condition, what):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.01)


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
    """Three daemons, collided-0 to collided-2, and HAProxy with one of the files.

    options: of all daemons; own: more of each, by its index. advertise: streams go to the daemons, not through the proxy.
    """

    def __init__(self, program, deploy, config="haproxy.cfg", *options, own=None, advertise=True):
        self._folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self._folder.name)
        # Loopback addresses that nobody else has, so that ports need not be free.
        net = f"127.{random.randint(1, 254)}.{random.randint(0, 255)}"
        self.members = []
        self.proxy = None
        try:
            for index in range(3):
                host = f"{net}.{10 + index}"
                endpoint = ["--endpoint", f"{host}:{PORT}"] if advertise else []
                more = (own or {}).get(index, [])
                self.members.append(Member(program, folder, f"collided-{index}", host, [*options, *endpoint, *more]))
            self.address = f"{net}.9:{PORT}"
            self._control = folder / "admin.sock"
            self._start_proxy(folder, pathlib.Path(deploy) / "routing", config, net)
        except BaseException:
            self.close()
            raise

    def _start_proxy(self, folder, source, config, net):
        text = (source / config).read_text()
        for example, here in (("192.0.2.", f"{net}."), (f"bind :{PORT}", f"bind {self.address}"),
                              ("/run/haproxy/admin.sock", str(self._control)),
                              ("/etc/haproxy/free_memory.lua", str(source / "free_memory.lua"))):
            text = text.replace(example, here)
        (folder / "haproxy.cfg").write_text(text)
        subprocess.run([HAPROXY, "-c", "-q", "-f", str(folder / "haproxy.cfg")], check=True, timeout=PATIENCE)
        self._log = open(folder / "haproxy.log", "wb")
        self.proxy = subprocess.Popen([HAPROXY, "-db", "-f", str(folder / "haproxy.cfg")], stdout=self._log, stderr=self._log)
        wait_for(lambda: self._control.exists() or self.proxy.poll() is not None, "start of HAProxy")
        if self.proxy.poll() is not None:
            raise RuntimeError(pathlib.Path(self._log.name).read_text())

    def ask_proxy(self, command):
        """Its answer to a command of the runtime API."""
        with socket.socket(socket.AF_UNIX) as control:
            control.settimeout(PATIENCE)
            control.connect(str(self._control))
            control.sendall(command.encode() + b"\n")
            answer = b""
            while part := control.recv(65536):
                answer += part
        return answer.decode()

    def weights(self):
        """Of the backend that places new scenes."""
        return [int(self.ask_proxy(f"get weight place/{member.name}").split()[0]) for member in self.members]

    def states(self, backend):
        """Of the servers of a backend: UP, DOWN, NOLB."""
        rows = [line.split(",") for line in self.ask_proxy(f"show stat {backend} 4 -1").splitlines() if line]
        status = rows[0].index("status")
        return {row[1]: row[status].split()[0] for row in rows[1:]}

    def scenes(self):
        return [int(member.metric("collided_scenes")) for member in self.members]

    def close(self):
        if self.proxy is not None:
            self.proxy.kill()
            self.proxy.wait()
            self._log.close()
        for member in self.members:
            member.close()
        self._folder.cleanup()
