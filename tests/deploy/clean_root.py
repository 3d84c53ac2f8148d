"""A clean Debian root, made by debootstrap from where this host gets its own packages."""

import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"
SECONDS = 900  # for a mirror that is far away


def run(*command, **options):
    return subprocess.run([str(word) for word in command], text=True, timeout=SECONDS, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **options)


def done(*command, **options):
    """Its output; fails with it."""
    finished = run(*command, **options)
    assert finished.returncode == 0, f"{' '.join(map(str, command))}\n{finished.stdout}"
    return finished.stdout


def obstacle():
    """Why no root can be made here; "" if it can."""
    if os.geteuid() != 0:
        return "a clean Debian root needs root"
    for program, package in (("debootstrap", "debootstrap"), ("unshare", "util-linux"), ("apt-get", "apt")):
        if not shutil.which(program):
            return f"{program} is not installed (Debian: {package})"
    if run("unshare", "--mount", "--pid", "--net", "--fork", "true").returncode:
        return "this machine allows no namespaces"
    return "" if suites() else "apt has no Debian sources here"


def suites():
    """(mirror, suite) of each of the host's Debian sources, its own release first."""
    names = "$(ORIGIN) $(COMPONENT) $(CREATED_BY) $(REPO_URI) $(RELEASE)"
    rows = [row.split() for row in run("apt-get", "indextargets", "--format", names).stdout.splitlines()]
    found = [tuple(row[-2:]) for row in rows if row[:3] == ["Debian", "main", "Packages"] and len(row) == 5]
    codename = done("sh", "-c", ". /etc/os-release; echo $VERSION_CODENAME").strip()
    return sorted(dict.fromkeys(found), key=lambda one: one[1] != codename)


def proxies():
    lines = run("apt-config", "dump", "Acquire").stdout.splitlines()
    return "\n".join(line for line in lines if "::Proxy" in line and '""' not in line)


class CleanRoot:
    """A minbase root in `folder`, removed by remove()."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        shutil.rmtree(self.folder, ignore_errors=True)
        sources = suites()
        mirror, suite = sources[0]
        made = run("debootstrap", "--variant=minbase", f"--keyring={KEYRING}", suite, self.folder, mirror)
        if made.returncode:
            log = self.folder / "debootstrap" / "debootstrap.log"
            raise AssertionError(made.stdout + (log.read_text()[-2000:] if log.exists() else ""))
        self.write("etc/apt/sources.list", "".join(f"deb {uri} {name} main\n" for uri, name in sources))
        self.write("etc/apt/apt.conf.d/99host", proxies())
        if any(uri.startswith("https:") for uri, _ in sources):
            self.write("etc/ssl/certs/ca-certificates.crt", pathlib.Path("/etc/ssl/certs/ca-certificates.crt").read_text())
        self.apt("update")

    def write(self, path, text):
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def put(self, source, path):
        (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, self.folder / path)

    def run(self, *command, network=False):
        """In the root, with processes of its own; without `network`, with a loopback of its own, too."""
        net = [] if network else ["--net"]
        return run("unshare", "--mount", "--pid", *net, "--fork", "--kill-child", sys.executable, HERE / "enter_root.py",
                   self.folder, *command)

    def done(self, *command, network=False):
        finished = self.run(*command, network=network)
        assert finished.returncode == 0, f"{' '.join(map(str, command))}\n{finished.stdout}"
        return finished.stdout

    def apt(self, *arguments):
        keep = ("-o", "Dpkg::Options::=--force-confold", "-o", "Dpkg::Options::=--force-unsafe-io")
        return self.done("apt-get", "-qq", "-y", "--no-install-recommends", *keep, *arguments, network=True)

    def files(self):
        """Every path that packages and programs may leave behind."""
        left_out = ("proc", "sys", "dev", "tmp", "var/cache", "var/lib/apt", "var/lib/dpkg", "var/log", "run")
        found = set()
        for folder, _, names in os.walk(self.folder):
            path = os.path.relpath(folder, self.folder)
            if not any(path == name or path.startswith(name + "/") for name in left_out):
                found |= {os.path.normpath(f"{path}/{name}") for name in ("", *names)}
        return found

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)
