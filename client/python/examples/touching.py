"""What of a mesh file is closer to itself than a thickness, in the file's unit: touching.py FILE THICKNESS"""

import sys

import collided

file, thickness = sys.argv[1:] if len(sys.argv) == 3 else sys.exit(__doc__)
mesh = collided.Mesh.read(file)
contacts = collided.proximity(mesh.vertices, mesh.triangles, thickness=float(thickness))
print(repr(contacts))
for name, some in (("vertex {} and triangle {}", contacts.vt), ("edges {} and {}", contacts.ee)):
    for elements, distance in list(zip(some.elements, some.distance))[:5]:
        print(f"{name.format(*elements)}: {distance:.6g} apart")
