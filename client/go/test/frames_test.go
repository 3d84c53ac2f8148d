package test

import (
	"math"
	"reflect"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

func TestAContactIsWhereItWasBuiltIn(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	output, err := client.Detect(ctx, scene, fall(1, 2))
	must(t, err)
	contacts := output.VertexTriangle
	same(t, [3]int{contacts.Count, output.EdgeEdge.Count, output.TriangleTriangle.Count}, [3]int{1, 0, 0})
	same(t, contacts.Elements[0], [2]uint32{3, 0})
	same(t, contacts.Stencils[0], [4]uint32{3, 0, 1, 2})
	if toi := contacts.TOI[0]; toi > 0.5 || toi < 0.499 || toi != output.Done.EarliestToi {
		t.Fatal(toi)
	}
	same(t, contacts.Flags[0]&collided.IsInitial, 0)
	same(t, output.Done.ContactCount, 1)
}

// Two triangles with the corner 0, of which the second one goes through the first.
func TestAnEdgeGoesThroughANeighbour(t *testing.T) {
	ctx, client := connected(t)
	folded := collided.F64{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 1, -1}, {2, 1.5, 2}}
	meshes := []collided.Mesh{{Name: "folded", VertexCount: 5, Triangles: [][3]uint32{{0, 1, 2}, {0, 3, 4}}}}
	spec := &collided.SceneSpec{Mode: collided.DCD, Accuracy: collided.Exact, PositionFormat: collided.FormatF64,
		Kinds:  []v1.ContactKind{collided.VertexTriangle, collided.EdgeEdge, collided.TriangleTriangle, collided.EdgeTriangle},
		Fields: []v1.ContactField{collided.FieldElements, collided.FieldWeights, collided.FieldFlags}}
	frame := collided.Frame{ID: 1, Updates: []collided.Update{{Mesh: 0, Positions: folded}}}
	output, err := client.Detect(ctx, create(ctx, t, client, spec, meshes), frame)
	must(t, err)
	crossings := output.EdgeTriangle
	same(t, [2]int{crossings.Count, len(crossings.Flags)}, [2]int{1, 1})
	same(t, crossings.Elements[0], [2]uint32{5, 0})
	if w := crossings.Weights[0]; math.Abs(w[0]-0.5) > 1e-12 || math.Abs(w[1]-7.0/24) > 1e-12 {
		t.Fatal(w)
	}
	same(t, crossings.Flags[0], collided.IsCertified)
	same(t, [2]int{output.TriangleTriangle.Count, int(output.Done.ContactCount)}, [2]int{1, 2})
	spec.Mode = collided.CCD
	_, err = client.CreateScene(ctx, spec, meshes, 0)
	refused(t, err, codes.InvalidArgument, "spec.kinds[3]", "EDGE_TRIANGLE")
}

