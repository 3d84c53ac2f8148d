package collided

import (
	"encoding/binary"
	"math"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

// NoVertex stands for a vertex where there is none.
const NoVertex = uint32(math.MaxUint32)

// PairOfMeshes says whether two meshes, one of them a solid, touch, overlap, or are one inside the other. Pairs that are apart have none.
type PairOfMeshes struct {
	// First and Second are indices of the meshes in the scene's spec; First is the lower one.
	First, Second uint32
	// State is PairTouching, PairOverlapping, PairFirstInside or PairSecondInside.
	State v1.MeshPairState
	// FirstInside is how many vertices of the first mesh are inside the second; SecondInside the same the other way round.
	FirstInside, SecondInside uint32
	// Deepest is the deepest of these vertices, scene-wide, the least of several; NoVertex if there is none.
	Deepest uint32
	// Depth is its distance from the other mesh's surface, in the unit of the positions; 0 if there is none.
	Depth float64
}

// addPairs appends what one message of an answer has. DataLoss if that cannot be.
func (o *Output) addPairs(pairs *v1.MeshPairs) error {
	count := len(pairs.GetStates())
	for _, column := range []struct {
		name       string
		has, width int
	}{
		{"meshes", len(pairs.GetMeshes()), 8}, {"inside", len(pairs.GetInside()), 8}, {"deepest", len(pairs.GetDeepest()), 4},
		{"depths", len(pairs.GetDepths()), 8},
	} {
		if column.has != column.width*count {
			return failf(codes.DataLoss, "", "pairs.%s has %d bytes for %d pairs; it needs %d",
				column.name, column.has, count, column.width*count)
		}
	}
	for i := 0; i < count; i++ {
		meshes, inside := uint32s[[2]uint32](pairs.Meshes[8*i:]), uint32s[[2]uint32](pairs.Inside[8*i:])
		pair := PairOfMeshes{First: meshes[0], Second: meshes[1], State: v1.MeshPairState(pairs.States[i]), FirstInside: inside[0],
			SecondInside: inside[1], Deepest: binary.LittleEndian.Uint32(pairs.Deepest[4*i:]), Depth: float64At(pairs.Depths[8*i:])}
		if err := o.addPair(pair); err != nil {
			return err
		}
	}
	return nil
}

func (o *Output) addPair(pair PairOfMeshes) error {
	if pair.First >= pair.Second {
		return failf(codes.DataLoss, "", "pairs.meshes has %d and %d; the lower index must be first", pair.First, pair.Second)
	}
	if last := len(o.Pairs) - 1; last >= 0 && !o.Pairs[last].isBefore(pair) {
		return failf(codes.DataLoss, "", "pairs.meshes has %d and %d after %d and %d; they must ascend strictly",
			pair.First, pair.Second, o.Pairs[last].First, o.Pairs[last].Second)
	}
	if pair.State < PairTouching || pair.State > PairSecondInside {
		return failf(codes.DataLoss, "", "pairs.states has %d, which this client does not know", pair.State)
	}
	if hasInside := pair.FirstInside > 0 || pair.SecondInside > 0; hasInside != (pair.Deepest != NoVertex) {
		return failf(codes.DataLoss, "", "pairs.deepest has %d where %d and %d vertices are inside",
			pair.Deepest, pair.FirstInside, pair.SecondInside)
	}
	if !(pair.Depth >= 0) || math.IsInf(pair.Depth, 1) {
		return failf(codes.DataLoss, "", "pairs.depths has %v; it must be 0 or more, and finite", pair.Depth)
	}
	o.Pairs = append(o.Pairs, pair)
	return nil
}

func (p PairOfMeshes) isBefore(other PairOfMeshes) bool {
	return p.First < other.First || p.First == other.First && p.Second < other.Second
}

// checkPairs checks that the scene has what Pairs name.
func (o *Output) checkPairs(size sceneSize) error {
	for _, pair := range o.Pairs {
		if uint64(pair.Second) >= size.meshes {
			return failf(codes.DataLoss, "", "pairs.meshes names %d; the scene has %d meshes", pair.Second, size.meshes)
		}
		if pair.Deepest != NoVertex && uint64(pair.Deepest) >= size.vertices {
			return failf(codes.DataLoss, "", "pairs.deepest names %d; the scene has %d vertices", pair.Deepest, size.vertices)
		}
	}
	return nil
}
