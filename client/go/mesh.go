package collided

import (
	"encoding/binary"
	"fmt"
	"sort"
	"unicode/utf8"

	"google.golang.org/protobuf/proto"

	v1 "collided.invalid/client/go/v1"
)

// Mesh of a scene, of triangles, loose edges and loose points, of any of which it has one or more. Vertices are numbered
// within it.
type Mesh struct {
	// Name is unique in the scene, 1 to 128 bytes. In an edit it may be empty: the mesh's own stays.
	Name string
	// VertexCount is 1 to the daemon's limit.
	VertexCount uint32
	// Triangles may be any number: many are uploaded in chunks.
	Triangles [][3]uint32
	// Edges are loose edges, such as the segments of a hair.
	Edges [][2]uint32
	// Points are loose points, such as particles.
	Points []uint32
	// Motion is deformable if it is not set.
	Motion v1.MeshMotion
	// Groups has the bits of the groups that it is in; 0: the first.
	Groups uint32
	// CollideMask has the bits of the groups that it can touch; 0: all.
	CollideMask uint32
	// NoSelfContacts leaves out its contacts with itself.
	NoSelfContacts bool
	// ExcludeRings leaves out self contacts of features that so many edges or fewer connect, 0 to 8.
	ExcludeRings uint32
	// ExcludeRestPairs does so for features within the spec's rest_distance in the scene's first frame.
	ExcludeRestPairs bool
	// HalfThickness is half of what it is thick beyond the spec's thickness, >= 0, finite, in the unit of the positions: two
	// meshes are in contact up to the thickness and both halves, a mesh and itself up to the thickness and twice its half.
	HalfThickness float64
	// Solid says that it bounds a volume. It has triangles alone, which use each edge as often in one direction as in the other. Its
	// volume in its first frame is above 0; normals (b - a) x (c - a) point outside. The daemon refuses other meshes.
	Solid bool
}

// message is the mesh without its triangles, but with their number.
func (m *Mesh) message() *v1.MeshSpec {
	return &v1.MeshSpec{
		Name:             m.Name,
		VertexCount:      m.VertexCount,
		TriangleCount:    uint32(len(m.Triangles)),
		Edges:            packPairs(m.Edges),
		Points:           packIndices(m.Points),
		Motion:           m.Motion,
		Groups:           m.Groups,
		CollideMask:      m.CollideMask,
		NoSelfContacts:   m.NoSelfContacts,
		ExcludeRings:     m.ExcludeRings,
		ExcludeRestPairs: m.ExcludeRestPairs,
		HalfThickness:    m.HalfThickness,
		Solid:            m.Solid,
	}
}

// EditedMesh is a mesh as an edit brings it (Frame.Edit): added, or in place of another; with its elements, or without
// them where those that it has stay.
func EditedMesh(index uint32, mesh Mesh) *v1.MeshEdit {
	spec := mesh.message()
	spec.Triangles = packTriangles(mesh.Triangles)
	return &v1.MeshEdit{Mesh: index, Spec: spec}
}

// RemovedMesh removes a mesh.
func RemovedMesh(index uint32) *v1.MeshEdit { return &v1.MeshEdit{Mesh: index} }

// sceneInput is what a scene is created from, and created from again.
type sceneInput struct {
	spec      *SceneSpec // without triangles
	triangles [][]byte   // of each mesh
}

// newSceneInput copies what the caller has passed. `spec` may be nil, and must have no meshes.
func newSceneInput(spec *SceneSpec, meshes []Mesh) (*sceneInput, error) {
	if len(spec.GetMeshes()) > 0 {
		return nil, invalidf("spec.meshes", "has %d meshes; pass them as the next argument", len(spec.GetMeshes()))
	}
	input := &sceneInput{spec: &SceneSpec{}}
	if spec != nil {
		input.spec = proto.Clone(spec).(*SceneSpec)
	}
	for i := range meshes {
		input.spec.Meshes = append(input.spec.Meshes, meshes[i].message())
		input.triangles = append(input.triangles, packTriangles(meshes[i].Triangles))
	}
	return input, checkTexts(input.spec)
}

// withSmall is the spec with triangles, those of the smallest meshes first, and the meshes whose triangles need a call each:
// proto/README.md has the rule.
func (s *sceneInput) withSmall(maxMessageBytes uint64) (*SceneSpec, []int) {
	spec := proto.Clone(s.spec).(*SceneSpec)
	left := min(maxInline, int(maxMessageBytes/2)-proto.Size(spec))
	bySize := make([]int, len(s.triangles))
	for i := range bySize {
		bySize[i] = i
	}
	sort.SliceStable(bySize, func(a, b int) bool { return len(s.triangles[bySize[a]]) < len(s.triangles[bySize[b]]) })
	var uploads []int
	for _, mesh := range bySize {
		size := len(s.triangles[mesh])
		switch {
		case size <= left:
			spec.Meshes[mesh].Triangles = s.triangles[mesh]
			left -= size
		case size > 0:
			uploads = append(uploads, mesh)
		}
	}
	return spec, uploads
}

// checkTexts finds what gRPC cannot send, and would end a stream for.
func checkTexts(spec *SceneSpec) error {
	fields := []string{"spec.display_name", "spec.device"}
	texts := []string{spec.DisplayName, spec.Device}
	for i, device := range spec.PartDevices {
		fields, texts = append(fields, fmt.Sprintf("spec.part_devices[%d]", i)), append(texts, device)
	}
	for i, mesh := range spec.Meshes {
		fields, texts = append(fields, fmt.Sprintf("spec.meshes[%d].name", i)), append(texts, mesh.Name)
	}
	for i, text := range texts {
		if err := checkText(text, fields[i]); err != nil {
			return err
		}
	}
	return nil
}

func checkText(text, field string) error {
	if utf8.ValidString(text) {
		return nil
	}
	return invalidf(field, "is %q, which is not UTF-8", text)
}

func packTriangles(triangles [][3]uint32) []byte {
	bytes := make([]byte, 0, 12*len(triangles))
	for _, t := range triangles {
		bytes = appendUint32(appendUint32(appendUint32(bytes, t[0]), t[1]), t[2])
	}
	return bytes
}

func packPairs(pairs [][2]uint32) []byte {
	bytes := make([]byte, 0, 8*len(pairs))
	for _, pair := range pairs {
		bytes = appendUint32(appendUint32(bytes, pair[0]), pair[1])
	}
	return bytes
}

func packIndices(indices []uint32) []byte {
	bytes := make([]byte, 0, 4*len(indices))
	for _, index := range indices {
		bytes = appendUint32(bytes, index)
	}
	return bytes
}

func appendUint32(bytes []byte, x uint32) []byte { return binary.LittleEndian.AppendUint32(bytes, x) }
