package test

import (
	"context"
	"errors"
	"path/filepath"
	"reflect"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	collided "collided.invalid/client/go"
	v1 "collided.invalid/client/go/v1"
)

const frames = 12

// play has the tip go up and down through the floor: each frame's contacts depend on where the last one left it.
type play struct {
	name    string
	spec    *collided.SceneSpec
	motion  v1.MeshMotion // of the tip
	disturb func(frame int)
	session *collided.Session
}

// heightAt has a period: however many frames a test takes, only the tip's corner meets the floor.
func heightAt(frame int) float32 {
	frame %= 20
	if frame%2 == 1 {
		return 0.9 * (1 + float32(frame)/10)
	}
	return -1 - float32(frame)/10
}

func (p *play) meshes() []collided.Mesh {
	meshes := twoTriangles()
	meshes[0].Motion, meshes[1].Motion = collided.Static, p.motion
	return meshes
}

func (p *play) updateAt(frame int) collided.Update {
	if p.motion != collided.Rigid {
		return collided.Update{Mesh: 1, Positions: tipAt(heightAt(frame))}
	}
	up := float64(heightAt(frame)) - float64(heightAt(0))
	return collided.Update{Mesh: 1, Transform: &collided.Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, up}}
}

// run gives the contacts of each frame; disturb is called while a frame is on its way.
func (p *play) run(t *testing.T, address string) (contacts []collided.ContactSet) {
	t.Helper()
	ctx := within(t)
	client, err := collided.Connect(ctx, address, collided.Options{})
	must(t, err)
	defer client.Close()
	at := 0
	restore := func() []collided.Update { return []collided.Update{p.updateAt(at - 1)} }
	p.session, err = client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: restore, GiveUp: 30 * time.Second})
	must(t, err)
	for ; at < frames; at++ {
		frame := collided.Frame{Updates: []collided.Update{p.updateAt(at)}}
		if at == 0 {
			frame = first(floor, tipAt(heightAt(0)))
		}
		disturbed := make(chan struct{})
		go func() {
			if p.disturb != nil {
				p.disturb(at)
			}
			close(disturbed)
		}()
		output, err := p.session.Detect(ctx, frame)
		<-disturbed
		must(t, err)
		contacts = append(contacts, output.ContactSet)
	}
	must(t, p.session.Close(ctx))
	return contacts
}

func TestWhatIsLostIsRestored(t *testing.T) {
	plays := []*play{
		{name: "deformable", spec: &collided.SceneSpec{Mode: collided.CCD}},
		{name: "rigid", spec: &collided.SceneSpec{Mode: collided.CCD}, motion: collided.Rigid},
		{name: "both questions", spec: &collided.SceneSpec{Mode: collided.DCDAndCCD, MinSeparation: 1e-3}},
	}
	for _, p := range plays {
		t.Run(p.name, func(t *testing.T) {
			d := daemon(t)
			proxy := newProxy(t, d)
			undisturbed := p.run(t, d.Address)
			same(t, undisturbed[1].VertexTriangle.Count, 1)
			same(t, p.session.Reconnects, 0)

			p.disturb = func(frame int) {
				if frame%3 == 1 {
					proxy.cut()
				}
			}
			same(t, reflect.DeepEqual(p.run(t, proxy.address), undisturbed), true)
			same(t, p.session.Reconnects > 0, true)
			same(t, p.session.Recreations, 0)

			p.disturb = func(frame int) {
				if frame%6 == 0 {
					another := daemon(t)
					proxy.leadTo(another)
					proxy.cut()
				}
			}
			same(t, reflect.DeepEqual(p.run(t, proxy.address), undisturbed), true)
			same(t, p.session.Recreations > 0, true)
		})
	}
}

// rise has the tip rise from its first pose, its first move; disturb is called while that frame is in flight.
func rise(t *testing.T, address string, first collided.Frame, disturb func(sceneID string)) (*collided.Output, *collided.Session) {
	t.Helper()
	ctx := within(t)
	client, err := collided.Connect(ctx, address, collided.Options{})
	must(t, err)
	defer client.Close()
	p := &play{spec: &collided.SceneSpec{Mode: collided.CCD}, motion: collided.Rigid}
	nothingMoved := func() []collided.Update { return nil }
	session, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: nothingMoved})
	must(t, err)
	_, err = session.Detect(ctx, first)
	must(t, err)
	disturbed := make(chan struct{})
	go func() {
		disturb(session.Scene().SceneId)
		close(disturbed)
	}()
	output, err := session.Detect(ctx, collided.Frame{Updates: []collided.Update{p.updateAt(1)}})
	<-disturbed
	must(t, err)
	must(t, session.Close(ctx))
	return output, session
}

