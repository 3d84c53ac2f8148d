package collided

// Masks of Contacts.Features. The closest points are p, of the first feature, and q, of the second.
const (
	// NearerAtFirst: the first feature's surface comes clearly nearer beside p.
	NearerAtFirst = byte(16)
	// NearerAtSecond: the second feature's surface comes clearly nearer beside q.
	NearerAtSecond = byte(32)
	// SameAsBefore: an earlier contact is between the same two features; VertexTriangle comes before EdgeEdge.
	SameAsBefore = byte(64)
)

// TrianglePlace is where q is on the triangle of a vertex and a triangle. Corners are counted from 1, in the order of the stencil.
type TrianglePlace byte

// Within the face, on the side opposite to a corner, or on a corner. Ties go to the corner, then to the side.
const (
	OnFace TrianglePlace = iota
	OnSide1
	OnSide2
	OnSide3
	OnCorner1
	OnCorner2
	OnCorner3
)

// PlaceOnTriangle reads a byte of Features of VertexTriangle contacts.
//
//	if collided.PlaceOnTriangle(contacts.Features[i]) == collided.OnFace {
func PlaceOnTriangle(features byte) TrianglePlace { return TrianglePlace(features & 7) }

// EdgePlace is where the closest point of an edge is. Its ends are those of the stencil, in its order.
type EdgePlace byte

// Within the edge, or on an end. Ties go to the end.
const (
	Inside EdgePlace = iota
	OnEnd1
	OnEnd2
)

// PlacesOnEdges reads a byte of Features of EdgeEdge contacts. p is on the first edge, q on the second.
//
//	if p, q := collided.PlacesOnEdges(contacts.Features[i]); p == collided.Inside && q == collided.Inside {
func PlacesOnEdges(features byte) (p, q EdgePlace) {
	return EdgePlace(features & 3), EdgePlace(features >> 2 & 3)
}

// Kept returns the ascending indices of the contacts that no other one covers. They have each local minimum of distance between
// two surfaces once. So all of them have one direction on a flat floor, which is what a rigid-body solver needs. Nothing is covered
// unless SceneSpec.Fields names FieldFeatures and FieldFlags, and SceneSpec.Kinds VertexTriangle and EdgeEdge.
//
//	for _, i := range output.VertexTriangle.Kept() {
//		push(contacts.Stencils[i], contacts.Normals[i], contacts.Distance[i])
//	}
func (c *Contacts) Kept() []int {
	kept := make([]int, 0, c.Count)
	for i := 0; i < c.Count; i++ {
		if len(c.Flags) == 0 || c.Flags[i]&IsCovered == 0 {
			kept = append(kept, i)
		}
	}
	return kept
}
