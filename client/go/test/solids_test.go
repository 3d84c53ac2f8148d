package test

import (
	"math"
	"testing"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

// boxSides are the triangles of a box, whose normals point outside. Vertex i is at (i & 1, i >> 1 & 1, i >> 2).
var boxSides = [][3]uint32{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6},
	{1, 3, 5}, {3, 7, 5}}

// boxAt is a box with this side whose lowest corner is at (x, y, z).
func boxAt(x, y, z, side float64) collided.F64 {
	box := make(collided.F64, 8)
	for i := range box {
		box[i] = [3]float64{x + side*float64(i&1), y + side*float64(i>>1&1), z + side*float64(i>>2)}
	}
	return box
}

func boxes() []collided.Mesh {
	return []collided.Mesh{{Name: "room", VertexCount: 8, Triangles: boxSides, Solid: true, NoSelfContacts: true},
		{Name: "box", VertexCount: 8, Triangles: boxSides, Solid: true, NoSelfContacts: true}}
}

func solidScene(kinds ...v1.ContactKind) *collided.SceneSpec {
	return &collided.SceneSpec{Mode: collided.DCD, Accuracy: collided.Exact, PositionFormat: collided.FormatF64, Thickness: 0.75, Kinds: kinds,
		Fields: []v1.ContactField{collided.FieldElements, collided.FieldStencil, collided.FieldDistance, collided.FieldNormal,
			collided.FieldWeights, collided.FieldPairStates, collided.FieldSignedDistance}}
}

// placed has the room with its lowest corner at 0, of side 4, and a box of side 1.
func placed(id uint64, box collided.F64) collided.Frame {
	return collided.Frame{ID: id, Updates: []collided.Update{{Mesh: 0, Positions: boxAt(0, 0, 0, 4)}, {Mesh: 1, Positions: box}}}
}

func TestMeshesAreApartTouchOverlapOrAreInsideEachOther(t *testing.T) {
	ctx, client := connected(t)
	scene := create(ctx, t, client, solidScene(collided.VertexTriangle, collided.VertexSolid), boxes())
	for i, want := range []struct {
		z      float64
		state  v1.MeshPairState
		inside uint32
		depth  float64
	}{
		{4.5, 0, 0, 0},
		{4, collided.PairTouching, 0, 0},
		{3.5, collided.PairOverlapping, 4, 0.5},
		{1.5, collided.PairSecondInside, 8, 1.5},
	} {
		output, err := client.Detect(ctx, scene, placed(uint64(i+1), boxAt(1.25, 1.5, want.z, 1)))
		must(t, err)
		if want.state == 0 {
			same(t, len(output.Pairs), 0)
			continue
		}
		same(t, len(output.Pairs), 1)
		pair := output.Pairs[0]
		same(t, [4]uint32{pair.First, pair.Second, pair.FirstInside, pair.SecondInside}, [4]uint32{0, 1, 0, want.inside})
		same(t, pair.State, want.state)
		same(t, pair.Deepest == collided.NoVertex, want.inside == 0)
		if want.inside == 4 {
			same(t, pair.Depth, want.depth)
		}
		same(t, output.VertexSolid.Count, int(want.inside))
		same(t, output.Done.Metrics.Counts.ContactsVertexSolid, uint64(want.inside))
	}
}

func TestAVertexInASolidHasADepthAndASignedDistance(t *testing.T) {
	ctx, client := connected(t)
	scene := create(ctx, t, client, solidScene(collided.VertexTriangle, collided.EdgeEdge, collided.VertexSolid), boxes())
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	inner := boxAt(1.25, 1.5, 2.5, 1) // with its upper side 0.5 below that of the room
	output := detect(ctx, t, s, placed(1, inner))
	deep := output.VertexSolid
	same(t, deep.Count, 8)
	same(t, deep.Elements[4][0], 12)
	same(t, deep.Distance[4], -0.5)
	same(t, deep.Normals[4], [3]float32{0, 0, 1})
	all := append(append([][3]float64{}, boxAt(0, 0, 0, 4)...), inner...)
	p, q, err := collided.ContactPoints(collided.VertexSolid, &deep, nil, all)
	must(t, err)
	same(t, p[4], [3]float64{1.25, 1.5, 3.5})
	if math.Abs(q[4][2]-4) > 1e-12 {
		t.Fatal(q[4])
	}
	if output.VertexTriangle.Count == 0 {
		t.Fatal("no vertex is near a side")
	}
	for i, distance := range output.VertexTriangle.SignedDistances {
		same(t, distance, -output.VertexTriangle.Distance[i])
	}
	must(t, s.Finish(ctx))
}

func TestWhatIsNoSolidIsRefused(t *testing.T) {
	ctx, client := connected(t)
	open := boxes()
	open[1].Triangles = boxSides[1:]
	_, err := client.CreateScene(ctx, solidScene(), open, 0)
	refused(t, err, codes.InvalidArgument, "spec.meshes[1].solid", "edge")
	hollow := boxes()
	hollow[0].Solid, hollow[1].Solid = false, false
	_, err = client.CreateScene(ctx, solidScene(), hollow, 0)
	refused(t, err, codes.InvalidArgument, "spec.fields[5]", "PAIR_STATES")
}
