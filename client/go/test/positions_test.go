package test

import (
	"math"
	"reflect"
	"testing"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

// seen is a frame's totals, and where the daemon has the vertices of mesh 1 after it.
type seen struct {
	done      *v1.FrameDone
	shortened collided.Shortened
	positions collided.Positions
}

func whereTheDaemonHasThem(t *testing.T, spec *collided.SceneSpec, meshes []collided.Mesh, frames []collided.Frame) (out []seen) {
	t.Helper()
	ctx, client := connected(t)
	scene := create(ctx, t, client, spec, meshes)
	watcher, err := client.Watch(ctx, scene.SceneId, collided.WatchOptions{PositionMeshes: []uint32{1}})
	must(t, err)
	defer watcher.Close()
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	for _, frame := range frames {
		output := detect(ctx, t, s, frame)
		shown, err := watcher.Receive()
		must(t, err)
		out = append(out, seen{output.Done, output.Shortened, shown.Positions[0].Positions})
	}
	must(t, s.Finish(ctx))
	return out
}

func f64(positions collided.F32) (out collided.F64) {
	for _, p := range positions {
		out = append(out, [3]float64{float64(p[0]), float64(p[1]), float64(p[2])})
	}
	return out
}

// steps end in a fall that is cut short.
func steps(x collided.F32) (out []collided.F32) {
	for step, drop := range []float32{0.3, 0.7, 1.9} {
		p := append(collided.F32{}, x...)
		for i := range p {
			p[i][0] += 0.013 * float32(i+step)
			p[i][1] += 0.017 * float32(i+step)
			p[i][2] -= drop
		}
		out = append(out, p)
	}
	return out
}

func TestMoveAlongGoesWhereTheDaemonGoes(t *testing.T) {
	x := tipAt(1.1)
	x64 := f64(x)
	narrow, wide := []collided.Frame{first(floor, x)}, []collided.Frame{first(f64(floor), x64)}
	for _, p := range steps(x) {
		narrow = append(narrow, collided.Frame{Advance: true, Updates: []collided.Update{{Mesh: 1, Positions: p}}})
		wide = append(wide, collided.Frame{Advance: true, Updates: []collided.Update{{Mesh: 1, Positions: f64(p)}}})
	}
	spec := &collided.SceneSpec{Mode: collided.CCD, MinSeparation: 1e-3}
	asF32 := whereTheDaemonHasThem(t, spec, twoTriangles(), narrow)
	spec.PositionFormat = collided.FormatF64
	asF64 := whereTheDaemonHasThem(t, spec, twoTriangles(), wide)
	for i, p := range steps(x) {
		must(t, collided.MoveAlong(x, p, asF32[i+1].done.GetAdvanced()))
		must(t, collided.MoveAlong(x64, f64(p), asF64[i+1].done.GetAdvanced()))
		if !reflect.DeepEqual(asF32[i+1].positions, x) || !reflect.DeepEqual(asF64[i+1].positions, x64) {
			t.Fatal(i, asF32[i+1].positions, x, asF64[i+1].positions, x64)
		}
	}
	if a := asF64[3].done.GetAdvanced(); a <= 0 || a >= 1 {
		t.Fatal(a, "tests no rounding")
	}
}

func TestEachMeshAndVertexGoesWhereTheDaemonHasIt(t *testing.T) {
	for _, mode := range []v1.AdvanceMode{collided.PerMesh, collided.PerVertex} {
		x := tipAt(1.1)
		frames := []collided.Frame{first(floor, x)}
		for _, p := range steps(x) {
			frames = append(frames, collided.Frame{Advance: true, AdvanceMode: mode, Updates: []collided.Update{{Mesh: 1, Positions: p}}})
		}
		there := whereTheDaemonHasThem(t, &collided.SceneSpec{Mode: collided.CCD, MinSeparation: 1e-3}, twoTriangles(), frames)
		for i, p := range steps(x) {
			shortened := there[i+1].shortened
			if mode == collided.PerMesh {
				must(t, collided.MoveAlong(x, p, shortened.Of(1, 1)[0]))
			} else {
				must(t, collided.MoveEachAlong(x, p, shortened.Of(3, 3)))
			}
			if !reflect.DeepEqual(there[i+1].positions, x) {
				t.Fatal(mode, i, there[i+1].positions, x)
			}
		}
		last := there[3]
		if len(last.shortened.IDs) == 0 || !(last.done.GetAdvanced() < 1) || !(last.done.GetWay() >= last.done.GetAdvanced()) {
			t.Fatal(last, "tests no rounding")
		}
	}
}

func TestEachVertexGoesItsOwnWay(t *testing.T) {
	x, p := collided.F32{}, collided.F32{}
	fractions := []float64{1.0 / 3, 0, 1, 127.0 / 128, 1e-300, 0.7}
	for i := range fractions {
		x = append(x, [3]float32{1.1 * float32(i), -7e5, 1e-6})
		p = append(p, [3]float32{0.3 - float32(i), 2.0 / 3, 1e7})
	}
	x64, p64 := f64(x), f64(p)
	var expected collided.F32
	var expected64 collided.F64
	for i, fraction := range fractions {
		one, one64 := append(collided.F32{}, x[i]), append(collided.F64{}, x64[i])
		must(t, collided.MoveAlong(one, p[i:i+1], fraction))
		must(t, collided.MoveAlong(one64, p64[i:i+1], fraction))
		expected, expected64 = append(expected, one...), append(expected64, one64...)
	}
	must(t, collided.MoveEachAlong(x, p, fractions))
	must(t, collided.MoveEachAlong(x64, p64, fractions))
	if !reflect.DeepEqual(x, expected) || !reflect.DeepEqual(x64, expected64) {
		t.Fatal(x, expected, x64, expected64)
	}
}

func TestHowFarEachWentIsOneUnlessItIsShortened(t *testing.T) {
	shortened := collided.Shortened{IDs: []uint32{3, 4, 9, math.MaxUint32}, Fractions: []float64{0.5, 0, 0.25, 0.125}}
	for _, c := range []struct {
		shortened collided.Shortened
		first     uint32
		expected  []float64
	}{
		{shortened, 4, []float64{0, 1, 1, 1, 1, 0.25}},
		{shortened, 0, []float64{1, 1, 1}},
		{shortened, math.MaxUint32, []float64{0.125}},
		{shortened, 10, []float64{1, 1}},
		{shortened, 3, []float64{}},
		{collided.Shortened{}, 0, []float64{1, 1}},
	} {
		if has := c.shortened.Of(c.first, len(c.expected)); !reflect.DeepEqual(has, c.expected) {
			t.Fatal(c, has)
		}
	}
}

func first(still, moving collided.Positions) collided.Frame {
	return collided.Frame{Updates: []collided.Update{{Mesh: 0, Positions: still}, {Mesh: 1, Positions: moving}}}
}

func TestMoveRigidlyGoesWhereTheDaemonGoes(t *testing.T) {
	c, s := math.Cos(0.7), math.Sin(0.7)
	pose := &collided.Matrix{c, -s, 0, 0.1, s, c, 0, -0.3, 0, 0, 1, 1.0 / 3}
	meshes := twoTriangles()
	meshes[1].Motion = collided.Rigid
	x := tipAt(1.1)
	x64 := f64(x)
	move := collided.Frame{Updates: []collided.Update{{Mesh: 1, Transform: pose}}}
	spec := &collided.SceneSpec{Mode: collided.CCD}
	asF32 := whereTheDaemonHasThem(t, spec, meshes, []collided.Frame{first(floor, x), move})
	spec.PositionFormat = collided.FormatF64
	asF64 := whereTheDaemonHasThem(t, spec, meshes, []collided.Frame{first(f64(floor), x64), move})
	collided.MoveRigidly(x, pose)
	collided.MoveRigidly(x64, pose)
	if !reflect.DeepEqual(asF32[1].positions, x) || !reflect.DeepEqual(asF64[1].positions, x64) {
		t.Fatal(asF32[1].positions, x, asF64[1].positions, x64)
	}
	same(t, asF32[1].done.Metrics.BytesIn, 96)
}

// bodyTurned turns the tip about a line through (1, 1, 1), and moves it down.
func bodyTurned(angle, depth float64) *collided.Matrix {
	c, s := math.Cos(angle), math.Sin(angle)
	return &collided.Matrix{1, 0, 0, 0, 0, c, -s, 1 - c + s, 0, s, c, 1 - c - s - depth}
}

func TestPoseAlongGoesWhereTheDaemonGoes(t *testing.T) {
	meshes := twoTriangles()
	meshes[1].Motion = collided.Rigid
	targets := []*collided.Matrix{bodyTurned(0.3, 0.2), bodyTurned(1.2, 2.5), bodyTurned(0.1, 3)}
	for _, mode := range []v1.AdvanceMode{collided.PerMesh, collided.PerVertex} {
		x := tipAt(1.1)
		narrow, wide := []collided.Frame{first(floor, x)}, []collided.Frame{first(f64(floor), f64(x))}
		for _, target := range targets {
			step := collided.Frame{Advance: true, AdvanceMode: mode, Updates: []collided.Update{{Mesh: 1, Transform: target}}}
			narrow, wide = append(narrow, step), append(wide, step)
		}
		spec := &collided.SceneSpec{Mode: collided.CCD, MinSeparation: 1e-2}
		asF32 := whereTheDaemonHasThem(t, spec, meshes, narrow)
		spec.PositionFormat = collided.FormatF64
		asF64 := whereTheDaemonHasThem(t, spec, meshes, wide)
		fractionOf := func(there seen) float64 {
			if mode == collided.PerMesh {
				return there.shortened.Of(1, 1)[0]
			}
			each := there.shortened.Of(3, 3)
			return math.Min(each[0], math.Min(each[1], each[2]))
		}
		pose, pose64, err := atRest(), atRest(), error(nil)
		for i, target := range targets {
			pose, err = collided.PoseAlong(pose, target, fractionOf(asF32[i+1]))
			must(t, err)
			pose64, err = collided.PoseAlong(pose64, target, fractionOf(asF64[i+1]))
			must(t, err)
			moved, moved64 := append(collided.F32{}, x...), f64(x)
			collided.MoveRigidly(moved, pose)
			collided.MoveRigidly(moved64, pose64)
			if !reflect.DeepEqual(asF32[i+1].positions, moved) || !reflect.DeepEqual(asF64[i+1].positions, moved64) {
				t.Fatal(mode, i, asF32[i+1].positions, moved, asF64[i+1].positions, moved64)
			}
		}
		if a := fractionOf(asF64[2]); a <= 0 || a >= 1 {
			t.Fatal(a, "tests no rounding")
		}
	}
}

func atRest() *collided.Matrix { return &collided.Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0} }

