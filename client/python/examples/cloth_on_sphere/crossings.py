"""Counts features that meet, decided exactly by a second scene: the cloth is free of self-intersection if there are none."""

import collided


class Crossings:
    """Counts edges that go through triangles, and features that touch, of a simulation, in real arithmetic; a context manager.

    Neighbours in the cloth count, too. At a thickness of 0 there is no contact of these kinds if and only if nothing meets.
    """

    def __init__(self, simulation, **options):
        self.session = collided.Session(simulation.meshes, mode="dcd", accuracy="exact", kinds=["vt", "ee", "et"],
                                        position_format="f32", **options)

    def count(self, positions):
        """positions: of all meshes, as a session has them."""
        return len(self.session.step({name: positions[name] for name in ("sphere", "cloth")}))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.session.close()
