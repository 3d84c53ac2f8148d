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
	// Elements are the ids of a vertex and an element, or of two edges, or of two triangles; scene-wide.
	Elements [][2]uint32
	// Stencils are four vertices; scene-wide.
	Stencils [][4]uint32
	// TOI is the time of impact, in [0, 1] of the step.
	TOI []float64
	// Distance is >= 0, in the unit of the positions.
	Distance []float64
	// Weights locate the closest points: ContactPoints.
	Weights [][2]float64
	// Normals are of unit length, from the second feature to the first.
	Normals [][3]float32
	// Flags are bytes of masks: flags & IsInitial.
	Flags []byte
}

// ContactSet has contacts of all kinds.
type ContactSet struct {
	VertexTriangle, EdgeEdge, TriangleTriangle Contacts
}

// add appends a chunk. DataLoss if the length of an array is not what the chunk's count asks for.
func (s *ContactSet) add(chunk *v1.ContactChunk) error {
	switch chunk.Kind {
	case VertexTriangle:
		return s.VertexTriangle.add(chunk)
	case EdgeEdge:
		return s.EdgeEdge.add(chunk)
	case TriangleTriangle:
		return s.TriangleTriangle.add(chunk)
	}
	return failf(codes.DataLoss, "", "contacts.kind is %v, which this client does not know", chunk.Kind)
}

func (s *ContactSet) addAll(chunks []*v1.ContactChunk) error {
	for _, chunk := range chunks {
		if err := s.add(chunk); err != nil {
			return err
		}
	}
	return nil
}

func (c *Contacts) add(chunk *v1.ContactChunk) error {
	if chunk.Count == 0 {
		return failf(codes.DataLoss, "", "contacts.count is 0; a chunk has 1 contact or more")
	}
	if chunk.Shared != nil {
		return failf(codes.DataLoss, "", "contacts.shared names shared memory, and there is none over gRPC")
	}
	r := reader{before: c.Count, count: int(chunk.Count)}
	c.Elements = read(&r, "elements", c.Elements, chunk.Elements, 8, uint32s[[2]uint32])
	c.Stencils = read(&r, "stencils", c.Stencils, chunk.Stencils, 16, uint32s[[4]uint32])
	c.TOI = read(&r, "toi", c.TOI, chunk.Toi, 8, float64At)
	c.Distance = read(&r, "distance", c.Distance, chunk.Distance, 8, float64At)
	c.Weights = read(&r, "weights", c.Weights, chunk.Weights, 16, twoFloat64s)
	c.Normals = read(&r, "normals", c.Normals, chunk.Normals, 12, threeFloat32s)
	c.Flags = read(&r, "flags", c.Flags, chunk.Flags, 1, func(bytes []byte) byte { return bytes[0] })
	c.Count += int(chunk.Count)
	if r.err != nil {
		return r.err
	}
	return c.check(r.before, r.hasArray)
}

// reader remembers whether the contacts have an array, and the first one of a chunk that is not as long as it has to be.
type reader struct {
	before, count int
	hasArray      bool
	err           error
}

func read[T any](r *reader, field string, out []T, bytes []byte, width int, entry func([]byte) T) []T {
	if len(bytes) == 0 && len(out) == 0 {
		return out
	}
	if len(bytes) != r.count*width || len(out) != r.before {
		r.err = failf(codes.DataLoss, "", "contacts.%s has %d bytes for %d contacts; it needs %d",
			field, len(bytes), r.count, r.count*width)
		return out
	}
	r.hasArray = true
	for at := 0; at < len(bytes); at += width {
		out = append(out, entry(bytes[at:at+width]))
	}
	return out
}

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