func TestPoseAlongOfWhatDoesNotTurnIsMoveAlongOfItsTranslation(t *testing.T) {
	start, target := bodyTurned(0.7, 1.0/3), bodyTurned(0.7, -9)
	for _, fraction := range []float64{0, 1e-300, 1.0 / 3, 0.5, 127.0 / 128, 1} {
		pose, err := collided.PoseAlong(start, target, fraction)
		must(t, err)
		x := [][3]float64{{start[3], start[7], start[11]}}
		must(t, collided.MoveAlong(x, [][3]float64{{target[3], target[7], target[11]}}, fraction))
		expected := *start
		expected[3], expected[7], expected[11] = x[0][0], x[0][1], x[0][2]
		same(t, *pose, expected)
	}
}

func TestQ16IsPackedAsTheDaemonReadsIt(t *testing.T) {
	box := &collided.QuantizationBox{Lower: []float64{-1, -2, -3}, Upper: []float64{5, 6.5, 9.1}}
	tip, err := collided.PackQuantized(tipAt(1.0/3), box)
	must(t, err)
	ground, err := collided.PackQuantized(floor, box)
	must(t, err)
	spec := &collided.SceneSpec{Mode: collided.CCD, PositionFormat: collided.FormatQ16, QuantizationBox: box}
	there := whereTheDaemonHasThem(t, spec, twoTriangles(), []collided.Frame{first(ground, tip)})
	unpacked, err := collided.UnpackQuantized(tip, box)
	must(t, err)
	if !reflect.DeepEqual(there[0].positions, unpacked) {
		t.Fatal(there[0].positions, unpacked)
	}
	unit := &collided.QuantizationBox{Lower: []float64{0, 0, 0}, Upper: []float64{1, 1, 0}}
	q, err := collided.PackQuantized([][3]float64{{1, 0.5, 0}}, unit)
	must(t, err)
	same(t, q[0], [3]uint16{65535, 32768, 0})
}

