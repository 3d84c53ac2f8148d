"""What a scene asks for; saved with the file."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

_LEVELS = (
    ("FAST", "Fast", "May miss a contact; needs a distance above 0"),
    ("GUARDED", "Guarded", "Misses no contact"),
    ("CERTIFIED", "Certified", "Misses no contact, and is as sharp as double precision allows"),
    ("EXACT", "Exact", "As if computed in real numbers: no contact more or less"),
)


class Settings(bpy.types.PropertyGroup):
    accuracy: EnumProperty(name="Accuracy", items=_LEVELS, default="CERTIFIED", description="What is guaranteed")
    distance: FloatProperty(
        name="Distance", subtype="DISTANCE", min=0, precision=4, step=0.1,
        description="How close two surfaces are to be in contact. 0: they touch. Crossings do not depend on it")
    self_contacts: BoolProperty(
        name="Self Contacts", default=True, description="Whether each object is also tested with itself")
    skip_rings: IntProperty(
        name="Skip Neighbors", min=0, max=8, default=1,
        description="Within an object, leave out what so many edges or fewer connect: it is close by construction. Only with a "
        "distance above 0")
    summary: StringProperty(options={"HIDDEN"})

    @property
    def exclude_rings(self):
        """Touching neighbours are of interest, near ones are not."""
        return self.skip_rings if self.distance > 0 else 0
