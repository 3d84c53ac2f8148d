package test

import (
	"errors"
	"reflect"
	"testing"

	"context"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
)

func TestAWatcherSeesEachFrame(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	options := collided.WatchOptions{MaxContactsPerKind: 1, PositionMeshes: []uint32{1, 0}, VertexStride: 2}
	watcher, err := client.Watch(ctx, scene.SceneId, options)
	must(t, err)
	defer watcher.Close()
	same(t, watcher.VertexStride(), 2)
	same(t, watcher.Scene().SceneId, scene.SceneId)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	sent := detect(ctx, t, s, fall(0, 2))
	seen, err := watcher.Receive()
	must(t, err)
	same(t, [4]uint64{seen.FrameID, seen.SkippedFrames, seen.OmittedContacts, seen.EditCount}, [4]uint64{1, 0, 0, 0})
	if !reflect.DeepEqual(seen.ContactSet, sent.ContactSet) {
		t.Fatal(seen.ContactSet)
	}
	tip := tipAt(-1)
	want := []collided.SampledPositions{{Mesh: 1, VertexStride: 2, Positions: collided.F32{tip[0], tip[2]}},
		{Mesh: 0, VertexStride: 2, Positions: collided.F32{floor[0], floor[2]}}}
	if !reflect.DeepEqual(seen.Positions, want) {
		t.Fatal(seen.Positions)
	}
	must(t, s.Finish(ctx))
	must(t, client.DeleteScene(ctx, scene.SceneId))
	_, err = watcher.Receive()
	refused(t, err, codes.NotFound, "scene_id", "deleted")
}

func TestASlowWatcherIsToldWhatItMissed(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	watcher, err := client.Watch(ctx, scene.SceneId, collided.WatchOptions{})
	must(t, err)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	const count = 100
	for i := 0; i < count; i++ {
		detect(ctx, t, s, fall(0, 2))
	}
	seen := uint64(0)
	for last := uint64(0); last < count; {
		frame, err := watcher.Receive()
		must(t, err)
		seen, last = seen+1+frame.SkippedFrames, frame.FrameID
	}
	same(t, seen, count)
	watcher.Close()
	if _, err := watcher.Receive(); !errors.Is(err, context.Canceled) {
		t.Fatal(err)
	}
	must(t, s.Finish(ctx))
}

func TestAWatchThatCannotBeIsRefused(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	_, err := client.Watch(ctx, scene.SceneId, collided.WatchOptions{PositionMeshes: []uint32{7}})
	refused(t, err, codes.InvalidArgument, "position_meshes[0]", "7")
	_, err = client.Watch(ctx, "none", collided.WatchOptions{})
	refused(t, err, codes.NotFound, "scene_id", ".")
}
