"""Polygons of any number of corners as triangles."""

from __future__ import annotations

import numpy as np

from collided.errors import InvalidArgument


def fans(corners: np.ndarray, counts: np.ndarray, argument: str) -> np.ndarray:
    """Triangles, in the order of the polygons, of `counts[i]` corners each, which follow one another in `corners`."""
    if counts.size and int(counts.min()) < 3:
        raise InvalidArgument(f"{argument} {int(counts.argmin())} has {int(counts.min())} corners; it needs 3")
    starts = np.cumsum(counts) - counts
    sizes = counts - 2
    polygon = np.repeat(np.arange(len(counts)), sizes)
    within = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    first = starts[polygon]
    return np.stack([corners[first], corners[first + within + 1], corners[first + within + 2]], axis=1)
