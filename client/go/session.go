package collided

import (
	"context"
	"strings"
	"sync/atomic"
	"time"

	"google.golang.org/grpc/codes"

	v1 "collided.invalid/client/go/v1"
)

const (
	firstPause   = 50 * time.Millisecond
	longestPause = 2 * time.Second
	leavePause   = time.Second
)

// SessionOptions tell how a session is opened.
type SessionOptions struct {
	// Restore tells where the meshes are before the frame that is being sent: positions of every deformable mesh, the
	// transform of every rigid one that has moved. Called after a loss only. With Advance that is where MoveAlong, MoveEachAlong
	// and PoseAlong have them.
	Restore func() []Update
	// GiveUp is how long to try to get the connection back before Detect fails; 0: 60 s.
	GiveUp time.Duration
	// Lease is as of CreateScene.
	Lease time.Duration
}

// Session is a scene and its stream that survive the loss of the connection, and of the daemon. Positions are absolute, so that
// after a loss the scene's first frame, if the scene had to be created again, and one whole frame (Restore) put it where it
// was; then the frame that had no answer is sent again. One goroutine at a time sends frames.
type Session struct {
	ctx       context.Context // ends with Close, too
	end       context.CancelFunc
	isClosed  atomic.Bool
	connector *connector
	input     *sceneInput
	options   SessionOptions
	busy      chan struct{} // has room unless Detect or Close uses what follows
	scene     *Scene
	stream    *Stream   // nil: lost
	first     *v1.Frame // the scene's, which fixes static and rigid meshes and what is at rest
	nextLeave time.Time // when leaving a daemon that stops is tried

	// Reconnects counts how often a stream was opened again.
	Reconnects int
	// Recreations counts how often the scene was created again.
	Recreations int
}

func openSession(ctx context.Context, connector *connector, input *sceneInput, options SessionOptions) (*Session, error) {
	if options.Restore == nil {
		return nil, invalidf("options.restore", "is not set")
	}
	if options.GiveUp < 0 {
		return nil, invalidf("options.give_up", "is %v; it must not be negative", options.GiveUp)
	}
	if options.GiveUp == 0 {
		options.GiveUp = time.Minute
	}
	s := &Session{connector: connector, input: input, options: options, busy: make(chan struct{}, 1)}
	s.ctx, s.end = context.WithCancel(ctx)
	err := s.withClient(ctx, func(client *Client) (err error) {
		s.stream, err = s.create(ctx, client)
		return err
	})
	if err != nil {
		s.end()
		return nil, err
	}
	return s, nil
}

// Scene is as it was created last.
func (s *Session) Scene() *Scene { return s.scene }

// Detect sends a frame and waits for its output, over as many connections as it takes. It fails if the frame is refused, if
// there is no connection for GiveUp, once ctx ends, and for frames that depend on more than positions: Edit, FromLastFraction.
func (s *Session) Detect(ctx context.Context, frame Frame) (*Output, error) {
	select {
	case s.busy <- struct{}{}:
		defer s.release()
	default:
		return nil, failf(codes.FailedPrecondition, "", "Detect was called before its last call was over")
	}
	if s.isClosed.Load() {
		return nil, errClosed
	}
	message, err := s.repeatable(frame)
	if err != nil {
		return nil, err
	}
	ctx, cancel := context.WithCancel(ctx)
	defer cancel()
	defer callOnceDone(s.ctx, cancel)()
	output, err := s.insist(ctx, message)
	if err != nil {
		return nil, s.told(err)
	}
	if s.first == nil && !message.Trial {
		s.first = message
	}
	return output, nil
}

var errClosed error = failf(codes.FailedPrecondition, "", "the session is closed")

// told is the error of a frame, or of the session's end, which withdraws it.
func (s *Session) told(err error) error {
	switch {
	case s.isClosed.Load():
		return errClosed
	case s.ctx.Err() != nil:
		return contextError(s.ctx.Err())
	}
	return err
}

// Close ends the stream, withdraws a frame in flight and deletes the scene.
func (s *Session) Close(ctx context.Context) error {
	s.isClosed.Store(true)
	s.end()
	select {
	case s.busy <- struct{}{}:
		defer s.release()
	case <-ctx.Done():
		return contextError(ctx.Err())
	}
	s.drop()
	return s.withClient(ctx, func(client *Client) error { return s.deleteIfThere(ctx, client) })
}

