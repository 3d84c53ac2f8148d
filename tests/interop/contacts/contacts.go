// The scene of contacts_test.py with the package for Go. usage: go run contacts.go ADDRESS
package main

import (
	"bufio"
	"context"
	"encoding/binary"
	"log"
	"os"

	collided "collided.invalid/client/go"
)

const side = 17

// sheet is one of bumps; every coordinate is exact.
func sheet(shift, height float64, a, b int) (points collided.F64) {
	for j := 0; j < side; j++ {
		for i := 0; i < side; i++ {
			bump := float64((a*i+b*j)%32) / 64
			points = append(points, [3]float64{0.25*float64(i) + shift, 0.25*float64(j) + shift, height + bump})
		}
	}
	return points
}

func triangles() (out [][3]uint32) {
	for j := uint32(0); j+1 < side; j++ {
		for i := uint32(0); i+1 < side; i++ {
			v := j*side + i
			out = append(out, [3]uint32{v, v + 1, v + side}, [3]uint32{v + 1, v + side + 1, v + side})
		}
	}
	return out
}

func frameOf(number int) (frame collided.Frame) {
	upper := sheet(0.125, 2-float64(number), 11, 5)
	update := collided.Update{Mesh: 1, Positions: upper}
	if number == 4 { // every third vertex alone, back through the lower sheet
		var some collided.F64
		for v := 0; v < len(upper); v += 3 {
			update.Indices = append(update.Indices, uint32(v))
			some = append(some, [3]float64{upper[v][0], upper[v][1], upper[v][2] + 3})
		}
		update.Positions = some
	}
	if number == 0 {
		frame.Updates = append(frame.Updates, collided.Update{Mesh: 0, Positions: sheet(0, 0, 7, 13)})
	}
	frame.Updates = append(frame.Updates, update)
	return frame
}

func put(out *bufio.Writer, c *collided.Contacts) {
	for _, array := range []any{uint32(c.Count), c.Elements, c.Stencils, c.TOI, c.Distance, c.Weights, c.Normals, c.Flags, c.Features} {
		check(binary.Write(out, binary.LittleEndian, array))
	}
}

func putBoth(out *bufio.Writer, contacts *collided.ContactSet) {
	put(out, &contacts.VertexTriangle)
	put(out, &contacts.EdgeEdge)
}

func main() {
	ctx := context.Background()
	client, err := collided.Connect(ctx, os.Args[1], collided.Options{})
	check(err)
	defer client.Close()
	spec := &collided.SceneSpec{Mode: collided.DCDAndCCD, Thickness: 0.25, PositionFormat: collided.FormatF64}
	for field := collided.FieldElements; field <= collided.FieldFeatures; field++ {
		spec.Fields = append(spec.Fields, field)
	}
	lower := collided.Mesh{Name: "lower", VertexCount: side * side, Triangles: triangles(), Motion: collided.Static}
	upper := collided.Mesh{Name: "upper", VertexCount: side * side, Triangles: triangles()}
	scene, err := client.CreateScene(ctx, spec, []collided.Mesh{lower, upper}, 0)
	check(err)
	stream, err := client.Stream(ctx, scene, collided.StreamOptions{})
	check(err)
	out := bufio.NewWriter(os.Stdout)
	for number := 0; number < 5; number++ {
		frame := frameOf(number)
		if number == 2 {
			trial := collided.Frame{Updates: frame.Updates, Trial: true, Advance: true, AdvanceMode: collided.PerVertex, Limits: true}
			tried, err := stream.Detect(ctx, trial)
			check(err)
			putBoth(out, &tried.Limits)
		}
		output, err := stream.Detect(ctx, frame)
		check(err)
		putBoth(out, &output.ContactSet)
		still, err := stream.Detect(ctx, collided.Frame{Mode: collided.DCD})
		check(err)
		putBoth(out, &still.ContactSet)
	}
	check(out.Flush())
	check(stream.Finish(ctx))
}

func check(err error) {
	if err != nil {
		log.Fatal(err)
	}
}
