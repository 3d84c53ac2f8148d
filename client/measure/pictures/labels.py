"""Labels of points, each placed where nothing else is; a label without a free place is left out."""

MARKER = 8  # points, the size of what a marker covers
PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.3}
# Where a label may go, by preference: horizontal and vertical shift from its point, and its alignment.
RIGHT, LEFT = (8, 0, "left"), (-8, 0, "right")
ABOVE, BELOW = (0, 10, "center"), (0, -10, "center")


class Labels:
    def __init__(self, panel, points):
        """`points` are those of the panel, whose limits are set and whose markers no label covers."""
        self.panel = panel
        self.taken = [self.box(point, (0, 0, "center"), MARKER, MARKER) for point in points]

    def put(self, text, point, places, size=8, **style):
        for place in places:
            box = self.box(point, place, 0.62 * size * len(text), 1.2 * size)
            if self.is_free(box):
                self.taken.append(box)
                self.panel.annotate(text, point, xytext=place[:2], textcoords="offset points", ha=place[2], va="center",
                                    fontsize=size, bbox=PAPER, zorder=4, **style)
                return

    def box(self, point, place, width, height):
        """Left, bottom, right and top, in points of 1/72 inch."""
        x, y = self.panel.transData.transform(point) * 72 / self.panel.figure.dpi
        left = x + place[0] - {"left": 0, "center": width / 2, "right": width}[place[2]]
        bottom = y + place[1] - height / 2
        return left, bottom, left + width, bottom + height

    def is_free(self, box):
        return not any(box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
                       for other in self.taken)
