"""Builds the package in a folder of its own: a build leaves nothing beside the sources, and a read-only checkout will do."""

import atexit
import shutil
import tempfile

from setuptools import setup

SCRATCH = tempfile.mkdtemp(prefix="collided-build-")
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)

setup(options={"build": {"build_base": SCRATCH}, "egg_info": {"egg_base": SCRATCH}})
