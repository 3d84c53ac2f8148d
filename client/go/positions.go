package collided

import (
	"encoding/binary"
	"fmt"
	"math"

	v1 "collided.invalid/client/go/v1"
)

// Positions of vertices, x y z each, as a scene's format has them: F32, F64 or Q16.
type Positions interface {
	format() v1.PositionFormat
	pack() []byte
}

// F32 are positions of scenes of POSITION_FORMAT_F32, which is the default.
type F32 [][3]float32

// F64 are positions of scenes of POSITION_FORMAT_F64.
type F64 [][3]float64

// Q16 are positions of scenes of POSITION_FORMAT_Q16: PackQuantized.
type Q16 [][3]uint16

// Matrix has the rows of [R | t], which move p to R p + t.
type Matrix [12]float64

// Real is what positions are computed with.
type Real interface{ ~float32 | ~float64 }

func (F32) format() v1.PositionFormat { return FormatF32 }
func (F64) format() v1.PositionFormat { return FormatF64 }
func (Q16) format() v1.PositionFormat { return FormatQ16 }

func (positions F32) pack() []byte {
	bytes := make([]byte, 0, 12*len(positions))
	for _, p := range positions {
		for _, x := range p {
			bytes = binary.LittleEndian.AppendUint32(bytes, math.Float32bits(x))
		}
	}
	return bytes
}

func (positions F64) pack() []byte {
	bytes := make([]byte, 0, 24*len(positions))
	for _, p := range positions {
		for _, x := range p {
			bytes = binary.LittleEndian.AppendUint64(bytes, math.Float64bits(x))
		}
	}
	return bytes
}

func (positions Q16) pack() []byte {
	bytes := make([]byte, 0, 6*len(positions))
	for _, p := range positions {
		for _, q := range p {
			bytes = binary.LittleEndian.AppendUint16(bytes, q)
		}
	}
	return bytes
}

func (m *Matrix) pack() []byte {
	if m == nil {
		return nil
	}
	bytes := make([]byte, 0, 8*len(m))
	for _, x := range m {
		bytes = binary.LittleEndian.AppendUint64(bytes, math.Float64bits(x))
	}
	return bytes
}

// packPositions refuses those of another format: to round them or not is for the caller to say.
func packPositions(positions Positions, format v1.PositionFormat, field string) ([]byte, error) {
	if positions == nil {
		return nil, nil
	}
	if format == v1.PositionFormat_POSITION_FORMAT_UNSPECIFIED {
		format = FormatF32
	}
	if positions.format() != format {
		return nil, invalidf(field, "is %T; the scene's position_format is %v", positions, format)
	}
	return positions.pack(), nil
}

// shownBytes is how many bytes a vertex's position has where the daemon shows it: F64 as such, and all other formats as F32.
func shownBytes(format v1.PositionFormat) int {
	if format == FormatF64 {
		return 24
	}
	return 12
}

// unpackPositions has the positions that the daemon shows of a scene with positions of format.
func unpackPositions(bytes []byte, format v1.PositionFormat) Positions {
	if format == FormatF64 {
		positions := make(F64, len(bytes)/24)
		for i := range positions {
			for k := range positions[i] {
				positions[i][k] = math.Float64frombits(binary.LittleEndian.Uint64(bytes[24*i+8*k:]))
			}
		}
		return positions
	}
	positions := make(F32, len(bytes)/12)
	for i := range positions {
		positions[i] = threeFloat32s(bytes[12*i:])
	}
	return positions
}

// MoveAlong moves positions in place the fraction of the way to target that the daemon moved them: Done.Advanced, or a
// frame's FromLastFraction. Every bit is the daemon's; client/STEPPING.md has the formula. InvalidArgument if there are
// not as many of one as of the other, or the fraction is not from 0 to 1.
func MoveAlong[T Real](positions, target [][3]T, fraction float64) error {
	if len(positions) != len(target) {
		return invalidf("target", "has %d vertices, positions have %d", len(target), len(positions))
	}
	if !isFraction(fraction) {
		return invalidf("fraction", "is %v; it must be from 0 to 1", fraction)
	}
	for i := range positions {
		moveOneAlong(&positions[i], &target[i], fraction)
	}
	return nil
}

