package collided

import v1 "collided.invalid/client/go/v1"

// ElementKind is what the second feature of a vertex-triangle contact is.
type ElementKind int

// A loose edge a b has the stencil v a b b, a loose point a has v a a a.
const (
	Triangle ElementKind = iota
	Edge
	Point
)

// ElementKindOf tells what a vertex met, by the stencil of a vertex-triangle contact.
func ElementKindOf(stencil [4]uint32) ElementKind {
	switch {
	case stencil[2] != stencil[3]:
		return Triangle
	case stencil[1] != stencil[2]:
		return Edge
	}
	return Point
}

// ContactPoints are the closest points of the two features of each contact at its time of impact (CCD) or in the frame
// (DCD: without start), by the formulas of proto/CONVENTIONS.md. start and end are the positions of all vertices of the
// scene at t = 0 and t = 1. Kinds are VertexTriangle, EdgeEdge and VertexSolid. The contacts need stencils and weights (FieldWeights) and, with start, TOI;
// InvalidArgument without them.
func ContactPoints[T Real](kind v1.ContactKind, contacts *Contacts, start, end [][3]T) (first, second [][3]float64, err error) {
	if err := checkPoints(kind, contacts, len(start), len(end)); err != nil {
		return nil, nil, err
	}
	first, second = make([][3]float64, contacts.Count), make([][3]float64, contacts.Count)
	for i, stencil := range contacts.Stencils {
		w0, w1 := contacts.Weights[i][0], contacts.Weights[i][1]
		for axis := range first[i] {
			var x [4]float64
			for k, vertex := range stencil {
				x[k] = float64(end[vertex][axis])
				if start != nil {
					x[k] = (1-contacts.TOI[i])*float64(start[vertex][axis]) + contacts.TOI[i]*x[k]
				}
			}
			if kind != EdgeEdge {
				first[i][axis], second[i][axis] = x[0], (1-w0-w1)*x[1]+w0*x[2]+w1*x[3]
			} else {
				first[i][axis], second[i][axis] = (1-w0)*x[0]+w0*x[1], (1-w1)*x[2]+w1*x[3]
			}
		}
	}
	return first, second, nil
}

func checkPoints(kind v1.ContactKind, c *Contacts, starts, ends int) error {
	if kind != VertexTriangle && kind != EdgeEdge && kind != VertexSolid {
		return invalidf("kind", "is %v, which has no points", kind)
	}
	if len(c.Stencils) != c.Count || len(c.Weights) != c.Count || starts > 0 && len(c.TOI) != c.Count {
		return invalidf("contacts", "have %d stencils, %d weights and %d times for %d contacts; ask for these fields",
			len(c.Stencils), len(c.Weights), len(c.TOI), c.Count)
	}
	if starts > 0 && starts != ends {
		return invalidf("start", "has %d vertices, end has %d", starts, ends)
	}
	for _, stencil := range c.Stencils {
		for _, vertex := range stencil {
			if int64(vertex) >= int64(ends) {
				return invalidf("end", "has %d vertices, but a contact has vertex %d: pass those of the whole scene", ends, vertex)
			}
		}
	}
	return nil
}
