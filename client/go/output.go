package collided

import (
	"math"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

// Output is the daemon's whole answer to one frame. One that was refused or skipped has no contacts.
type Output struct {
	ContactSet
	FrameID uint64
	// Shortened has how far each mesh, or vertex, went, in a frame with AdvanceMode PerMesh, or PerVertex.
	Shortened Shortened
	// Limits has the contacts that limit the way, in a frame with Limits. The whole way would bring each of these pairs nearer than
	// it may come, or is not certain to keep it that far apart. They are of the kinds VertexTriangle and EdgeEdge, and have every slice
	// but Features and SignedDistances, whatever SceneSpec.Fields says.
	// Distance is the least that a pair keeps, in the unit of the positions. TOI, in [0, 1], is the fraction of the whole way at
	// which the pair comes to that distance, and never later than in truth. Weights and Normals are those of TOI.
	Limits ContactSet
	// Pairs has the pairs of meshes, one of them a solid, that are not apart, by First, then Second. Discrete frames with ReportAll have
	// them, in scenes with FieldPairStates.
	Pairs []PairOfMeshes
	// Done has totals and metrics; nil if the frame was refused or skipped.
	Done *v1.FrameDone
	// Err is why the frame was refused; the scene is as it was, and a stream goes on.
	Err error
	// Skipped: a later frame replaced it (LATEST_WINS).
	Skipped bool

	mode      v1.AdvanceMode // of the frame
	hasLimits bool           // the frame asked for them
}

func newOutput(frame *v1.Frame) *Output {
	return &Output{FrameID: frame.FrameId, mode: frame.AdvanceMode, hasLimits: frame.Limits}
}

// addLimits appends chunks of Limits. DataLoss if the frame did not ask for them.
func (o *Output) addLimits(chunks ...*v1.ContactChunk) error {
	if len(chunks) > 0 && !o.hasLimits {
		return failf(codes.DataLoss, "", "limits has %d chunks, and the frame did not ask for them", len(chunks))
	}
	return o.Limits.addLimits(chunks...)
}

// finish takes the last contacts and the totals.
func (o *Output) finish(done *v1.FrameDone) error {
	if err := checkDone(done); err != nil {
		return err
	}
	if err := o.add(fieldContacts, done.Contacts...); err != nil {
		return err
	}
	if err := o.addLimits(done.Limits...); err != nil {
		return err
	}
	if err := o.Shortened.add(done.Shortened); err != nil {
		return err
	}
	if err := o.addPairs(done.Pairs); err != nil {
		return err
	}
	done.Contacts, done.Limits, done.Shortened, done.Pairs = nil, nil, nil, nil
	o.Done = done
	if o.mode != PerMesh && o.mode != PerVertex {
		return o.Shortened.checkBelow(0)
	}
	return nil
}

// The checks below guard everything that is computed from an answer: the daemon may be wrong, or another program may answer.

const (
	maxWindow = 1024    // of any daemon
	maxBare   = 1 << 24 // contacts of chunks without any array, whose number nothing confirms
	maxScenes = 1000000 // that a daemon can have
)

// sceneSize is how many meshes, vertices and elements a scene has.
type sceneSize struct{ meshes, vertices, elements uint64 }

func sizeOf(spec *v1.SceneSpec) (size sceneSize) {
	size.meshes = uint64(len(spec.GetMeshes()))
	for _, mesh := range spec.GetMeshes() {
		size.vertices += uint64(mesh.VertexCount)
		size.elements += uint64(mesh.TriangleCount) + uint64(mesh.EdgeCount) + uint64(mesh.PointCount)
	}
	return size
}

// checkDone checks the times and fractions of a frame's end.
func checkDone(done *v1.FrameDone) error {
	if done == nil {
		return failf(codes.DataLoss, "", "an answer has no `done`")
	}
	if !isFraction(done.EarliestToi) {
		return failf(codes.DataLoss, "", "done.earliest_toi is %v; it must be in [0, 1]", done.EarliestToi)
	}
	if !isFraction(done.GetAdvanced()) {
		return failf(codes.DataLoss, "", "done.advanced is %v; it must be in [0, 1]", done.GetAdvanced())
	}
	if !isFraction(done.GetWay()) {
		return failf(codes.DataLoss, "", "done.way is %v; it must be in [0, 1]", done.GetWay())
	}
	return nil
}

// isFraction is false for NaN.
func isFraction(value float64) bool { return value >= 0 && value <= 1 }

// check checks the times and distances of a kind from the first contact on, and a count that no array confirms. field: of the answer.
func (c *Contacts) check(field string, kind v1.ContactKind, first int, hasArray bool) error {
	for i := first; i < len(c.TOI); i++ {
		if !isFraction(c.TOI[i]) {
			return failf(codes.DataLoss, "", "%s.toi has %v; it must be in [0, 1]", field, c.TOI[i])
		}
	}
	if err := c.checkDistances(field, kind, first); err != nil {
		return err
	}
	if !hasArray && c.Count > maxBare {
		return failf(codes.DataLoss, "", "%s.count is %d in all without any array; it must be at most %d", field, c.Count, maxBare)
	}
	return nil
}

// checkDistances checks that depths are below 0, all other distances 0 or more, and that a sign changes nothing else.
func (c *Contacts) checkDistances(field string, kind v1.ContactKind, first int) error {
	for i := first; i < len(c.Distance); i++ {
		distance := c.Distance[i]
		if kind == VertexSolid && !(distance < 0) {
			return failf(codes.DataLoss, "", "%s.distance has %v; of a vertex in a solid it must be below 0", field, distance)
		}
		if kind != VertexSolid && !(distance >= 0) {
			return failf(codes.DataLoss, "", "%s.distance has %v; it must be 0 or more", field, distance)
		}
		if i < len(c.SignedDistances) && math.Abs(c.SignedDistances[i]) != distance && !math.IsNaN(c.SignedDistances[i]) {
			return failf(codes.DataLoss, "", "%s.signed_distances has %v, which is neither %s.distance, %v, nor minus it",
				field, c.SignedDistances[i], field, distance)
		}
	}
	return nil
}

// checkWhole checks that no array is missing but Features and SignedDistances, which only discrete frames have.
func (c *Contacts) checkWhole(field string) error {
	for _, column := range []struct {
		name string
		has  int
	}{
		{"elements", len(c.Elements)}, {"stencils", len(c.Stencils)}, {"toi", len(c.TOI)}, {"distance", len(c.Distance)},
		{"weights", len(c.Weights)}, {"normals", len(c.Normals)}, {"flags", len(c.Flags)},
	} {
		if column.has != c.Count {
			return failf(codes.DataLoss, "", "%s.%s has %d entries for %d contacts", field, column.name, column.has, c.Count)
		}
	}
	return nil
}

// checkIDs checks that the scene has what the contacts, Limits, Pairs and Shortened name. A size of 0 is not known.
func (o *Output) checkIDs(size sceneSize) error {
	if size.vertices == 0 {
		return nil
	}
	most := size.vertices
	if o.mode == PerMesh {
		most = size.meshes
	}
	if err := o.Shortened.checkBelow(most); err != nil {
		return err
	}
	if err := o.checkPairs(size); err != nil {
		return err
	}
	if err := o.ContactSet.checkIDs(fieldContacts, size); err != nil {
		return err
	}
	return o.Limits.checkIDs(fieldLimits, size)
}

func (s *ContactSet) checkIDs(field string, size sceneSize) error {
	for _, each := range []struct {
		contacts      *Contacts
		first, second uint64
	}{
		{&s.VertexTriangle, size.vertices, size.elements},
		{&s.EdgeEdge, 3 * size.elements, 3 * size.elements}, // edges at most
		{&s.TriangleTriangle, size.elements, size.elements},
		{&s.EdgeTriangle, 3 * size.elements, size.elements},
		{&s.VertexSolid, size.vertices, size.elements},
	} {
		for _, stencil := range each.contacts.Stencils {
			for _, vertex := range stencil {
				if uint64(vertex) >= size.vertices {
					return failf(codes.DataLoss, "", "%s.stencils names %d; the scene has %d vertices", field, vertex, size.vertices)
				}
			}
		}
		for _, pair := range each.contacts.Elements {
			if uint64(pair[0]) >= each.first || uint64(pair[1]) >= each.second {
				return failf(codes.DataLoss, "", "%s.elements names %d and %d; the scene has %d vertices and %d elements",
					field, pair[0], pair[1], size.vertices, size.elements)
			}
		}
	}
	return nil
}

// checkTotal checks that as many contacts came as the daemon says that it sent.
func (o *Output) checkTotal() error {
	came := uint64(o.VertexTriangle.Count + o.EdgeEdge.Count + o.TriangleTriangle.Count + o.EdgeTriangle.Count + o.VertexSolid.Count)
	if o.Done.ContactCount != came {
		return failf(codes.DataLoss, "", "done.contact_count is %d, and %d contacts came", o.Done.ContactCount, came)
	}
	return nil
}

// checkScene checks that an answer has the scene that it is about.
func checkScene(scene *Scene) error {
	if scene.GetSceneId() == "" {
		return failf(codes.DataLoss, "", "the daemon's answer has no scene")
	}
	return nil
}
