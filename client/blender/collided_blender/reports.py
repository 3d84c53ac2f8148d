"""What operators tell the user, in Blender's status bar and info log."""

import contextlib

from .marks import mark
from .package import collided
from .refused import Refused


_LESS = ". A shorter distance, fewer objects or no self contacts need less"


class Failed(Exception):
    """It has been reported."""


@contextlib.contextmanager
def errors_reported(operator):
    """Reports what users can do something about, and raises Failed, so that the operator can end."""
    try:
        yield
    except _errors() as error:
        operator.report({"ERROR"}, error.message + (_LESS if getattr(error, "code", "") == "RESOURCE_EXHAUSTED" else ""))
        raise Failed from None


def _errors():
    try:
        return Refused, collided().Error
    except Refused:
        return (Refused,)


def conclude(operator, search, by_frame, ending=""):
    """Marks what was found, and says so."""
    skipped = mark(search, by_frame)
    lines = [*summary_of(search.findings, by_frame), *([ending] if ending else [])]
    search.settings.summary = "\n".join(lines)
    operator.report({"INFO"}, ", ".join(lines))
    if skipped:
        names = ", ".join(skipped[:3]) + (f" and {len(skipped) - 3} more" if len(skipped) > 3 else "")
        operator.report({"WARNING"}, f"Touched vertices and faces are not marked in {names}: its modifiers make others, it is no "
                        "mesh, or it is linked from another file")


def summary_of(findings, by_frame):
    """Lines for people: "3 contacts, 1 crossing"."""
    counts = [f"{count} {noun}{'' if count == 1 else 's'}" for count, noun in
              zip(findings.count, ("contact", "crossing")) if count]
    if not counts:
        return ["No contacts"]
    frames = findings.frames
    where = [f"in {len(frames)} of {len(findings.by_frame)} frames, first in {frames[0]}"] if by_frame else []
    return [", ".join(counts), *where]
