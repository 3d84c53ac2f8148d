// This program runs the Go client against a daemon that misbehaves. It reads lines "BEHAVIOUR SCENARIO ADDRESS" and runs
// all of them at once. For each it prints the code of the error, or ok, then the seconds that it took and the message.
package main

import (
	"bufio"
	"context"
	"errors"
	"fmt"
	"os"
	"strconv"
	"strings"
	"sync"
	"time"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

var (
	limit     time.Duration
	one       = [][3]uint32{{0, 1, 2}}
	meshes    = []collided.Mesh{{Name: "floor", VertexCount: 3, Triangles: one}, {Name: "tip", VertexCount: 3, Triangles: one}}
	floor     = collided.F32{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}
	tip       = collided.F32{{1, 1, 1}, {1.25, 1, 9}, {1, 1.25, 9}}
	updates   = []collided.Update{{Mesh: 0, Positions: floor}, {Mesh: 1, Positions: tip}}
	ctx       = context.Background()
	scenarios = map[string]func(*collided.Client) error{
		"stream": stream, "advance": advance, "limits": limits, "pairs": pairs, "session": session, "call": call, "watch": watch,
		"mesh": mesh, "list": list}
)

func spec() *collided.SceneSpec {
	return &collided.SceneSpec{Mode: collided.CCD, PositionFormat: collided.FormatF32}
}

func stream(client *collided.Client) error {
	scene, err := client.CreateScene(ctx, spec(), meshes, 0)
	if err != nil {
		return err
	}
	stream, err := client.Stream(ctx, scene, collided.StreamOptions{Window: 2})
	if err != nil {
		return err
	}
	defer stream.Close()
	limited, cancel := context.WithTimeout(ctx, limit)
	defer cancel()
	for i := 0; i < 2; i++ {
		if _, err := stream.Send(limited, collided.Frame{Updates: updates}); err != nil {
			return err
		}
	}
	for i := 0; i < 2; i++ {
		output, err := stream.Receive(limited)
		if err != nil {
			return err
		}
		if output.Err != nil {
			return output.Err
		}
	}
	return stream.Finish(ctx)
}

// begun opens a stream and detects a first frame.
func begun(client *collided.Client) (*collided.Stream, error) {
	scene, err := client.CreateScene(ctx, spec(), meshes, 0)
	if err != nil {
		return nil, err
	}
	stream, err := client.Stream(ctx, scene, collided.StreamOptions{})
	if err != nil {
		return nil, err
	}
	if _, err := stream.Detect(ctx, collided.Frame{Updates: updates}); err != nil {
		stream.Close()
		return nil, err
	}
	return stream, nil
}

func advance(client *collided.Client) error {
	stream, err := begun(client)
	if err != nil {
		return err
	}
	defer stream.Close()
	x, target := append(collided.F32{}, tip...), append(collided.F32{}, tip...)
	for i := range target {
		target[i][2] -= 2
	}
	output, err := stream.Detect(ctx, collided.Frame{Advance: true, AdvanceMode: collided.PerVertex,
		Updates: []collided.Update{{Mesh: 1, Positions: target}}})
	if err != nil {
		return err
	}
	if err := collided.MoveEachAlong(x, target, output.Shortened.Of(3, len(x))); err != nil {
		return err
	}
	done, shortened := output.Done, output.Shortened
	has := fmt.Sprint(done.GetAdvanced(), done.GetWay(), shortened.IDs, shortened.Fractions, x[0][2], x[1][2], x[2][2])
	if has != "0.25 0.75 [3 4] [0.25 0.5] 0.5 8 7" {
		return errors.New(has)
	}
	return stream.Finish(ctx)
}

func limits(client *collided.Client) error {
	stream, err := begun(client)
	if err != nil {
		return err
	}
	defer stream.Close()
	output, err := stream.Detect(ctx, collided.Frame{Advance: true, Limits: true, Updates: updates})
	if err != nil {
		return err
	}
	vertices, edges := output.Limits.VertexTriangle, output.Limits.EdgeEdge
	if has := fmt.Sprint(vertices.Elements, vertices.TOI, edges.Elements, edges.TOI); has != "[[3 0]] [0.5] [[0 3]] [0.75]" {
		return errors.New(has)
	}
	return stream.Finish(ctx)
}

func pairs(client *collided.Client) error {
	asked := spec()
	asked.Mode, asked.Fields = collided.DCD, []v1.ContactField{collided.FieldPairStates}
	scene, err := client.CreateScene(ctx, asked, meshes, 0)
	if err != nil {
		return err
	}
	stream, err := client.Stream(ctx, scene, collided.StreamOptions{})
	if err != nil {
		return err
	}
	defer stream.Close()
	output, err := stream.Detect(ctx, collided.Frame{Updates: updates})
	if err != nil {
		return err
	}
	has := fmt.Sprint(output.Pairs, output.VertexSolid.Distance, output.VertexTriangle.SignedDistances)
	if has != "[{0 1 MESH_PAIR_STATE_OVERLAPPING 0 1 3 0.25}] [-0.25] [-0.25]" {
		return errors.New(has)
	}
	return stream.Finish(ctx)
}

func session(client *collided.Client) (err error) {
	session, err := client.Session(ctx, spec(), meshes, collided.SessionOptions{
		Restore: func() []collided.Update { return updates }, GiveUp: limit})
	if err != nil {
		return err
	}
	limited, cancel := context.WithTimeout(ctx, 2*limit)
	defer cancel()
	_, err = session.Detect(limited, collided.Frame{Updates: updates})
	if closed := session.Close(ctx); err == nil {
		return closed
	}
	return err
}

func call(client *collided.Client) error {
	scene, err := client.CreateScene(ctx, spec(), meshes, 0)
	if err != nil {
		return err
	}
	_, err = client.Detect(ctx, scene, collided.Frame{ID: 1, Updates: updates})
	return err
}

func watch(client *collided.Client) error {
	scene, err := client.CreateScene(ctx, spec(), meshes, 0)
	if err != nil {
		return err
	}
	watcher, err := client.Watch(ctx, scene.SceneId, collided.WatchOptions{PositionMeshes: []uint32{1}})
	if err != nil {
		return err
	}
	defer watcher.Close()
	_, err = watcher.Receive()
	return err
}

func mesh(client *collided.Client) error {
	scene, err := client.CreateScene(ctx, spec(), meshes, 0)
	if err != nil {
		return err
	}
	_, err = client.GetMesh(ctx, scene.SceneId, 0)
	return err
}

func list(client *collided.Client) error {
	_, err := client.ListScenes(ctx)
	return err
}

func play(line string) {
	words := strings.Fields(line)
	begun := time.Now()
	client, err := collided.Connect(ctx, words[2], collided.Options{Token: words[0], Patience: limit, Deadline: limit})
	if err == nil {
		err = scenarios[words[1]](client)
		client.Close()
	}
	code, message := "ok", ""
	if err != nil {
		code, message = "UNTYPED", err.Error()
		var known *collided.Error
		if errors.As(err, &known) {
			code, message = name(known.Code.String()), known.Message
		}
	}
	if len(message) > 200 {
		message = message[:200]
	}
	fmt.Printf("%s %s %s %.3f %s\n", words[0], words[1], code, time.Since(begun).Seconds(), strings.ReplaceAll(message, "\n", " "))
}

// name is "DATA_LOSS" of "DataLoss".
func name(code string) string {
	var out strings.Builder
	for i, letter := range code {
		if i > 0 && letter >= 'A' && letter <= 'Z' {
			out.WriteByte('_')
		}
		out.WriteRune(letter)
	}
	return strings.ToUpper(out.String())
}

func main() {
	seconds, err := strconv.ParseFloat(os.Args[1], 64)
	if err != nil {
		panic(err)
	}
	limit = time.Duration(seconds * float64(time.Second))
	var group sync.WaitGroup
	for lines := bufio.NewScanner(os.Stdin); lines.Scan(); {
		group.Add(1)
		go func(line string) {
			defer group.Done()
			play(line)
		}(lines.Text())
	}
	group.Wait()
}