// MoveEachAlong moves each vertex in place by a fraction of its own, as MoveAlong does. Output.Shortened.Of has the fractions.
// InvalidArgument if there are not as many of them and of target as of positions, or one is not from 0 to 1.
func MoveEachAlong[T Real](positions, target [][3]T, fractions []float64) error {
	if len(positions) != len(target) {
		return invalidf("target", "has %d vertices, positions have %d", len(target), len(positions))
	}
	if len(positions) != len(fractions) {
		return invalidf("fractions", "has %d numbers, positions have %d vertices", len(fractions), len(positions))
	}
	for i, fraction := range fractions {
		if !isFraction(fraction) {
			return invalidf(fmt.Sprintf("fractions[%d]", i), "is %v; it must be from 0 to 1", fraction)
		}
	}
	for i, fraction := range fractions {
		moveOneAlong(&positions[i], &target[i], fraction)
	}
	return nil
}

func moveOneAlong[T Real](position, target *[3]T, fraction float64) {
	switch fraction {
	case 0:
	case 1:
		*position = *target
	default:
		for k := range position {
			x := float64(position[k])
			// Without the conversions a compiler may fuse the operations, which rounds less often.
			position[k] = T(x + float64(fraction*float64(float64(target[k])-x)))
		}
	}
}

// MoveRigidly moves the first positions of a rigid mesh in place to where the pose has them. Every bit is the daemon's;
// proto/CONVENTIONS.md has the formula.
func MoveRigidly[T Real](positions [][3]T, pose *Matrix) {
	for i := range positions {
		x, y, z := float64(positions[i][0]), float64(positions[i][1]), float64(positions[i][2])
		for row := range positions[i] {
			r := pose[4*row : 4*row+4]
			// Not fused, as in moveOneAlong.
			positions[i][row] = T(float64(float64(float64(r[0]*x)+float64(r[1]*y))+float64(r[2]*z)) + r[3])
		}
	}
}

// PoseAlong returns the pose of a rigid mesh at a fraction of the way from the pose start to target, where an advance ends:
// Output.Shortened.Of has the fraction, which is the mesh's own or the least of its vertices. Every bit is the daemon's, which takes
// turns of up to 3 radians; proto/CONVENTIONS.md has the formula. InvalidArgument if a pose is nil, the fraction is not from 0 to 1,
// or, between these, the rotations are half a turn apart or not finite.
func PoseAlong(start, target *Matrix, fraction float64) (*Matrix, error) {
	if start == nil {
		return nil, invalidf("start", "is nil")
	}
	if target == nil {
		return nil, invalidf("target", "is nil")
	}
	if !isFraction(fraction) {
		return nil, invalidf("fraction", "is %v; it must be from 0 to 1", fraction)
	}
	pose := *start
	switch fraction {
	case 0:
		return &pose, nil
	case 1:
		pose = *target
		return &pose, nil
	}
	// The names of proto/CONVENTIONS.md. Not fused, as in moveOneAlong.
	f := fraction
	c, v, err := halfTurn(start, target)
	if err != nil {
		return nil, err
	}
	turn := func(along, across, turned float64, x vector) vector {
		return plus(times(along, x), plus(times(float64(across*dot(v, x)), v), times(turned, cross(v, x))))
	}
	q, m := dot(v, v), float64(2*f)-1
	h := float64(2*float64(f*(1-f))) / (c + math.Sqrt(math.Max(0, 1-float64(float64(m*m)*q))))
	s, r := float64(f*c)+float64(h*q), f-float64(h*c)
	for k := 0; k < 3; k++ {
		a := start.column(k)
		back := turn(1-float64(2*q), 2, float64(-2*c), target.column(k))
		pose.put(k, turn(1-float64(2*float64(r*q)), float64(2*r), float64(2*s), plus(a, times(f, minus(back, a)))))
	}
	t := start.column(3)
	way := minus(target.column(3), t)
	pose.put(3, plus(t, plus(times(f, way), times(h, cross(way, v)))))
	return &pose, nil
}

