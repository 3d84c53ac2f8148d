"""A cloth that falls on a sphere, which turns, and folds onto itself; collided decides how far each step may go."""

from dataclasses import dataclass

import numpy as np
import shapes
from cloth import Cloth
from contacts import Repulsion

import collided

FRAME, STEPS = 1 / 60, 2  # seconds of a frame, and steps in it
SWEEPS = 8  # over all constraints of a step
SETTLE = 100  # at most, over contacts alone at a step's end, until no pair comes closer than it was
AGAIN = 20  # at most, over what limits the way, in a second try
GRAVITY = np.array([0, 0, -9.8])
AIR = 0.5  # part of the velocity that is lost in a second
SIDE, DENSITY, DROP = 1.8, 0.2, 0.12  # of the cloth: m, kg / m^2, m above the sphere
RADIUS, HEIGHT, TURN = 0.3, 0.4, 2.0  # of the sphere: m, m, rad/s
# How near features are looked for, what they are kept apart, how much of that is made up for in a step, and what no
# step ever goes below; m. A cell of the cloth is larger, so that no pair of features has to be left out.
REACH, GAP, RECOVERY, MIN_SEPARATION = 0.014, 0.008, 0.0005, 0.001
FRICTION = 0.4
FOLD = 0.3  # m along the cloth, between points that meet where it folds onto itself


@dataclass
class Step:
    """What became of a step."""

    near: collided.Contacts  # where it began
    advanced: float  # the least fraction of any vertex
    way: float  # the share of all motion that was gone


class Simulation:
    """A context manager. cells: along each side of the cloth. advance: what has a fraction of its own. settle: projections of
    contacts alone. tries: how often a step is tried and what limits it pushed apart. options: of collided.Session, such as `server`."""

    def __init__(self, cells=40, advance="per_vertex", settle=SETTLE, tries=0, **options):
        self.advance, self.settle, self.tries = advance, settle, tries
        ground, sphere = shapes.floor(4.0), shapes.sphere(RADIUS, HEIGHT)
        sheet = shapes.sheet(cells, SIDE, HEIGHT + RADIUS + DROP)
        self.meshes = {"floor": collided.Mesh(*ground, motion="static"),
                       "sphere": collided.Mesh(*sphere, self_contacts=False), "cloth": collided.Mesh(*sheet)}
        self.session = collided.Session(self.meshes, mode="dcd_and_ccd", position_format="f32", thickness=REACH,
                                        min_separation=MIN_SEPARATION, **options)
        self.sphere, self.turned = sphere[0], 0.0
        self.velocity = np.zeros_like(sheet[0])
        vertex_mass = DENSITY * SIDE**2 / len(sheet[0])
        self.cloth = Cloth(sheet[0], vertex_mass)
        self.still = len(ground[0]) + len(sphere[0])  # vertices that constraints do not move
        self.inverse_masses = np.concatenate([np.zeros(self.still), np.full(len(sheet[0]), 1 / vertex_mass)])

    def frame(self):
        """The steps of a frame."""
        return [self.step() for _ in range(STEPS)]

    def step(self):
        """One step: what is near, where the cloth wants to go, how far that is free."""
        time_step = FRAME / STEPS
        near = self.session.step(mode="dcd")
        x = np.concatenate(list(self.session.positions.values())).astype(float)
        p = self.wanted(x, near, time_step)
        for _ in range(self.tries):
            limits = self.go(p, limits=True, trial=True).limits
            self.push(Repulsion(limits, x, self.inverse_masses, GAP, RECOVERY, FRICTION), p, AGAIN)
        gone = self.go(p)
        # What was not gone is lost: the cloth is where the daemon has it, and so is its velocity.
        went = self.session.positions["cloth"] - x[self.still:]
        self.velocity = (1 - AIR * time_step) / time_step * went
        # A vertex of the sphere that is held back returns to its place in later steps.
        self.turned += gone.fractions("sphere").max() * TURN * time_step
        return Step(near, gone.advanced, gone.way)

    def go(self, p, **options):
        """Goes as far towards the positions `p` as is free."""
        sphere, cloth = p[self.still - len(self.sphere):self.still], p[self.still:]
        return self.session.step({"sphere": sphere, "cloth": cloth}, advance=self.advance, **options)

    def wanted(self, x, near, time_step):
        """Where all vertices would be after the step, if nothing were in the way."""
        p = x.copy()
        p[self.still - len(self.sphere):self.still] = self.turned_sphere(self.turned + TURN * time_step)
        cloth = p[self.still:]
        cloth += time_step * (self.velocity + time_step * GRAVITY)
        repulsion = Repulsion(near, x, self.inverse_masses, GAP, RECOVERY, FRICTION)
        lambdas = self.cloth.lambdas()
        for _ in range(SWEEPS):
            self.cloth.project(cloth, lambdas, time_step)
            repulsion.push(p)
        self.push(repulsion, p, self.settle)
        return p

    def push(self, repulsion, p, times):
        """Pushes in place, so many times at most, until little is left."""
        for _ in range(times):
            if repulsion.push(p) < RECOVERY / 2:
                break

    def turned_sphere(self, angle):
        """The sphere's vertices. It is a deformable mesh, and never meets itself."""
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = self.sphere.T
        return np.stack([c * x - s * y, s * x + c * y, z], axis=1)

    def folds(self, near):
        """Those of the contacts in which the cloth lies on itself."""
        own = near.between("cloth", "cloth")
        # Vertices 0 and 3 are of different features, whatever the kind.
        rest = self.meshes["cloth"].vertices[own.local_stencils]
        return own[np.linalg.norm(rest[:, 0] - rest[:, 3], axis=1) > FOLD]

    def touched(self, near):
        """Those of the contacts in which the cloth touches another mesh, by its name."""
        return {name: near.between("cloth", name) for name in ("sphere", "floor")}

    def close(self):
        """Ends the session."""
        self.session.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