func (s *Session) release() { <-s.busy }

func (s *Session) deleteIfThere(ctx context.Context, client *Client) error {
	if err := client.DeleteScene(ctx, s.scene.SceneId); !isNotFound(err) {
		return err
	}
	return nil
}

func isNotFound(err error) bool {
	e, _ := err.(*Error)
	return e != nil && e.Code == codes.NotFound
}

func (s *Session) repeatable(frame Frame) (*v1.Frame, error) {
	switch {
	case frame.Edit != nil:
		return nil, invalidf("frame.edit", "cannot be restored by a session; use a stream")
	case frame.FromLastFraction != nil:
		return nil, invalidf("frame.from_last_fraction", "cannot be restored by a session; use a stream")
	case frame.ID != 0:
		return nil, invalidf("frame.frame_id", "is %d; a session numbers its frames itself", frame.ID)
	}
	return frame.message(s.input.spec.PositionFormat)
}

func (s *Session) insist(ctx context.Context, frame *v1.Frame) (*Output, error) {
	s.leave(ctx)
	giveUp := time.Now().Add(s.options.GiveUp)
	for pause := firstPause; ; pause = minDuration(2*pause, longestPause) {
		output, err := s.try(ctx, frame, giveUp)
		if ctx.Err() != nil {
			s.drop() // the frame may have been applied: the next one restores
		}
		if err == nil || !s.isLoss(ctx, err) || time.Now().Add(pause).After(giveUp) {
			return output, err
		}
		s.drop()
		if err := sleep(ctx, pause); err != nil {
			return nil, err
		}
	}
}

// leave goes from a daemon that stops to another one, between two frames. Where there is none, frames are answered until it
// closes the stream, and this is tried again.
func (s *Session) leave(ctx context.Context) {
	before, scene := s.stream, s.scene
	if before == nil || time.Now().Before(s.nextLeave) {
		return
	}
	if _, isDraining := before.Draining(); !isDraining {
		return
	}
	s.nextLeave = time.Now().Add(leavePause)
	err := s.withClient(ctx, func(client *Client) error {
		stream, err := s.create(ctx, client)
		if err != nil {
			return err
		}
		limited, cancel := s.connector.limited(ctx)
		defer cancel()
		if err := s.restore(limited, stream); err != nil {
			stream.Close()
			return err
		}
		s.stream = stream
		before.Close()
		_ = client.DeleteScene(ctx, scene.SceneId) // its daemon ends
		return nil
	})
	if err != nil {
		s.scene = scene
		return
	}
	s.Recreations++
}

func (s *Session) try(ctx context.Context, frame *v1.Frame, giveUp time.Time) (*Output, error) {
	if s.stream == nil {
		limited, cancel := context.WithDeadline(ctx, giveUp)
		defer cancel()
		if err := s.reopen(limited); err != nil {
			if limited.Err() != nil && ctx.Err() == nil { // no deadline of the caller's
				err = failf(codes.Unavailable, "", "no daemon answers at %s within GiveUp, %v", s.connector.address, s.options.GiveUp)
			}
			return nil, err
		}
	}
	frame.FrameId = 0 // of the stream before
	return s.stream.detect(ctx, frame)
}

// isLoss: a refusal leaves the stream open, whatever its code.
func (s *Session) isLoss(ctx context.Context, err error) bool {
	isOpen := s.stream != nil && s.stream.Err() == nil
	return !isOpen && ctx.Err() == nil && (IsConnectionLost(err) || hasIdledOut(err))
}

// hasIdledOut: a stream that waited too long for a frame has ended, and the scene's lease runs.
func hasIdledOut(err error) bool {
	e, _ := err.(*Error)
	return e != nil && e.Code == codes.ResourceExhausted && strings.Contains(e.Quota, "max_idle_seconds")
}

func (s *Session) drop() {
	if s.stream != nil {
		s.stream.Close()
		s.stream = nil
	}
}

func (s *Session) reopen(ctx context.Context) error {
	var stream *Stream
	err := s.withClient(ctx, func(client *Client) (err error) {
		stream, err = s.resume(ctx, client)
		return err
	})
	if err != nil {
		return err
	}
	if err := s.restore(ctx, stream); err != nil {
		stream.Close()
		return err
	}
	s.Reconnects++
	s.stream = stream
	return nil
}

