#!/usr/bin/env python3
"""A client that is newer than the daemon refuses to ask for what the daemon does not know, and says what is missing.

The client is the package for Node with a protocol that has gained fields, enum values and methods in release 99.0.0 (newer.py);
the daemon is the one that was built, which is older than that. features.mjs has the tests.

usage: features_test.py DAEMON REPOSITORY BUILD_FOLDER
"""

import pathlib
import shutil
import sys

import node_package

DAEMON, REPOSITORY, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
sys.path.append(str(REPOSITORY / "tests/proto"))
import newer  # noqa: E402


def newer_repository(folder):
    """This repository with the protocol of release 99.0.0, as far as the package is made of it."""
    shutil.rmtree(folder, ignore_errors=True)
    newer.write_protocol(REPOSITORY, folder / "proto")
    for name in ("client/node", "build/tools"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).symlink_to(REPOSITORY / name)
    return folder


try:
    newer_node = newer_repository(BUILD / "tests/client/newer_node")
    package = node_package.built(newer_node, BUILD / "tests/client/newer_node_build")
    print(node_package.run([node_package.node(), "--test", REPOSITORY / "tests/client/node/features.mjs"], package,
                           COLLIDED_DAEMON=str(DAEMON), NEWER_PACKAGE=str(package), NEWER_RELEASE=newer.RELEASE,
                           NEWER_ELEMENTS=" ".join(sorted(newer.NAMES))))
except node_package.Missing as missing:
    print(f"skipped: {missing}")
    sys.exit(77)
