"""Names of what the add-on makes."""

PREFIX = "collided"
CONTACTS = f"{PREFIX} contacts"  # object, vertex group
CROSSINGS = f"{PREFIX} crossings"
FACES = f"{PREFIX} faces"
MARKER = f"{PREFIX}: "
