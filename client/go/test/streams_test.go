package test

import (
	"context"
	"errors"
	"math"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
)

func TestAWindowOfFramesIsInFlight(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	s := stream(ctx, t, client, scene, collided.StreamOptions{Window: 3})
	same(t, s.Window(), 3)
	const count = 20
	go func() {
		positions := tipAt(0)
		for i := 1; i <= count; i++ {
			frame := collided.Frame{Updates: []collided.Update{{Mesh: 1, StartPositions: tipAt(1), Positions: positions}}}
			positions[0][2] = -float32(i)
			if i == 1 {
				frame = fall(0, 2)
			} else if i == 4 {
				positions[0][2] = float32(math.NaN())
			}
			if _, err := s.Send(ctx, frame); err != nil {
				panic(err)
			}
		}
		if err := s.Finish(ctx); err != nil {
			panic(err)
		}
	}()
	for i := uint64(1); i <= count; i++ {
		output, err := s.Receive(ctx)
		must(t, err)
		same(t, output.FrameID, i)
		if i == 4 {
			refused(t, output.Err, codes.InvalidArgument, "frame.updates[0].positions", ".")
		} else {
			same(t, output.VertexTriangle.Count > 0, true)
		}
	}
	_, err := s.Receive(ctx)
	refused(t, err, codes.FailedPrecondition, "", "as Finish asked for")
	_, err = s.Send(ctx, fall(0, 2))
	refused(t, err, codes.FailedPrecondition, "", "as Finish asked for")
}

func TestManyGoroutinesShareAStream(t *testing.T) {
	ctx, client := connected(t)
	s := stream(ctx, t, client, fallScene(ctx, t, client), collided.StreamOptions{Window: 4})
	detect(ctx, t, s, fall(0, 2))
	failures := make(chan error)
	for i := 0; i < 8; i++ {
		go func(depth float32) {
			for n := 0; n < 10; n++ {
				output, err := s.Detect(ctx, fall(0, depth))
				if err == nil && math.Abs(output.VertexTriangle.TOI[0]-1/float64(depth)) > 1e-3 {
					err = errors.New("an output of another frame")
				}
				if err != nil {
					failures <- err
					return
				}
			}
			failures <- nil
		}(float32(i) + 2)
	}
	for i := 0; i < 8; i++ {
		must(t, <-failures)
	}
	must(t, s.Finish(ctx))
}

func TestLatestWinsTellsWhichFramesWereSkipped(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	latest := collided.StreamOptions{Window: 8, Delivery: collided.LatestWins}
	s := stream(ctx, t, client, scene, latest)
	const count = 200
	for i := 0; i < count; i++ {
		_, err := s.Send(ctx, fall(0, 2))
		must(t, err)
	}
	must(t, s.Finish(ctx))
	for i := uint64(1); i <= count; i++ {
		output, err := s.Receive(ctx)
		must(t, err)
		same(t, output.FrameID, i)
		same(t, output.Skipped, output.Done == nil)
		same(t, output.VertexTriangle.Count == 0, output.Skipped)
	}
}

func TestAStreamIsOpenedAsAskedOrNotAtAll(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	_, err := client.Stream(ctx, scene, collided.StreamOptions{Window: 100_000})
	refused(t, err, codes.ResourceExhausted, "open.window", "100000")
	first := stream(ctx, t, client, scene, collided.StreamOptions{})
	_, err = client.Stream(ctx, scene, collided.StreamOptions{})
	refused(t, err, codes.FailedPrecondition, "open.resume_token", "another stream")
	_, err = client.Stream(ctx, scene, collided.StreamOptions{ResumeToken: "wrong"})
	refused(t, err, codes.PermissionDenied, "open.resume_token", ".")
	_, err = client.Stream(ctx, nil, collided.StreamOptions{})
	refused(t, err, codes.NotFound, "scene_id", ".")
	detect(ctx, t, first, fall(0, 2))
	second, err := client.Resume(ctx, scene, collided.StreamOptions{})
	must(t, err)
	defer second.Close()
	same(t, second.Scene().LastFrameId, 1)
	_, err = first.Detect(ctx, fall(0, 2))
	refused(t, err, codes.Aborted, "open.scene_id", "took over")
	same(t, detect(ctx, t, second, fall(0, 2)).FrameID, 2)
}