// resume begins the scene anew without a first frame: nobody can tell what an unanswered one has fixed.
func (s *Session) resume(ctx context.Context, client *Client) (stream *Stream, err error) {
	if s.first != nil {
		stream, err = s.find(ctx, client)
	} else {
		err = s.deleteIfThere(ctx, client)
	}
	if stream != nil || err != nil && !isNotFound(err) {
		return stream, err
	}
	if stream, err = s.create(ctx, client); err == nil {
		s.Recreations++
	}
	return stream, err
}

// find is told at once if the scene is gone, where an endpoint that is gone would be waited for; and proxies may not pass on why
// a stream was refused.
func (s *Session) find(ctx context.Context, client *Client) (*Stream, error) {
	if s.scene.Endpoint != "" {
		if _, err := client.GetScene(ctx, s.scene.SceneId); err != nil {
			return nil, err
		}
	}
	stream, err := s.attach(ctx, client, StreamOptions{ResumeToken: s.scene.ResumeToken})
	if IsConnectionLost(err) {
		if _, told := client.GetScene(ctx, s.scene.SceneId); told != nil {
			err = told
		}
	}
	return stream, err
}

func (s *Session) create(ctx context.Context, client *Client) (*Stream, error) {
	scene, err := client.createScene(ctx, s.input, s.options.Lease)
	if err != nil {
		return nil, err
	}
	s.scene = scene
	return s.attach(ctx, client, StreamOptions{})
}

// attach opens a stream within ctx. It lives as long as the session.
func (s *Session) attach(ctx context.Context, client *Client, options StreamOptions) (*Stream, error) {
	own, cancel := context.WithCancel(s.ctx)
	defer callOnceDone(ctx, cancel)()
	return client.Stream(own, s.scene, options)
}

func (s *Session) restore(ctx context.Context, stream *Stream) error {
	if s.first == nil {
		return nil
	}
	if stream.Scene().LastFrameId == 0 {
		s.first.FrameId = 0
		if _, err := stream.detect(ctx, s.first); err != nil {
			return err
		}
	}
	message, err := s.restoring()
	if err != nil {
		return err
	}
	_, err = stream.detect(ctx, message)
	return err
}

// restoring stands still, so that it costs little and meets nothing on a way that nobody went.
func (s *Session) restoring() (*v1.Frame, error) {
	restored := Frame{Updates: s.options.Restore()}
	frame, err := restored.message(s.input.spec.PositionFormat)
	if err != nil {
		return nil, err
	}
	frame.Updates = append(frame.Updates, s.unmoved(frame.Updates)...)
	switch s.input.spec.Mode {
	case DCD:
	case DCDAndCCD:
		frame.Mode = DCD
	default:
		for _, update := range frame.Updates {
			update.StartPositions = update.Positions
			if update.Rigid != nil {
				update.Rigid.StartMatrix = update.Rigid.Matrix
			}
		}
	}
	return frame, nil
}

// unmoved are rigid meshes that have not moved, as the first frame left them: the frame without an answer may have moved them.
func (s *Session) unmoved(moved []*v1.MeshUpdate) (updates []*v1.MeshUpdate) {
	named := map[uint32]bool{}
	for _, update := range moved {
		named[update.Mesh] = true
	}
	for _, update := range s.first.Updates {
		if named[update.Mesh] || s.input.spec.Meshes[update.Mesh].Motion != Rigid {
			continue
		}
		matrix := update.Rigid.GetMatrix()
		if matrix == nil {
			matrix = atRest.pack()
		}
		updates = append(updates, &v1.MeshUpdate{Mesh: update.Mesh, Rigid: &v1.RigidTransform{Matrix: matrix}})
	}
	return updates
}

var atRest = &Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}

func (s *Session) withClient(ctx context.Context, use func(*Client) error) error {
	client, err := s.connector.client(ctx)
	if err != nil {
		return err
	}
	defer client.Close()
	return use(client)
}

// callOnceDone has call called when ctx ends, unless stop has returned by then. (Go 1.21 has context.AfterFunc.)
func callOnceDone(ctx context.Context, call func()) (stop func()) {
	stopped, over := make(chan struct{}), make(chan struct{})
	go func() {
		defer close(over)
		select {
		case <-ctx.Done():
			call()
		case <-stopped:
		}
	}()
	return func() {
		close(stopped)
		<-over
	}
}

func minDuration(a, b time.Duration) time.Duration {
	if a < b {
		return a
	}
	return b
}
