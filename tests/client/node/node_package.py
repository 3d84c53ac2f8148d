"""The package for Node, built in the build folder of its sources and of the packages that tests/run installed."""

import fcntl
import hashlib
import os
import pathlib
import shutil
import subprocess

SOURCES = ("src", "test", "examples", "generate.js", "package.json", "package-lock.json", "tsconfig.json", "README.md")
OLDEST_NODE = 20


class Missing(Exception):
    """Why the package cannot be built here."""


def node():
    """The program of a version that the package supports."""
    program = shutil.which("node")
    if not program:
        raise Missing("Node is not installed")
    version = subprocess.run([program, "--version"], text=True, capture_output=True, check=True).stdout.strip()
    if int(version.lstrip("v").split(".")[0]) < OLDEST_NODE:
        raise Missing(f"Node is {version}; the package needs {OLDEST_NODE}")
    return program


def modules(repository):
    for place in (repository / "build" / "tools" / "node", repository / "client" / "node"):
        if (place / "node_modules" / "typescript").is_dir():
            return place / "node_modules"
    raise Missing("the packages of client/node are not installed (npm ci --ignore-scripts in client/node)")


def built(repository, build):
    """The folder of the built package. Several tests may ask for it at once; one builds it."""
    repository, root = pathlib.Path(repository), pathlib.Path(build) / "tests" / "client" / "node_package"
    program, installed = node(), modules(repository)
    package = root / "client" / "node"
    package.mkdir(parents=True, exist_ok=True)
    with open(root / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        wanted, stamp = digest(repository, installed), root / "stamp"
        if not stamp.exists() or stamp.read_text() != wanted:
            stamp.unlink(missing_ok=True)
            copy(repository, installed, root, package)
            run([program, "generate.js"], package)
            run([program, "node_modules/typescript/bin/tsc"], package)
            stamp.write_text(wanted)
    return package


def files(repository):
    for name in SOURCES:
        path = repository / "client" / "node" / name
        found = path.rglob("*") if path.is_dir() else [path]
        yield from (file for file in sorted(found) if file.is_file() and "generated" not in file.parts)
    yield from sorted((repository / "proto" / "collided").rglob("*.proto"))


def digest(repository, installed):
    total = hashlib.sha256(str(installed).encode())
    for file in files(repository):
        total.update(str(file).encode() + b"\0" + file.read_bytes())
    return total.hexdigest()


def copy(repository, installed, root, package):
    shutil.rmtree(package)
    for source, target in ((repository / "proto", root / "proto"), (installed, package / "node_modules")):
        target.parent.mkdir(parents=True, exist_ok=True)
        target.unlink(missing_ok=True)
        target.symlink_to(source)
    for file in files(repository):
        if file.suffix != ".proto":
            target = package / file.relative_to(repository / "client" / "node")
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, target)


def run(command, folder, **environment):
    """What it prints. Raises if it fails, with all that it said."""
    done = subprocess.run(command, cwd=folder, text=True, capture_output=True, timeout=200, env={**os.environ, **environment})
    assert done.returncode == 0, f"{command}:\n{done.stdout}{done.stderr}"
    return done.stdout
