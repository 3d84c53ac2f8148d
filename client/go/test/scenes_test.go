package test

import (
	"context"
	"errors"
	"fmt"
	"math"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

func TestASceneIsCreatedListedEstimatedAndDeleted(t *testing.T) {
	ctx, client := connected(t)
	scene, err := client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, twoTriangles(), time.Minute)
	must(t, err)
	same(t, scene.State, v1.SceneState_SCENE_STATE_READY)
	same(t, [3]uint64{scene.VertexCount, scene.EdgeCount, scene.TriangleCount}, [3]uint64{6, 6, 2})
	same(t, scene.LeaseSeconds, 60)
	known, err := client.GetScene(ctx, scene.SceneId)
	must(t, err)
	same(t, known.SceneId, scene.SceneId)
	scenes, err := client.ListScenes(ctx)
	must(t, err)
	same(t, len(scenes), 1)
	estimate, err := client.EstimateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, twoTriangles())
	must(t, err)
	same(t, estimate.FirstFrameBytes, 72)
	must(t, client.DeleteScene(ctx, scene.SceneId))
	_, err = client.GetScene(ctx, scene.SceneId)
	refused(t, err, codes.NotFound, "scene_id", "deleted")
}

func TestTrianglesGoUpInChunks(t *testing.T) {
	ctx, client := connected(t, "--max-message-mb", "4")
	meshes, _ := sheets(230) // 1.27 MB of triangles a mesh: one goes with the scene, the other in two chunks
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.DCD}, meshes)
	same(t, scene.State, v1.SceneState_SCENE_STATE_READY)
	same(t, scene.TriangleCount, 2*2*230*230)
	for m := range meshes {
		mesh, err := client.GetMesh(ctx, scene.SceneId, uint32(m))
		must(t, err)
		same(t, len(mesh.Elements), len(meshes[m].Triangles))
		for i, triangle := range meshes[m].Triangles {
			same(t, mesh.Elements[i], triangle)
		}
	}
}

func TestWhatAMeshIsMadeOfIsTold(t *testing.T) {
	ctx, client := connected(t)
	hair := collided.Mesh{Name: "hair", VertexCount: 6, Triangles: [][3]uint32{{0, 1, 2}}, Edges: [][2]uint32{{2, 3}}, Points: []uint32{5}}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.CCD}, []collided.Mesh{hair})
	mesh, err := client.GetMesh(ctx, scene.SceneId, 0)
	must(t, err)
	same(t, len(mesh.Elements), 3)
	same(t, *(*[3][3]uint32)(mesh.Elements), [3][3]uint32{{0, 1, 2}, {2, 3, 3}, {5, 5, 5}})
	same(t, mesh.VertexCount, 6)
	same(t, mesh.EditCount, 0)
	_, err = client.GetMesh(ctx, scene.SceneId, 1)
	refused(t, err, codes.InvalidArgument, "mesh", "1")
	_, err = client.GetMesh(ctx, "none", 0)
	refused(t, err, codes.NotFound, "scene_id", "none")
}

func TestARefusedUploadLeavesNoScene(t *testing.T) {
	ctx, client := connected(t)
	meshes := twoTriangles()
	for count, field := range map[int]string{0: "spec.meshes[1].triangles[0]", 400_000: "triangles[400000]"} { // 4.8 MB: not inline
		meshes[1].Triangles = make([][3]uint32, count, count+1)
		for i := range meshes[1].Triangles {
			meshes[1].Triangles[i] = [3]uint32{0, 1, 2}
		}
		meshes[1].Triangles = append(meshes[1].Triangles, [3]uint32{0, 1, 7})
		_, err := client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, meshes, 0)
		refused(t, err, codes.InvalidArgument, field, "vertex 7")
	}
	scenes, err := client.ListScenes(ctx)
	must(t, err)
	same(t, len(scenes), 0)
}

func TestLargeMeshesAreUploadedTogether(t *testing.T) {
	ctx, client := connected(t)
	meshes := make([]collided.Mesh, 12)
	for i := range meshes { // 7.2 MB, of which 4 MiB are inline
		meshes[i] = collided.Mesh{Name: fmt.Sprint("mesh ", i), VertexCount: 50_012, Triangles: make([][3]uint32, 50_000)}
		for at := range meshes[i].Triangles {
			meshes[i].Triangles[at] = [3]uint32{uint32(at), uint32(at + 1), uint32(at + 2 + i%3)}
		}
	}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.DCD}, meshes)
	same(t, scene.State, v1.SceneState_SCENE_STATE_READY)
	for i := range meshes {
		mesh, err := client.GetMesh(ctx, scene.SceneId, uint32(i))
		must(t, err)
		same(t, len(mesh.Elements), len(meshes[i].Triangles))
		same(t, mesh.Elements[49_999], meshes[i].Triangles[49_999])
	}
}