func TestHelpersRefuseWhatTheyCannotDo(t *testing.T) {
	unit := &collided.QuantizationBox{Lower: []float64{0, 0, 0}, Upper: []float64{1, 1, 1}}
	three := make([][3]float32, 1)
	_, err := collided.PackQuantized([][3]float64{{0, 2, 0}}, unit)
	refused(t, err, codes.InvalidArgument, "positions[0][1]", "is 2, outside the box, 0 to 1")
	_, err = collided.PackQuantized([][3]float64{{math.NaN(), 0, 0}}, unit)
	refused(t, err, codes.InvalidArgument, "positions[0][0]", "NaN")
	_, err = collided.PackQuantized(three, nil)
	refused(t, err, codes.InvalidArgument, "box", "3 each are needed")
	_, err = collided.PackQuantized(three, &collided.QuantizationBox{Lower: unit.Upper, Upper: unit.Lower})
	refused(t, err, codes.InvalidArgument, "box", "in order")
	_, err = collided.UnpackQuantized(nil, &collided.QuantizationBox{Lower: []float64{math.NaN(), 0, 0}, Upper: unit.Upper})
	refused(t, err, codes.InvalidArgument, "box", "finite")
	refused(t, collided.MoveAlong(three, make([][3]float32, 2), 0.5), codes.InvalidArgument, "target", "has 2 vertices")
	refused(t, collided.MoveAlong(three, three, math.NaN()), codes.InvalidArgument, "fraction", "from 0 to 1")
	refused(t, collided.MoveAlong(three, three, 1.1), codes.InvalidArgument, "fraction", "is 1.1")
	pose := func(start, target *collided.Matrix, fraction float64) error {
		_, err := collided.PoseAlong(start, target, fraction)
		return err
	}
	half := &collided.Matrix{-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 5}
	refused(t, pose(nil, half, 0.5), codes.InvalidArgument, "start", "is nil")
	refused(t, pose(half, nil, 0.5), codes.InvalidArgument, "target", "is nil")
	refused(t, pose(half, half, math.NaN()), codes.InvalidArgument, "fraction", "from 0 to 1")
	refused(t, pose(half, half, -0.1), codes.InvalidArgument, "fraction", "is -0.1")
	refused(t, pose(atRest(), half, 0.5), codes.InvalidArgument, "target", "half a turn from that of start")
	refused(t, pose(atRest(), &collided.Matrix{math.Inf(1)}, 0.5), codes.InvalidArgument, "target", "half a turn from that of start")
	refused(t, pose(&collided.Matrix{math.NaN()}, atRest(), 0.5), codes.InvalidArgument, "target", "half a turn from that of start")
	must(t, pose(atRest(), half, 1))
	two := [][3]float32{{1, 2, 3}, {4, 5, 6}}
	refused(t, collided.MoveEachAlong(two, three, []float64{0, 0}), codes.InvalidArgument, "target", "has 1 vertices")
	refused(t, collided.MoveEachAlong(two, two, []float64{0}), codes.InvalidArgument, "fractions", "has 1 numbers, positions have 2")
	refused(t, collided.MoveEachAlong(two, make([][3]float32, 2), []float64{0.5, math.NaN()}), codes.InvalidArgument, "fractions[1]", "is NaN; it must be from 0 to 1")
	refused(t, collided.MoveEachAlong(two, make([][3]float32, 2), []float64{0.5, -0.1}), codes.InvalidArgument, "fractions[1]", "is -0.1")
	if !reflect.DeepEqual(two, [][3]float32{{1, 2, 3}, {4, 5, 6}}) {
		t.Fatal(two, "was moved by what was refused")
	}
}

