package collided

import (
	"context"
	"strings"
	"sync"
	"time"

	"google.golang.org/grpc/codes"

	v1 "collided/client/go/v1"
)

const (
	firstPause   = 50 * time.Millisecond
	longestPause = 2 * time.Second
	leavePause   = time.Second
)

// SessionOptions tell how a session is opened.
type SessionOptions struct {
	// Restore tells where the meshes are before the frame that is being sent: positions of every deformable mesh, the
	// transform of every rigid one that has moved. Called after a loss only. With Advance that is where MoveAlong has them.
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
	ctx       context.Context
	connector *connector
	input     *sceneInput
	options   SessionOptions
	busy      sync.Mutex
	scene     *Scene
	stream    *Stream   // nil: lost
	first     *v1.Frame // the scene's, which fixes static and rigid meshes and what is at rest
	nextLeave time.Time // when leaving a daemon that stops is tried
	isClosed  bool

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
	s := &Session{ctx: ctx, connector: connector, input: input, options: options}
	err := s.withClient(ctx, func(client *Client) (err error) {
		s.stream, err = s.create(ctx, client)
		return err
	})
	if err != nil {
		return nil, err
	}
	return s, nil
}

// Scene is as it was created last.
func (s *Session) Scene() *Scene { return s.scene }

// Detect sends a frame and waits for its output, over as many connections as it takes. It fails if the frame is refused, if
// there is no connection for GiveUp, once ctx ends, and for frames that depend on more than positions: Edit, FromLastFraction.
func (s *Session) Detect(ctx context.Context, frame Frame) (*Output, error) {
	if !s.busy.TryLock() {
		return nil, failf(codes.FailedPrecondition, "", "Detect was called before its last call was over")
	}
	defer s.busy.Unlock()
	if s.isClosed {
		return nil, failf(codes.FailedPrecondition, "", "the session is closed")
	}
	message, err := s.repeatable(frame)
	if err != nil {
		return nil, err
	}
	output, err := s.insist(ctx, message)
	if err == nil && s.first == nil && !message.Trial {
		s.first = message
	}
	return output, err
}

// Close waits for a Detect to be over, ends the stream and deletes the scene.
func (s *Session) Close(ctx context.Context) error {
	s.busy.Lock()
	defer s.busy.Unlock()
	s.isClosed = true
	s.drop()
	return s.withClient(ctx, func(client *Client) error { return s.deleteIfThere(ctx, client) })
}

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
		if err := s.restore(ctx, stream); err != nil {
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
			return nil, err
		}
	}
	frame.FrameId = 0 // of the stream before
	return s.stream.detect(ctx, frame)
}

// isLoss: a refusal leaves the stream open, whatever its code.
func (s *Session) isLoss(ctx context.Context, err error) bool {
	isOpen := s.stream != nil && s.stream.Err() == nil
	return !isOpen && ctx.Err() == nil && s.ctx.Err() == nil && (IsConnectionLost(err) || hasIdledOut(err))
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
	stream, err := client.Resume(s.ctx, s.scene, StreamOptions{})
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
	return client.Stream(s.ctx, scene, StreamOptions{})
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
	_, err := stream.Detect(ctx, s.restoring())
	return err
}

// restoring stands still, so that it costs little and meets nothing on a way that nobody went.
func (s *Session) restoring() Frame {
	frame := Frame{Updates: append([]Update(nil), s.options.Restore()...)}
	switch s.input.spec.Mode {
	case DCD:
	case DCDAndCCD:
		frame.Mode = DCD
	default:
		for i := range frame.Updates {
			update := &frame.Updates[i]
			update.StartPositions, update.StartTransform = update.Positions, update.Transform
		}
	}
	return frame
}

func (s *Session) withClient(ctx context.Context, use func(*Client) error) error {
	client, err := s.connector.client(ctx)
	if err != nil {
		return err
	}
	defer client.Close()
	return use(client)
}

func minDuration(a, b time.Duration) time.Duration {
	if a < b {
		return a
	}
	return b
}
