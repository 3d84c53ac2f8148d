"""Pictures together: moving, or side by side."""

from PIL import Image

COLOURS = 200  # of an animation, one palette for all of its pictures, so that what stands still stays as it is
COLUMNS, TILES = 3, 6


def animate(pictures, file, milliseconds):
    """Writes an animated GIF, with so many milliseconds for each picture."""
    palette = sheet(pictures).quantize(COLOURS, method=Image.Quantize.FASTOCTREE)
    first, *rest = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    first.save(file, save_all=True, append_images=rest, duration=milliseconds, loop=0, optimize=True)


def sheet(pictures):
    """Some of the pictures, from the first to the last, more of the beginning, where more happens."""
    tiles = min(TILES, len(pictures))
    chosen = [pictures[int((len(pictures) - 1) * (i / max(1, tiles - 1))**1.5)] for i in range(tiles)]
    width, height = chosen[0].size
    whole = Image.new("RGB", (width * min(COLUMNS, tiles), height * -(-tiles // COLUMNS)))
    for i, picture in enumerate(chosen):
        whole.paste(picture, (width * (i % COLUMNS), height * (i // COLUMNS)))
    return whole