// A tip stands above the diagonal of a square.
func TestOfAVertexAboveASideOneContactIsKept(t *testing.T) {
	ctx, client := connected(t)
	meshes := []collided.Mesh{{Name: "floor", VertexCount: 4, Triangles: [][3]uint32{{0, 1, 2}, {0, 2, 3}}},
		{Name: "spike", VertexCount: 3, Triangles: [][3]uint32{{0, 1, 2}}}}
	spec := &collided.SceneSpec{Mode: collided.DCD, Thickness: 0.02, PositionFormat: collided.FormatF64,
		Fields: []v1.ContactField{collided.FieldElements, collided.FieldFlags, collided.FieldFeatures}}
	frame := collided.Frame{ID: 1, Updates: []collided.Update{
		{Mesh: 0, Positions: collided.F64{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
		{Mesh: 1, Positions: collided.F64{{0.5, 0.5, 0.001}, {0.25, 0.5, 1}, {0.75, 0.625, 1}}}}}
	output, err := client.Detect(ctx, create(ctx, t, client, spec, meshes), frame)
	must(t, err)
	vt, ee := output.VertexTriangle, output.EdgeEdge
	same(t, [2]int{vt.Count, ee.Count}, [2]int{2, 2})
	same(t, collided.PlaceOnTriangle(vt.Features[0]), collided.OnSide2)
	same(t, collided.PlaceOnTriangle(vt.Features[1]), collided.OnSide3)
	p, q := collided.PlacesOnEdges(ee.Features[0])
	same(t, [2]collided.EdgePlace{p, q}, [2]collided.EdgePlace{collided.Inside, collided.OnEnd1})
	same(t, vt.Features[1]&collided.SameAsBefore, collided.SameAsBefore)
	if kept := vt.Kept(); !reflect.DeepEqual(kept, []int{0}) || len(ee.Kept()) != 0 {
		t.Fatal(kept, ee.Kept())
	}
}

func TestIDsHaveAllTheirBits(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	for _, id := range []uint64{1<<53 + 1, 1<<63 - 1} {
		output, err := client.Detect(ctx, scene, fall(id, 2))
		must(t, err)
		same(t, output.FrameID, id)
	}
	for _, id := range []uint64{0, 1 << 63} {
		_, err := client.Detect(ctx, scene, fall(id, 2))
		refused(t, err, codes.InvalidArgument, "frame.frame_id", ".")
	}
}

func TestOptionsHoldForTheirFrameAlone(t *testing.T) {
	ctx, client := connected(t)
	s := fallStream(ctx, t, client)
	delta := 1e-3
	hit := fall(0, 2)
	hit.Report, hit.Accuracy, hit.Delta = collided.ReportAnyHit, collided.Fast, &delta
	output := detect(ctx, t, s, hit)
	same(t, output.VertexTriangle.Count, 0)
	same(t, output.Done.AnyContact, true)
	same(t, detect(ctx, t, s, fall(0, 4)).VertexTriangle.Count, 1)
	same(t, detect(ctx, t, s, fall(0, 0.5)).VertexTriangle.Count, 0)
	must(t, s.Finish(ctx))
}

func TestARefusedFrameLeavesTheStreamOpen(t *testing.T) {
	ctx, client := connected(t)
	s := fallStream(ctx, t, client)
	detect(ctx, t, s, fall(0, 2))
	bad := tipAt(1)
	bad[1][2] = float32(math.NaN())
	two := 2.0
	one := func(update collided.Update) collided.Frame { return collided.Frame{Updates: []collided.Update{update}} }
	cases := []struct {
		frame collided.Frame
		field string
		says  string
	}{
		{one(collided.Update{Mesh: 1, Positions: bad}), "frame.updates[0].positions", "(?i)nan"},
		{one(collided.Update{Mesh: 1, Positions: bad[:2]}), "frame.updates[0].positions", "24"},
		{one(collided.Update{Mesh: 7, Positions: floor}), "frame.updates[0].mesh", "7"},
		{one(collided.Update{Mesh: 1, Positions: collided.F64{}}), "frame.updates[0].positions", "is collided.F64; .*F32"},
		{one(collided.Update{Mesh: 1, StartTransform: &collided.Matrix{}}), "frame.updates[0].rigid.start_matrix", "StartTransform.*needs Transform"},
		{collided.Frame{FromLastFraction: &two}, "frame.from_last_fraction", "2"},
	}
	for _, c := range cases {
		_, err := s.Detect(ctx, c.frame)
		refused(t, err, codes.InvalidArgument, c.field, c.says)
	}
	_, err := s.Detect(ctx, fall(1, 2))
	refused(t, err, codes.FailedPrecondition, "frame.frame_id", ".")
	same(t, detect(ctx, t, s, fall(0, 4)).VertexTriangle.Count, 1)
	must(t, s.Finish(ctx))
}

func TestARefusalTellsWhenToTryAgain(t *testing.T) {
	ctx, client := connected(t, "--max-frames-per-second", "1")
	s := fallStream(ctx, t, client)
	var refusal *collided.Error
	for refusal == nil {
		if _, err := s.Detect(ctx, fall(0, 2)); err != nil {
			refusal = err.(*collided.Error)
		}
	}
	same(t, refusal.Code, codes.ResourceExhausted)
	if refusal.RetryAfter <= 0 || refusal.RetryAfter > time.Second {
		t.Fatal(refusal.RetryAfter)
	}
}

func TestAFrameThatIsTooLargeIsRefusedBeforeItIsSent(t *testing.T) {
	ctx, client := connected(t, "--max-message-mb", "4")
	meshes, positions := sheets(60)
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.DCD, Thickness: 0.5}, meshes)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	var many collided.Frame
	for len(many.Updates)*44652 < 4<<20 {
		many.Updates = append(many.Updates, collided.Update{Mesh: 0, Positions: positions[0]})
	}
	_, err := s.Detect(ctx, many)
	refused(t, err, codes.ResourceExhausted, "frame", `bytes; the daemon's limit is \d+`)
	both := collided.Frame{Updates: []collided.Update{{Mesh: 0, Positions: positions[0]}, {Mesh: 1, Positions: positions[1]}}}
	both.Report = collided.ReportAnyHit
	same(t, detect(ctx, t, s, both).Done.AnyContact, true)
}

func TestContactsOfManyChunksAreTheSame(t *testing.T) {
	ctx, client := connected(t)
	meshes, positions := sheets(40)
	fields := []v1.ContactField{collided.FieldElements, collided.FieldStencil,
		collided.FieldDistance, collided.FieldWeights, collided.FieldFlags}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.DCD, Thickness: 0.5, Fields: fields}, meshes)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	frame := collided.Frame{Updates: []collided.Update{{Mesh: 0, Positions: positions[0]}, {Mesh: 1, Positions: positions[1]}}}
	first, second := detect(ctx, t, s, frame), detect(ctx, t, s, frame)
	if first.Done.Metrics.BytesOut < 2<<20 {
		t.Fatal("one chunk is no test")
	}
	for _, c := range []collided.Contacts{first.VertexTriangle, first.EdgeEdge} {
		lengths := []int{len(c.Elements), len(c.Stencils), len(c.Distance), len(c.Weights), len(c.Flags), len(c.TOI)}
		if !reflect.DeepEqual(lengths, []int{c.Count, c.Count, c.Count, c.Count, c.Count, 0}) {
			t.Fatal(c.Count, lengths)
		}
	}
	if !reflect.DeepEqual(first.ContactSet, second.ContactSet) {
		t.Fatal("contacts differ")
	}
}