func TestAUsedIDLeavesThoseThatTheStreamGives(t *testing.T) {
	ctx, client := connected(t)
	s := fallStream(ctx, t, client)
	detect(ctx, t, s, fall(10, 2))
	_, err := s.Detect(ctx, fall(3, 2))
	refused(t, err, codes.FailedPrecondition, "frame.frame_id", "is 3")
	same(t, detect(ctx, t, s, fall(0, 2)).FrameID, 11)
	must(t, s.Finish(ctx))
}

func TestADaemonThatDoesNotReadHoldsNobodyBeyondHisContext(t *testing.T) {
	ctx := within(t)
	way := newProxy(t, daemon(t))
	client, err := collided.Connect(ctx, way.address, collided.Options{})
	must(t, err)
	defer client.Close()
	const count = 300_000 // more bytes than are sent before a daemon reads
	large := []collided.Mesh{{Name: "large", VertexCount: count, Triangles: triangle}}
	scene := create(ctx, t, client, &collided.SceneSpec{Mode: collided.DCD}, large)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	frame := collided.Frame{Updates: []collided.Update{{Positions: make(collided.F32, count)}}}
	soon, cancel := context.WithTimeout(ctx, 200*time.Millisecond)
	defer cancel()
	way.stalled.Lock()
	begin := time.Now()
	_, sent := s.Send(soon, frame)
	_, detected := s.Detect(soon, frame)
	finished := s.Finish(soon)
	same(t, time.Since(begin) < 5*time.Second, true)
	way.stalled.Unlock()
	must(t, sent)
	for _, err := range []error{detected, finished} {
		if !errors.Is(err, context.DeadlineExceeded) {
			t.Fatal(err)
		}
	}
	must(t, s.Finish(ctx))
	output, err := s.Receive(ctx)
	must(t, err)
	same(t, output.FrameID, 1)
}

func TestWhoeverWaitsIsTold(t *testing.T) {
	ctx, client := connected(t)
	scene := fallScene(ctx, t, client)
	s := stream(ctx, t, client, scene, collided.StreamOptions{})
	soon, cancel := context.WithTimeout(ctx, 10*time.Millisecond)
	defer cancel()
	if _, err := s.Receive(soon); !errors.Is(err, context.DeadlineExceeded) {
		t.Fatal(err)
	}
	received := make(chan error)
	go func() {
		_, err := s.Receive(ctx)
		received <- err
	}()
	must(t, client.DeleteScene(ctx, scene.SceneId))
	refused(t, <-received, codes.NotFound, "scene_id", "deleted")
	refused(t, s.Finish(ctx), codes.NotFound, "scene_id", "deleted")
	over, end := context.WithCancel(ctx)
	other, err := client.Stream(over, fallScene(ctx, t, client), collided.StreamOptions{})
	must(t, err)
	end()
	if _, err := other.Receive(ctx); !errors.Is(err, context.Canceled) {
		t.Fatal(err)
	}
}

func TestADrainIsAnnounced(t *testing.T) {
	d := daemon(t, "--grace-seconds", "30")
	ctx := within(t)
	client, err := collided.Connect(ctx, d.Address, collided.Options{})
	must(t, err)
	defer client.Close()
	s := fallStream(ctx, t, client)
	stopped := make(chan struct{})
	go func() {
		d.Stop()
		close(stopped)
	}()
	for isDraining := false; !isDraining; time.Sleep(time.Millisecond) {
		var left time.Duration
		if left, isDraining = s.Draining(); left > 30*time.Second {
			t.Fatal(left)
		}
	}
	same(t, detect(ctx, t, s, fall(0, 2)).VertexTriangle.Count, 1)
	must(t, s.Finish(ctx))
	<-stopped
}
