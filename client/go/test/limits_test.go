package test

import (
	"math"
	"reflect"
	"testing"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

const gap = 0.25 // that the tip keeps above the floor

// limitedScene needs no field of contacts but the times.
func limitedScene() *collided.SceneSpec {
	return &collided.SceneSpec{Mode: collided.CCD, MinSeparation: gap, Fields: []v1.ContactField{collided.FieldTOI}}
}

func limited(id uint64, depth float32) collided.Frame {
	return collided.Frame{ID: id, Advance: true, AdvanceMode: collided.PerVertex, Limits: true,
		Updates: []collided.Update{{Mesh: 1, Positions: tipAt(1 - depth)}}}
}

// checkLimited expects the tip's way down from 1 by `depth` to be limited by the floor.
func checkLimited(t *testing.T, output *collided.Output, depth float32) {
	t.Helper()
	c := output.Limits.VertexTriangle
	same(t, [3]int{c.Count, output.Limits.EdgeEdge.Count, output.Limits.TriangleTriangle.Count}, [3]int{1, 0, 0})
	same(t, c.Elements[0], [2]uint32{3, 0})
	same(t, c.Stencils[0], [4]uint32{3, 0, 1, 2})
	same(t, c.Distance[0], gap)
	same(t, c.Normals[0], [3]float32{0, 0, 1})
	same(t, len(c.Flags), 1)
	x := f64(tipAt(1))
	must(t, collided.MoveAlong(x, f64(tipAt(1-depth)), c.TOI[0]))
	if above := x[0][2] - gap; above < 0 || above > 1e-3 {
		t.Fatal(c.TOI[0], "is", above, "above where the tip comes to the distance")
	}
	if w := c.Weights[0]; math.Abs(w[0]-0.25) > 1e-6 || math.Abs(w[1]-0.25) > 1e-6 {
		t.Fatal(w)
	}
	same(t, output.Done.ContactCount, 1)
	same(t, len(output.Done.Limits), 0)
	same(t, len(output.VertexTriangle.Elements), 0)
}

func TestLimitsTellWhenAPairComesToWhatItKeeps(t *testing.T) {
	ctx, client := connected(t)
	scene := create(ctx, t, client, limitedScene(), twoTriangles())
	start := first(floor, tipAt(1))
	start.ID = 1
	_, err := client.Detect(ctx, scene, start)
	must(t, err)
	trial := limited(2, 2)
	trial.Trial = true
	unary, err := client.Detect(ctx, scene, trial)
	must(t, err)
	checkLimited(t, unary, 2)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	streamed := detect(ctx, t, s, limited(0, 2))
	checkLimited(t, streamed, 2)
	if !reflect.DeepEqual(unary.Limits, streamed.Limits) {
		t.Fatal(unary.Limits, streamed.Limits)
	}
	must(t, s.Finish(ctx))
}

func TestThereAreNoLimitsWhereNothingBlocksAndWhereNobodyAsks(t *testing.T) {
	ctx, client := connected(t)
	s := stream(ctx, t, client, create(ctx, t, client, limitedScene(), twoTriangles()), collided.StreamOptions{})
	detect(ctx, t, s, first(floor, tipAt(1)))
	quiet := limited(0, 2)
	quiet.Limits, quiet.Trial = false, true
	for _, frame := range []collided.Frame{limited(0, 0.5), quiet} {
		if output := detect(ctx, t, s, frame); !reflect.DeepEqual(output.Limits, collided.ContactSet{}) {
			t.Fatal(output.Limits)
		}
	}
	plain := limited(0, 2)
	plain.Advance, plain.AdvanceMode = false, 0
	_, err := s.Detect(ctx, plain)
	refused(t, err, codes.InvalidArgument, "frame.limits", "advance")
	must(t, s.Finish(ctx))
}