func TestABadSpecIsRefusedByName(t *testing.T) {
	ctx, client := connected(t)
	cases := []struct {
		spec  *collided.SceneSpec
		code  codes.Code
		field string
	}{
		{nil, codes.InvalidArgument, "spec.mode"},
		{&collided.SceneSpec{Mode: 77}, codes.InvalidArgument, "spec.mode"},
		{&collided.SceneSpec{Mode: collided.CCD, Thickness: -1}, codes.InvalidArgument, "spec.thickness"},
		{&collided.SceneSpec{Mode: collided.CCD, PositionFormat: collided.FormatQ16}, codes.InvalidArgument, "spec.quantization_box"},
		{&collided.SceneSpec{Mode: collided.CCD, MemoryBudgetBytes: 1}, codes.ResourceExhausted, "spec.memory_budget_bytes"},
		{&collided.SceneSpec{Mode: collided.CCD, Meshes: []*v1.MeshSpec{{}}}, codes.InvalidArgument, "spec.meshes"},
	}
	for _, c := range cases {
		_, err := client.CreateScene(ctx, c.spec, twoTriangles(), 0)
		refused(t, err, c.code, c.field, ".")
		_, err = client.EstimateScene(ctx, c.spec, twoTriangles())
		refused(t, err, c.code, c.field, ".")
	}
	_, err := client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, nil, 0)
	refused(t, err, codes.InvalidArgument, "spec.meshes", ".")
	_, err = client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, twoTriangles(), -time.Second)
	refused(t, err, codes.InvalidArgument, "lease_seconds", "-1")
}

// The tip is one above the floor.
func TestMeshesTouchUpToTheThicknessAndBothHalves(t *testing.T) {
	ctx, client := connected(t)
	spec := &collided.SceneSpec{Mode: collided.DCD, Thickness: 0.5}
	frame := collided.Frame{Updates: []collided.Update{{Mesh: 0, Positions: floor}, {Mesh: 1, Positions: tipAt(1)}}}
	for _, c := range []struct {
		halves [2]float64
		count  int
	}{{[2]float64{0, 0}, 0}, {[2]float64{0.25, 0.25}, 1}, {[2]float64{0.25, 0.249}, 0}, {[2]float64{0, 0.5}, 1}} {
		meshes := twoTriangles()
		meshes[0].HalfThickness, meshes[1].HalfThickness = c.halves[0], c.halves[1]
		scene := create(ctx, t, client, spec, meshes)
		same(t, scene.Spec.Meshes[1].HalfThickness, c.halves[1])
		s := stream(ctx, t, client, scene, collided.StreamOptions{})
		same(t, detect(ctx, t, s, frame).VertexTriangle.Count, c.count)
		thick := collided.Mesh{VertexCount: 3, HalfThickness: 0.75}
		edit := &collided.SceneEdit{Meshes: []*v1.MeshEdit{collided.EditedMesh(1, thick)}}
		same(t, detect(ctx, t, s, collided.Frame{Edit: edit}).VertexTriangle.Count, 1)
	}
	for _, half := range []float64{-1, math.NaN(), math.Inf(1), 1e300} {
		meshes := twoTriangles()
		meshes[1].HalfThickness = half
		_, err := client.CreateScene(ctx, spec, meshes, 0)
		refused(t, err, codes.InvalidArgument, "spec.meshes[1].half_thickness", "it must be from 0 to")
	}
}

func TestWhatIsNotUTF8IsRefusedAndTheStreamGoesOn(t *testing.T) {
	ctx, client := connected(t)
	const bad = "\xff"
	unnamed := twoTriangles()
	unnamed[1].Name = bad
	_, err := client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, unnamed, 0)
	refused(t, err, codes.InvalidArgument, "spec.meshes[1].name", "not UTF-8")
	for field, spec := range map[string]*collided.SceneSpec{
		"spec.display_name":    {DisplayName: bad},
		"spec.device":          {Device: bad},
		"spec.part_devices[1]": {PartDevices: []string{"cpu", bad}},
	} {
		_, err := client.CreateScene(ctx, spec, twoTriangles(), 0)
		refused(t, err, codes.InvalidArgument, field, "not UTF-8")
	}
	s := fallStream(ctx, t, client)
	detect(ctx, t, s, fall(0, 2))
	edit := &collided.SceneEdit{Meshes: []*v1.MeshEdit{collided.EditedMesh(1, unnamed[1])}}
	_, err = s.Detect(ctx, collided.Frame{Edit: edit})
	refused(t, err, codes.InvalidArgument, "frame.edit.meshes[0].spec.name", "not UTF-8")
	detect(ctx, t, s, fall(0, 2))
	must(t, s.Finish(ctx))
}

func TestAContextEndsACall(t *testing.T) {
	_, client := connected(t)
	over, cancel := context.WithCancel(context.Background())
	cancel()
	if _, err := client.GetServerInfo(over); !errors.Is(err, context.Canceled) {
		t.Fatal(err)
	}
	late, cancel := context.WithTimeout(context.Background(), 0)
	defer cancel()
	if _, err := client.GetServerInfo(late); !errors.Is(err, context.DeadlineExceeded) {
		t.Fatal(err)
	}
}

// sheets are two sheets of n * n cells, one just above the other: many contacts.
func sheets(n int) ([]collided.Mesh, []collided.F32) {
	side := uint32(n + 1)
	var triangles [][3]uint32
	for cell := 0; cell < n*n; cell++ {
		a := uint32(cell/n)*side + uint32(cell%n)
		triangles = append(triangles, [3]uint32{a, a + 1, a + side}, [3]uint32{a + 1, a + side + 1, a + side})
	}
	sheet := func(x, z float32) (positions collided.F32) {
		for i := uint32(0); i < side*side; i++ {
			positions = append(positions, [3]float32{float32(i%side) + x, float32(i/side) + x, z})
		}
		return positions
	}
	mesh := func(name string) collided.Mesh {
		return collided.Mesh{Name: name, VertexCount: side * side, Triangles: triangles, NoSelfContacts: true}
	}
	return []collided.Mesh{mesh("lower"), mesh("upper")}, []collided.F32{sheet(0, 0), sheet(0.25, 0.1)}
}
