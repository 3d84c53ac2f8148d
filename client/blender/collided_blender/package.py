"""Finds the Python package `collided`: the add-on's zip brings one, in lib/; from a checkout, the installed one serves."""

import importlib
import pathlib
import sys

from .refused import Refused

_LIB = pathlib.Path(__file__).parent / "lib"


def collided():
    """The package. Raises Refused."""
    if _LIB.is_dir() and str(_LIB) not in sys.path:
        sys.path.insert(0, str(_LIB))
    try:
        return importlib.import_module("collided")
    except ImportError as missing:
        version = ".".join(map(str, sys.version_info[:3]))
        raise Refused(f"Blender's Python {version} cannot use the package collided ({missing}); it needs Python 3.11, "
                       "grpcio, numpy and protobuf") from None
