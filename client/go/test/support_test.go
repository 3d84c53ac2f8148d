// Package test runs the client against the real daemon.
package test

import (
	"context"
	"errors"
	"regexp"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
)

var (
	floor    = collided.F32{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}
	triangle = [][3]uint32{{0, 1, 2}}
)

// within is a context for one test.
func within(t *testing.T) context.Context {
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	t.Cleanup(cancel)
	return ctx
}

// daemon starts one for the test.
func daemon(t *testing.T, options ...string) *collided.Daemon {
	t.Helper()
	d, err := collided.StartDaemon(within(t), append([]string{"--threads", "2"}, options...)...)
	if err != nil {
		t.Fatal(err)
	}
	t.Cleanup(d.Stop)
	return d
}

// connected is a client of a daemon of its own.
func connected(t *testing.T, options ...string) (context.Context, *collided.Client) {
	t.Helper()
	ctx := within(t)
	client, err := collided.Connect(ctx, daemon(t, options...).Address, collided.Options{})
	must(t, err)
	t.Cleanup(client.Close)
	return ctx, client
}

// tipAt is a triangle that stands on its corner, scene-wide vertex 3, which is at height z.
func tipAt(z float32) collided.F32 {
	return collided.F32{{1, 1, z}, {1.25, 1, 8 + z}, {1, 1.25, 8 + z}}
}

func twoTriangles() []collided.Mesh {
	return []collided.Mesh{{Name: "floor", VertexCount: 3, Triangles: triangle}, {Name: "tip", VertexCount: 3, Triangles: triangle}}
}

// fall: the tip falls from 1 to 1 - depth, and meets the floor at t = 1 / depth.
func fall(id uint64, depth float32) collided.Frame {
	return collided.Frame{ID: id, Updates: []collided.Update{
		{Mesh: 0, Positions: floor},
		{Mesh: 1, StartPositions: tipAt(1), Positions: tipAt(1 - depth)},
	}}
}

// fallScene is that of fall.
func fallScene(ctx context.Context, t *testing.T, client *collided.Client) *collided.Scene {
	t.Helper()
	return create(ctx, t, client, &collided.SceneSpec{Mode: collided.CCD}, twoTriangles())
}

func fallStream(ctx context.Context, t *testing.T, client *collided.Client) *collided.Stream {
	t.Helper()
	return stream(ctx, t, client, fallScene(ctx, t, client), collided.StreamOptions{})
}

func create(ctx context.Context, t *testing.T, client *collided.Client, spec *collided.SceneSpec,
	meshes []collided.Mesh) *collided.Scene {
	t.Helper()
	scene, err := client.CreateScene(ctx, spec, meshes, 0)
	must(t, err)
	return scene
}

func stream(ctx context.Context, t *testing.T, client *collided.Client, scene *collided.Scene,
	options collided.StreamOptions) *collided.Stream {
	t.Helper()
	stream, err := client.Stream(ctx, scene, options)
	must(t, err)
	t.Cleanup(stream.Close)
	return stream
}

func detect(ctx context.Context, t *testing.T, stream *collided.Stream, frame collided.Frame) *collided.Output {
	t.Helper()
	output, err := stream.Detect(ctx, frame)
	must(t, err)
	return output
}

func must(t *testing.T, err error) {
	t.Helper()
	if err != nil {
		t.Fatal(err)
	}
}

// refused expects an *Error with this code and field, whose message has `says`.
func refused(t *testing.T, err error, code codes.Code, field, says string) {
	t.Helper()
	var e *collided.Error
	if !errors.As(err, &e) {
		t.Fatalf("nothing was refused: %v", err)
	}
	if e.Code != code || e.Field != field || !regexp.MustCompile(says).MatchString(e.Message) {
		t.Fatalf("%v of %q: %s", e.Code, e.Field, e.Message)
	}
}

// same expects two values that print alike.
func same[T comparable](t *testing.T, got, want T) {
	t.Helper()
	if got != want {
		t.Fatalf("is %v instead of %v", got, want)
	}
}
