"""A cloth falls on a sphere that turns, and folds onto itself.

python3 client/python/examples/cloth_on_sphere --help
"""

import argparse
import pathlib
import sys

import numpy as np
from crossings import Crossings
from simulation import Simulation


def arguments():
    parser = argparse.ArgumentParser(prog="cloth_on_sphere", description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=40, help="along each side of the cloth (default: 40)")
    parser.add_argument("--frames", type=int, default=300, help="of 1/60 s (default: 300)")
    parser.add_argument("--pictures", type=pathlib.Path, metavar="FOLDER", help="a PNG of each drawn frame")
    parser.add_argument("--animation", type=pathlib.Path, metavar="FILE", help="an animated GIF of them")
    parser.add_argument("--sheet", type=pathlib.Path, metavar="FILE", help="six of them as one PNG")
    parser.add_argument("--compare", type=pathlib.Path, metavar="FILE", help="nothing else, but a PNG of the last frame with one "
                        "fraction of the way for all (left) and with one for each vertex (right)")
    parser.add_argument("--contacts", action="store_true", help="mark all contacts of the cloth: with itself where it folds red, "
                        "with the sphere orange, with the floor green (default: the red ones alone)")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="draw each Nth frame only (default: 1)")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480), metavar=("WIDTH", "HEIGHT"), help="pixels")
    return parser.parse_args()


def run(options):
    """Simulates, and tells every 30 frames how it goes. Returns pictures, if any are wanted, and how many pairs met."""
    is_drawn = any((options.pictures, options.animation, options.sheet))
    pictures, advanced, crossed = [], [], 0
    with Simulation(options.cells) as simulation, Crossings(simulation) as crossings:
        if is_drawn:
            from pictures import Painter  # which needs PIL

            painter = Painter(simulation, options.size)
        for frame in range(1, options.frames + 1):
            steps = simulation.frame()
            positions = simulation.session.positions
            advanced += [step.advanced for step in steps]
            crossed += crossings.count(positions)
            folds = simulation.folds(steps[-1].near)
            if is_drawn and frame % options.every == 0:
                marked = simulation.touched(steps[-1].near) if options.contacts else {}
                pictures.append(painter.picture(positions, {**marked, "cloth": folds}))
            if frame % 30 == 0 or frame == options.frames:
                print(f"frame {frame}: {crossed} pairs met so far, {len(steps[-1].near)} contacts, {len(folds)} of "
                      f"folds, advanced {np.median(advanced):.3f} (least {min(advanced):.3f})", flush=True)
    return pictures, crossed


def save(pictures, options):
    """Writes pictures to where they are wanted."""
    from albums import animate, sheet  # which need PIL

    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        for number, picture in enumerate(pictures, 1):
            picture.save(options.pictures / f"{number * options.every:04}.png")
    if options.animation:
        animate(pictures, options.animation, 1000 * options.every // 60)
    if options.sheet:
        sheet(pictures).save(options.sheet)


def main():
    options = arguments()
    if options.compare:
        from comparison import compare  # which needs PIL

        picture, crossed = compare(options.cells, options.frames, options.size)
        picture.save(options.compare)
    else:
        pictures, crossed = run(options)
        if pictures:
            save(pictures, options)
    return 1 if crossed else 0


if __name__ == "__main__":
    sys.exit(main())
