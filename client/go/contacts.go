package collided

import (
	"encoding/binary"
	"math"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

// Contacts of one kind in canonical order. Each slice has an entry for each contact, or is empty if it was not requested or
// not computed.
type Contacts struct {
	Count int
	// Elements are scene-wide ids of a vertex and an element, of two edges, of two triangles, or of an edge and a triangle. Of
	// VertexSolid they are a vertex and the triangle of the solid.
	Elements [][2]uint32
	// Stencils are four vertices; scene-wide.
	Stencils [][4]uint32
	// TOI is the time of impact, in [0, 1] of the step.
	TOI []float64
	// Distance is >= 0, in the unit of the positions; of VertexSolid it is minus the depth, < 0.
	Distance []float64
	// Weights locate the closest points: ContactPoints.
	Weights [][2]float64
	// Normals are of unit length, from the second feature to the first.
	Normals [][3]float32
	// Flags are bytes of masks: flags & IsInitial.
	Flags []byte
	// Features are bytes of discrete frames. PlaceOnTriangle and PlacesOnEdges read on which features the closest points are; masks
	// such as NearerAtFirst say what covers a contact.
	Features []byte
	// SignedDistances are Distance with a sign, in discrete frames of scenes with a solid. They are negative where the closest point of
	// one feature is inside the other feature's mesh, a solid. They are NaN where neither mesh is a solid, of a mesh and itself, and
	// where the distance is above 0 and one of the two features meets the other's mesh.
	SignedDistances []float64
}

// ContactSet has contacts of all kinds.
type ContactSet struct {
	VertexTriangle, EdgeEdge, TriangleTriangle, EdgeTriangle, VertexSolid Contacts
}

// The fields of an answer that have contacts, as errors name them.
const (
	fieldContacts = "contacts"
	fieldLimits   = "limits"
)

// of returns the contacts of a kind; nil for a kind that this client does not know.
func (s *ContactSet) of(kind v1.ContactKind) *Contacts {
	switch kind {
	case VertexTriangle:
		return &s.VertexTriangle
	case EdgeEdge:
		return &s.EdgeEdge
	case TriangleTriangle:
		return &s.TriangleTriangle
	case EdgeTriangle:
		return &s.EdgeTriangle
	case VertexSolid:
		return &s.VertexSolid
	}
	return nil
}

// add appends chunks of a field of the answer. DataLoss if the length of an array is not what its chunk's count asks for.
func (s *ContactSet) add(field string, chunks ...*v1.ContactChunk) error {
	for _, chunk := range chunks {
		contacts := s.of(chunk.Kind)
		if contacts == nil {
			return failf(codes.DataLoss, "", "%s.kind is %v, which this client does not know", field, chunk.Kind)
		}
		if err := contacts.add(field, chunk); err != nil {
			return err
		}
	}
	return nil
}

// addLimits appends chunks of contacts that limit a way, which have every array but Features and SignedDistances. DataLoss for a kind that limits none.
func (s *ContactSet) addLimits(chunks ...*v1.ContactChunk) error {
	for _, chunk := range chunks {
		if chunk.Kind == TriangleTriangle || chunk.Kind == EdgeTriangle || chunk.Kind == VertexSolid {
			return failf(codes.DataLoss, "", "limits.kind is %v; only a vertex and a triangle, or two edges, limit a way", chunk.Kind)
		}
		if err := s.add(fieldLimits, chunk); err != nil {
			return err
		}
		if err := s.of(chunk.Kind).checkWhole(fieldLimits); err != nil {
			return err
		}
	}
	return nil
}

func (c *Contacts) add(field string, chunk *v1.ContactChunk) error {
	if chunk.Count == 0 {
		return failf(codes.DataLoss, "", "%s.count is 0; a chunk has 1 contact or more", field)
	}
	if chunk.Shared != nil {
		return failf(codes.DataLoss, "", "%s.shared names shared memory, and there is none over gRPC", field)
	}
	r := reader{field: field, before: c.Count, count: int(chunk.Count)}
	c.Elements = read(&r, "elements", c.Elements, chunk.Elements, 8, uint32s[[2]uint32])
	c.Stencils = read(&r, "stencils", c.Stencils, chunk.Stencils, 16, uint32s[[4]uint32])
	c.TOI = read(&r, "toi", c.TOI, chunk.Toi, 8, float64At)
	c.Distance = read(&r, "distance", c.Distance, chunk.Distance, 8, float64At)
	c.Weights = read(&r, "weights", c.Weights, chunk.Weights, 16, twoFloat64s)
	c.Normals = read(&r, "normals", c.Normals, chunk.Normals, 12, threeFloat32s)
	c.Flags = read(&r, "flags", c.Flags, chunk.Flags, 1, onlyByte)
	c.Features = read(&r, "features", c.Features, chunk.Features, 1, onlyByte)
	c.SignedDistances = read(&r, "signed_distances", c.SignedDistances, chunk.SignedDistances, 8, float64At)
	c.Count += int(chunk.Count)
	if r.err != nil {
		return r.err
	}
	return c.check(field, chunk.Kind, r.before, r.hasArray)
}

// reader remembers whether the contacts have an array, and the first one of a chunk that is not as long as it has to be.
type reader struct {
	field         string // of the answer
	before, count int
	hasArray      bool
	err           error
}

func read[T any](r *reader, column string, out []T, bytes []byte, width int, entry func([]byte) T) []T {
	if len(bytes) == 0 && len(out) == 0 {
		return out
	}
	if len(bytes) != r.count*width || len(out) != r.before {
		r.err = failf(codes.DataLoss, "", "%s.%s has %d bytes for %d contacts; it needs %d",
			r.field, column, len(bytes), r.count, r.count*width)
		return out
	}
	r.hasArray = true
	for at := 0; at < len(bytes); at += width {
		out = append(out, entry(bytes[at:at+width]))
	}
	return out
}

func onlyByte(bytes []byte) byte { return bytes[0] }

func uint32s[T [2]uint32 | [4]uint32](bytes []byte) (out T) {
	for i := 0; i < len(out); i++ {
		out[i] = binary.LittleEndian.Uint32(bytes[4*i:])
	}
	return out
}

func float64At(bytes []byte) float64 { return math.Float64frombits(binary.LittleEndian.Uint64(bytes)) }

func twoFloat64s(bytes []byte) [2]float64 { return [2]float64{float64At(bytes), float64At(bytes[8:])} }

func float32At(bytes []byte) float32 { return math.Float32frombits(binary.LittleEndian.Uint32(bytes)) }

func threeFloat32s(bytes []byte) [3]float32 {
	return [3]float32{float32At(bytes), float32At(bytes[4:]), float32At(bytes[8:])}
}