func TestARigidMeshWhoseFirstMoveHadNoAnswerMovesAgain(t *testing.T) {
	ctx := within(t)
	resting, lifted := first(floor, tipAt(heightAt(0))), first(floor, tipAt(heightAt(0)))
	lifted.Updates[1].Transform = &collided.Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5}
	for name, frame := range map[string]collided.Frame{"first positions": resting, "first transform": lifted} {
		t.Run(name, func(t *testing.T) {
			d := daemon(t)
			proxy := newProxy(t, d)
			observer, err := collided.Connect(ctx, d.Address, collided.Options{})
			must(t, err)
			defer observer.Close()
			undisturbed, _ := rise(t, d.Address, frame, func(string) {})
			same(t, undisturbed.VertexTriangle.Count, 1)
			output, session := rise(t, proxy.address, frame, func(sceneID string) {
				proxy.mute()
				for applied := uint64(1); applied < 2; {
					scene, err := observer.GetScene(ctx, sceneID)
					if err != nil {
						panic(err)
					}
					applied = scene.LastFrameId
				}
				proxy.cut()
			})
			same(t, [2]int{session.Reconnects, session.Recreations}, [2]int{1, 0})
			same(t, reflect.DeepEqual(output.ContactSet, undisturbed.ContactSet), true)
		})
	}
}

// mortal is a daemon that ends at once when it is stopped, a client that does not look for it for long, and what is played.
func mortal(t *testing.T) (*collided.Daemon, context.Context, *collided.Client, *play) {
	d := daemon(t, "--grace-seconds", "0")
	ctx := within(t)
	client, err := collided.Connect(ctx, d.Address, collided.Options{Patience: time.Second})
	must(t, err)
	t.Cleanup(func() { client.Close() })
	return d, ctx, client, &play{spec: &collided.SceneSpec{Mode: collided.CCD}}
}

func TestASessionIsClosedWhileThereIsNoConnection(t *testing.T) {
	d, ctx, client, p := mortal(t)
	restore := func() []collided.Update { return nil }
	session, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: restore})
	must(t, err)
	d.Stop()
	detected := make(chan error)
	go func() {
		_, err := session.Detect(ctx, first(floor, tipAt(heightAt(0))))
		detected <- err
	}()
	time.Sleep(200 * time.Millisecond) // it is trying to reconnect
	begin := time.Now()
	refused(t, session.Close(ctx), codes.Unavailable, "", "no daemon answers") // the scene may be there
	refused(t, <-detected, codes.FailedPrecondition, "", "the session is closed")
	same(t, time.Since(begin) < 5*time.Second, true)
}

func TestASessionGoesOnElsewhereAndLeavesADaemonThatDrains(t *testing.T) {
	folder := t.TempDir()
	member := func(name, graceSeconds string) *collided.Daemon {
		address := "unix:" + filepath.Join(folder, name) // streams go there, and calls by the proxy
		return daemon(t, "--grace-seconds", graceSeconds, "--address", address, "--endpoint", address)
	}
	gone, drained, last := member("a", "0"), member("b", "600"), member("c", "0")
	way := newProxy(t, gone)
	ctx := within(t)
	client, err := collided.Connect(ctx, way.address, collided.Options{})
	must(t, err)
	defer client.Close()
	p := &play{spec: &collided.SceneSpec{Mode: collided.CCD}}
	at := 0
	restore := func() []collided.Update { return []collided.Update{p.updateAt(at - 1)} }
	session, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: restore, GiveUp: 30 * time.Second})
	must(t, err)
	goOn := func() {
		frame := collided.Frame{Updates: []collided.Update{p.updateAt(at)}}
		if at == 0 {
			frame = first(floor, tipAt(heightAt(0)))
		}
		output, err := session.Detect(ctx, frame)
		must(t, err)
		if at > 0 {
			same(t, output.VertexTriangle.Count, 1)
		}
		at++
	}
	goOn()
	goOn()

	way.leadTo(drained)
	gone.Stop()
	goOn()
	goOn()
	same(t, session.Recreations, 1) // of a stream that broke, or that was left in time
	broken := session.Reconnects

	way.leadTo(last)
	stopped := make(chan struct{})
	go func() {
		drained.Stop()
		close(stopped)
	}()
	for session.Recreations == 1 {
		goOn()
	}
	<-stopped
	goOn()
	same(t, session.Reconnects, broken)
	same(t, session.Recreations, 2)
	must(t, session.Close(ctx))
}