func TestContactPointsLieWhereTheConventionsSay(t *testing.T) {
	ctx, client := connected(t)
	fields := []v1.ContactField{collided.FieldStencil, collided.FieldTOI, collided.FieldWeights}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.CCD, Fields: fields}, twoTriangles())
	output, err := client.Detect(ctx, scene, fall(1, 2))
	must(t, err)
	start, end := append(append(collided.F32{}, floor...), tipAt(1)...), append(append(collided.F32{}, floor...), tipAt(-1)...)
	contacts := &output.VertexTriangle
	ours, theirs, err := collided.ContactPoints(collided.VertexTriangle, contacts, start, end)
	must(t, err)
	for _, p := range [][3]float64{ours[0], theirs[0]} {
		if math.Abs(p[0]-1) > 1e-9 || math.Abs(p[1]-1) > 1e-9 || math.Abs(p[2]) > 1e-6 {
			t.Fatal(p)
		}
	}
	same(t, collided.ElementKindOf(contacts.Stencils[0]), collided.Triangle)
	_, _, err = collided.ContactPoints(collided.VertexTriangle, contacts, start[:3], end[:3])
	refused(t, err, codes.InvalidArgument, "end", "has 3 vertices, but a contact has vertex 3")
	_, _, err = collided.ContactPoints(collided.VertexTriangle, contacts, start[:3], end)
	refused(t, err, codes.InvalidArgument, "start", "has 3 vertices, end has 6")
	_, _, err = collided.ContactPoints(collided.VertexTriangle, &collided.Contacts{Count: 1}, nil, end)
	refused(t, err, codes.InvalidArgument, "contacts", "ask for these fields")
}

