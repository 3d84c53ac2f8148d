package collided

import (
	"encoding/binary"
	"sort"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

// Shortened lists what did not go all of its way in a frame that advances PerMesh or PerVertex. All else that moves went all of it.
type Shortened struct {
	// IDs ascend strictly. They are of meshes, or of vertices, numbered within the scene.
	IDs []uint32
	// Fractions tell how far each went, in [0, 1).
	Fractions []float64
}

// Of returns how far each of count vertices, or meshes, went, from the id first on, in [0, 1]. MoveEachAlong takes these fractions.
func (s Shortened) Of(first uint32, count int) []float64 {
	fractions := make([]float64, count)
	for i := range fractions {
		fractions[i] = 1
	}
	for i := sort.Search(len(s.IDs), func(i int) bool { return s.IDs[i] >= first }); i < len(s.IDs); i++ {
		at := uint64(s.IDs[i] - first)
		if at >= uint64(count) {
			break
		}
		fractions[at] = s.Fractions[i]
	}
	return fractions
}

// add appends what one message of an answer has.
func (s *Shortened) add(ways *v1.ShortenedWays) error {
	ids, fractions := ways.GetIds(), ways.GetFractions()
	if len(ids)%4 != 0 || len(fractions) != 2*len(ids) {
		return failf(codes.DataLoss, "", "shortened has %d bytes of ids and %d of fractions; it needs 4 and 8 for each",
			len(ids), len(fractions))
	}
	for ; len(ids) > 0; ids, fractions = ids[4:], fractions[8:] {
		id, fraction := binary.LittleEndian.Uint32(ids), float64At(fractions)
		if last := len(s.IDs) - 1; last >= 0 && id <= s.IDs[last] {
			return failf(codes.DataLoss, "", "shortened.ids has %d after %d; they must ascend strictly", id, s.IDs[last])
		}
		if !(fraction >= 0 && fraction < 1) {
			return failf(codes.DataLoss, "", "shortened.fractions has %v; it must be in [0, 1)", fraction)
		}
		s.IDs, s.Fractions = append(s.IDs, id), append(s.Fractions, fraction)
	}
	return nil
}

// checkBelow checks that the ids are of a scene that has count meshes, or vertices.
func (s *Shortened) checkBelow(count uint64) error {
	if last := len(s.IDs) - 1; last >= 0 && uint64(s.IDs[last]) >= count {
		return failf(codes.DataLoss, "", "shortened.ids names %d; the frame has %d that may go a way of their own", s.IDs[last], count)
	}
	return nil
}
