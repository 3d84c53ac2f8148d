// One triangle falls through another. go run . [ADDRESS]: without one it starts a daemon of its own.
package main

import (
	"context"
	"fmt"
	"log"
	"os"
	"strings"

	collided "collided.invalid/client/go"
)

func main() {
	ctx := context.Background()
	client, err := collided.Connect(ctx, strings.Join(os.Args[1:], ""), collided.Options{})
	check(err)
	defer client.Close()
	one := [][3]uint32{{0, 1, 2}}
	meshes := []collided.Mesh{{Name: "floor", VertexCount: 3, Triangles: one}, {Name: "falling", VertexCount: 3, Triangles: one}}
	scene, err := client.CreateScene(ctx, &collided.SceneSpec{Mode: collided.CCD}, meshes, 0)
	check(err)
	output, err := client.Detect(ctx, scene, collided.Frame{ID: 1, Updates: []collided.Update{
		{Mesh: 0, Positions: collided.F32{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}},
		{Mesh: 1, StartPositions: collided.F32{{1, 1, 1}, {1.25, 1, 9}, {1, 1.25, 9}}, // t = 0
			Positions: collided.F32{{1, 1, -1}, {1.25, 1, 7}, {1, 1.25, 7}}}, // t = 1
	}})
	check(err)
	for i, ids := range output.VertexTriangle.Elements { // vertex 3, triangle 0, t = 0.500000000
		fmt.Printf("vertex %d, triangle %d, t = %.9f\n", ids[0], ids[1], output.VertexTriangle.TOI[i])
	}
	check(client.DeleteScene(ctx, scene.SceneId))
}

func check(err error) {
	if err != nil {
		log.Fatal(err)
	}
}