func TestHairAndParticlesMeetAsEdgesAndPoints(t *testing.T) {
	ctx, client := connected(t)
	meshes := []collided.Mesh{
		{Name: "strand", VertexCount: 3, Edges: [][2]uint32{{0, 1}, {1, 2}}},
		{Name: "drops", VertexCount: 3, Points: []uint32{0, 1, 2}},
	}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.CCD, Thickness: 0.02}, meshes)
	output, err := client.Detect(ctx, scene, collided.Frame{ID: 1, Updates: []collided.Update{
		{Mesh: 0, Positions: collided.F32{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}},
		{Mesh: 1, StartPositions: collided.F32{{0.25, 0, 1}, {5, 0, 0}, {5.5, 0, 0}},
			Positions: collided.F32{{0.25, 0, -1}, {6, 0, 0}, {4.5, 0, 0}}},
	}})
	must(t, err)
	contacts := output.VertexTriangle
	same(t, [2][2]uint32{contacts.Elements[0], contacts.Elements[1]}, [2][2]uint32{{3, 0}, {4, 4}})
	same(t, collided.ElementKindOf(contacts.Stencils[0]), collided.Edge)
	same(t, collided.ElementKindOf(contacts.Stencils[1]), collided.Point)
}

func TestSparseUpdatesAndEditsChangeWhatTheyName(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	to := func(z float32) collided.Update {
		return collided.Update{Mesh: 1, Indices: []uint32{0}, Positions: collided.F32{{1, 1, z}}}
	}
	detect(ctx, t, s, fall(0, 0.5))
	same(t, detect(ctx, t, s, collided.Frame{Updates: []collided.Update{to(-1)}}).VertexTriangle.Elements[0], [2]uint32{3, 0})
	unordered := collided.Update{Mesh: 1, Indices: []uint32{2, 0}, Positions: collided.F32{{}, {}}}
	_, err := s.Detect(ctx, collided.Frame{Updates: []collided.Update{unordered}})
	refused(t, err, codes.InvalidArgument, "frame.updates[0].sparse.indices", ".")
	edit := func(edit *collided.SceneEdit, updates ...collided.Update) *collided.Output {
		return detect(ctx, t, s, collided.Frame{Edit: edit, Updates: updates})
	}
	same(t, edit(&collided.SceneEdit{Meshes: []*v1.MeshEdit{collided.RemovedMesh(0)}}).Done.ContactCount, 0)
	static := twoTriangles()[0]
	static.Motion = collided.Static
	added := &collided.SceneEdit{Meshes: []*v1.MeshEdit{collided.EditedMesh(0, static)}}
	same(t, edit(added, collided.Update{Mesh: 0, Positions: floor}, to(1)).VertexTriangle.Elements[0], [2]uint32{3, 0})
	apart := &collided.SceneEdit{ExcludeMeshes: []*collided.MeshPair{{First: 0, Second: 1}}}
	same(t, edit(apart, to(-1)).Done.ContactCount, 0)
	known, err := client.GetScene(ctx, scene.SceneId)
	must(t, err)
	same(t, known.EditCount, 3)
}