func TestAStreamThatIdledOutIsOpenedAgain(t *testing.T) {
	ctx, client := connected(t, "--max-idle-seconds", "1")
	p := &play{spec: &collided.SceneSpec{Mode: collided.CCD}}
	restore := func() []collided.Update { return []collided.Update{p.updateAt(0)} }
	session, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: restore, Lease: time.Minute})
	must(t, err)
	_, err = session.Detect(ctx, first(floor, tipAt(heightAt(0))))
	must(t, err)
	var probe *collided.Stream
	for probe == nil { // refused while the session's is open
		probe, _ = client.Stream(ctx, session.Scene(), collided.StreamOptions{})
	}
	must(t, probe.Finish(ctx))
	output, err := session.Detect(ctx, collided.Frame{Updates: []collided.Update{p.updateAt(1)}})
	must(t, err)
	same(t, output.VertexTriangle.Count, 1)
	same(t, [2]int{session.Reconnects, session.Recreations}, [2]int{1, 0})
	must(t, session.Close(ctx))
}

func TestASessionTellsWhatItCannotDo(t *testing.T) {
	d, ctx, client, p := mortal(t)
	_, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{})
	refused(t, err, codes.InvalidArgument, "options.restore", "is not set")
	restore := func() []collided.Update { return []collided.Update{p.updateAt(0)} }
	options := collided.SessionOptions{Restore: restore, GiveUp: time.Second}
	session, err := client.Session(ctx, p.spec, p.meshes(), options)
	must(t, err)
	half := 0.5
	_, err = session.Detect(ctx, collided.Frame{Edit: &collided.SceneEdit{}})
	refused(t, err, codes.InvalidArgument, "frame.edit", "cannot be restored")
	_, err = session.Detect(ctx, collided.Frame{FromLastFraction: &half})
	refused(t, err, codes.InvalidArgument, "frame.from_last_fraction", "cannot be restored")
	_, err = session.Detect(ctx, collided.Frame{ID: 1})
	refused(t, err, codes.InvalidArgument, "frame.frame_id", "numbers its frames itself")
	_, err = session.Detect(ctx, first(floor, tipAt(1)))
	must(t, err)
	_, err = session.Detect(ctx, collided.Frame{Updates: []collided.Update{{Mesh: 1, Positions: tipAt(1)[:1]}}})
	refused(t, err, codes.InvalidArgument, "frame.updates[0].positions", ".")
	same(t, session.Reconnects, 0)
	over, cancel := context.WithCancel(ctx)
	cancel()
	if _, err = session.Detect(over, collided.Frame{Updates: []collided.Update{p.updateAt(1)}}); !errors.Is(err, context.Canceled) {
		t.Fatal(err)
	}
	output, err := session.Detect(ctx, collided.Frame{Updates: []collided.Update{p.updateAt(1)}})
	must(t, err)
	same(t, output.VertexTriangle.Count, 1) // it begins where Restore has it, below the floor
	same(t, session.Reconnects, 1)
	closing, err := client.Session(ctx, p.spec, p.meshes(), collided.SessionOptions{Restore: restore})
	must(t, err)
	must(t, client.DeleteScene(ctx, closing.Scene().SceneId))
	must(t, closing.Close(ctx))
	_, err = closing.Detect(ctx, first(floor, tipAt(1)))
	refused(t, err, codes.FailedPrecondition, "", "closed")
	d.Stop()
	_, err = session.Detect(ctx, collided.Frame{Updates: []collided.Update{p.updateAt(1)}})
	refused(t, err, codes.Unavailable, "", "no daemon answers at unix:")
}