// halfTurn is the rotation from one pose to another as a unit quaternion.
func halfTurn(start, target *Matrix) (float64, vector, error) {
	cosine, sine := 1.0, vector{}
	for k := 0; k < 3; k++ {
		a, b := start.column(k), target.column(k)
		cosine += dot(a, b)
		sine = plus(sine, cross(a, minus(b, a)))
	}
	if !(cosine > 0) || math.IsInf(cosine, 1) {
		return 0, sine, invalidf("target", "has a rotation that is half a turn from that of start, or one of them is not finite; they must turn by less")
	}
	length := math.Sqrt(float64(cosine*cosine) + dot(sine, sine))
	return cosine / length, times(1/length, sine), nil
}

type vector [3]float64

// column is one of [R | t], 0 to 3.
func (m *Matrix) column(k int) vector { return vector{m[k], m[4+k], m[8+k]} }

func (m *Matrix) put(k int, column vector) { m[k], m[4+k], m[8+k] = column[0], column[1], column[2] }

func plus(a, b vector) vector { return vector{a[0] + b[0], a[1] + b[1], a[2] + b[2]} }

func minus(a, b vector) vector { return vector{a[0] - b[0], a[1] - b[1], a[2] - b[2]} }

// times rounds each product: no sum that takes it is fused with it.
func times(s float64, a vector) vector {
	return vector{float64(s * a[0]), float64(s * a[1]), float64(s * a[2])}
}

func dot(a, b vector) float64 {
	return float64(float64(a[0]*b[0])+float64(a[1]*b[1])) + float64(a[2]*b[2])
}

func cross(a, b vector) vector {
	return vector{
		float64(a[1]*b[2]) - float64(a[2]*b[1]),
		float64(a[2]*b[0]) - float64(a[0]*b[2]),
		float64(a[0]*b[1]) - float64(a[1]*b[0]),
	}
}

const lastQ16 = 65535

// PackQuantized encodes positions as Q16, each coordinate to the nearest step of the box. InvalidArgument for a box without
// three finite coordinates each, in order, and for a position that is not in it: what is clamped is not where it was.
func PackQuantized[T Real](positions [][3]T, box *QuantizationBox) (Q16, error) {
	steps, err := stepsOf(box)
	if err != nil {
		return nil, err
	}
	out := make(Q16, len(positions))
	for i := range positions {
		for k := range positions[i] {
			x, lower, upper := float64(positions[i][k]), box.Lower[k], box.Upper[k]
			if !(x >= lower && x <= upper) {
				field := fmt.Sprintf("positions[%d][%d]", i, k)
				return nil, invalidf(field, "is %v, outside the box, %v to %v", x, lower, upper)
			}
			if steps[k] > 0 {
				out[i][k] = uint16(math.Min(math.Round((x-lower)/steps[k]), lastQ16))
			}
		}
	}
	return out, nil
}

// UnpackQuantized tells where the daemon has positions that are encoded as Q16.
func UnpackQuantized(encoded Q16, box *QuantizationBox) (F32, error) {
	steps, err := stepsOf(box)
	if err != nil {
		return nil, err
	}
	out := make(F32, len(encoded))
	for i := range encoded {
		for k, q := range encoded[i] {
			out[i][k] = float32(box.Lower[k] + float64(float64(q)*steps[k]))
		}
	}
	return out, nil
}

func stepsOf(box *QuantizationBox) ([3]float64, error) {
	var steps [3]float64
	if len(box.GetLower()) != 3 || len(box.GetUpper()) != 3 {
		return steps, invalidf("box", "has %d and %d coordinates, 3 each are needed", len(box.GetLower()), len(box.GetUpper()))
	}
	for k := range steps {
		lower, upper := box.Lower[k], box.Upper[k]
		isFinite := !math.IsInf(lower, 0) && !math.IsInf(upper, 0)
		if !isFinite || !(lower <= upper) {
			return steps, invalidf("box", "is from %v to %v; both must be finite and in order", lower, upper)
		}
		steps[k] = (upper - lower) / lastQ16
	}
	return steps, nil
}
