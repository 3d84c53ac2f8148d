"""A workspace (GOPATH) in the build folder that has client/go and Debian's packages."""

import os
import pathlib
import shutil
import subprocess

DEBIAN = pathlib.Path("/usr/share/gocode")
PACKAGE = "collided.invalid/client/go"


class Missing(Exception):
    """Why Go programs cannot be built here."""


class Workspace:
    def __init__(self, repository, build):
        self.go = shutil.which("go")
        if not self.go:
            raise Missing("Go is not installed (Debian: golang-go)")
        for package, debian in (("grpc", "golang-google-grpc-dev"), ("protobuf", "golang-google-protobuf-dev")):
            if not (DEBIAN / "src" / "google.golang.org" / package).is_dir():
                raise Missing(f"Go's {package} is not installed (Debian: {debian})")
        root = pathlib.Path(build) / "tests" / "client" / "go_workspace"
        self.folder = root / "src" / PACKAGE
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        fresh = self.folder.with_name(f"go.{os.getpid()}")  # several tests may do this at once
        fresh.symlink_to(pathlib.Path(repository) / "client" / "go")
        fresh.replace(self.folder)
        cache = pathlib.Path(repository) / "build" / "tools" / "go-build"
        self.environment = {"GO111MODULE": "off", "GOPATH": f"{root}:{DEBIAN}", "GOCACHE": str(cache), "GOFLAGS": ""}

    def built(self, source):
        """The command of a program's source, built in the build folder."""
        program = self.folder.parents[2] / pathlib.Path(source).stem
        self.run("build", "-o", program, source)
        return [str(program)]

    def run(self, *words, **environment):
        """What `go WORDS` prints. Raises if it fails, with all that it said."""
        done = subprocess.run([self.go, *map(str, words)], cwd=self.folder, capture_output=True, timeout=230,
                              env={**os.environ, **self.environment, "PWD": str(self.folder), **environment})
        assert done.returncode == 0, f"go {words}:\n{done.stdout.decode()}{done.stderr.decode()}"
        return done.stdout
