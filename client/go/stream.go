package collided

import (
	"context"
	"io"
	"sync"
	"sync/atomic"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/proto"

	"collided.invalid/client/go/internal/features"
	v1 "collided.invalid/client/go/v1"
)

// StreamOptions tell how a stream is opened.
type StreamOptions struct {
	// Window is how many frames may be in flight, up to the daemon's limit; 0: the daemon chooses.
	Window uint32
	// Delivery is whether each frame is answered, or waiting ones give way to later ones.
	Delivery v1.DeliveryPolicy
	// ResumeToken is the scene's; takes it over from a stream that may still be open.
	ResumeToken string
}

// Stream takes frames and gives outputs, in their order. Any goroutine may use it; it has a connection of its own, and reads
// answers as they come.
type Stream struct {
	call       v1.CollisionService_StreamFramesClient
	connection *grpc.ClientConn
	cancel     context.CancelFunc
	opened     *v1.StreamOpened
	maxBytes   uint64
	features   *features.Features
	deadline   time.Duration // for the first answer, and for the next one once no more frames will come
	maySkip    bool          // LATEST_WINS
	size       sceneSize     // as of the opening
	hasEdits   atomic.Bool   // the scene may have another size by now
	credits    chan struct{} // an entry for each frame that may be sent
	ended      chan struct{} // closed once err is set, and nothing is written any more
	booking    sync.Mutex    // frames go out in the order of their ids
	booked     chan *v1.StreamFramesRequest
	written    chan struct{} // closed once writeAll is over

	mutex       sync.Mutex // guards what follows
	lastID      uint64
	inFlight    []*inFlight
	ready       []*Output
	news        chan struct{} // closed, and made anew, when there is an output
	isFinishing bool
	err         error // why the stream has ended
	drainsAt    time.Time
}

// inFlight is a frame without an answer yet.
type inFlight struct {
	output *Output
	detect chan *Output // has room for the output; nil: Receive gives it
}

func openStream(ctx context.Context, connection *grpc.ClientConn, sceneID string, options StreamOptions,
	maxBytes uint64, deadline time.Duration, known *features.Features) (*Stream, error) {
	ctx, cancel := context.WithCancel(ctx)
	s := &Stream{connection: connection, cancel: cancel, maxBytes: maxBytes, deadline: deadline, features: known,
		maySkip: options.Delivery == v1.DeliveryPolicy_DELIVERY_POLICY_LATEST_WINS,
		ended:   make(chan struct{}), written: make(chan struct{}), news: make(chan struct{})}
	if err := s.open(ctx, sceneID, options); err != nil {
		s.release()
		return nil, err
	}
	s.lastID = s.Scene().LastFrameId
	s.credits = make(chan struct{}, s.Window())
	for i := uint32(0); i < s.Window(); i++ {
		s.credits <- struct{}{}
	}
	s.booked = make(chan *v1.StreamFramesRequest, s.Window())
	go s.readAll()
	go s.writeAll(ctx)
	return s, nil
}

func (s *Stream) open(ctx context.Context, sceneID string, options StreamOptions) (err error) {
	open := &v1.OpenStream{SceneId: sceneID, Window: options.Window, Delivery: options.Delivery, ResumeToken: options.ResumeToken}
	if lack := s.features.Check(open, "open"); lack != nil {
		return errorOfLack(lack)
	}
	if s.call, err = v1.NewCollisionServiceClient(s.connection).StreamFrames(ctx); err != nil {
		return errorOf(err)
	}
	// If it fails, Recv says why.
	_ = s.call.Send(&v1.StreamFramesRequest{Request: &v1.StreamFramesRequest_Open{Open: open}})
	answer, err := firstWithin(s.deadline, s.cancel, s.call.Recv)
	if err != nil {
		return err
	}
	if s.opened = answer.GetOpened(); s.opened.GetScene() == nil {
		return failf(codes.DataLoss, "", "the daemon's first answer does not open the stream")
	}
	s.size = sizeOf(s.Scene().GetSpec())
	return s.checkOpened(sceneID, options.Window)
}

// firstWithin is the first message of a call, which is cancelled if none comes in time.
func firstWithin[M any](deadline time.Duration, cancel func(), receive func() (M, error)) (M, error) {
	var isLate atomic.Bool
	timer := time.AfterFunc(deadline, func() {
		isLate.Store(true)
		cancel()
	})
	defer timer.Stop()
	message, err := receive()
	if err != nil && isLate.Load() {
		return message, failf(codes.DeadlineExceeded, "", "the daemon did not answer within %v (Options.Deadline)", deadline)
	}
	return message, errorOf(err)
}

func (s *Stream) checkOpened(sceneID string, window uint32) error {
	most := window
	if most == 0 {
		most = maxWindow
	}
	if s.opened.Window < 1 || s.opened.Window > most {
		return failf(codes.DataLoss, "", "opened.window is %d; it must be from 1 to %d", s.opened.Window, most)
	}
	if s.Scene().SceneId != sceneID {
		return failf(codes.DataLoss, "", "the daemon opened scene '%s' instead of '%s'", s.Scene().SceneId, sceneID)
	}
	return nil
}

// Scene is as of the opening: LastFrameId is the last frame that was applied before this stream.
func (s *Stream) Scene() *Scene { return s.opened.Scene }

// Window is how many frames may be in flight.
func (s *Stream) Window() uint32 { return s.opened.Window }

// Draining tells whether the daemon is stopping, and how long until it closes the stream.
func (s *Stream) Draining() (left time.Duration, isDraining bool) {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	if s.drainsAt.IsZero() {
		return 0, false
	}
	if left = time.Until(s.drainsAt); left < 0 {
		left = 0
	}
	return left, true
}

// Err is why the stream has ended; nil while it has not.
func (s *Stream) Err() error {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	return s.err
}

// Send waits until fewer frames than the window are in flight, then has the frame sent, and returns its id. Receive has its
// output. The frame's slices may change once Send has returned.
func (s *Stream) Send(ctx context.Context, frame Frame) (uint64, error) {
	message, err := frame.message(s.Scene().GetSpec().GetPositionFormat())
	if err != nil {
		return 0, err
	}
	return s.post(ctx, message, nil)
}

// Detect sends a frame and waits for its output. It fails if the frame is refused; the stream goes on. A frame whose context
// ends once fewer than the window are in flight is applied all the same.
func (s *Stream) Detect(ctx context.Context, frame Frame) (*Output, error) {
	message, err := frame.message(s.Scene().GetSpec().GetPositionFormat())
	if err != nil {
		return nil, err
	}
	return s.detect(ctx, message)
}

func (s *Stream) detect(ctx context.Context, frame *v1.Frame) (*Output, error) {
	answer := make(chan *Output, 1)
	if _, err := s.post(ctx, frame, answer); err != nil {
		return nil, err
	}
	select {
	case output := <-answer:
		return output, output.Err
	case <-ctx.Done():
		return nil, contextError(ctx.Err())
	case <-s.ended:
	}
	select {
	case output := <-answer: // it was the last one
		return output, output.Err
	default:
		return nil, s.Err()
	}
}

// Receive waits for the next output of Send. It fails once the stream has ended, or ctx has. Output.Err is of a frame that was
// refused.
func (s *Stream) Receive(ctx context.Context) (*Output, error) {
	for {
		s.mutex.Lock()
		if len(s.ready) > 0 {
			output := s.ready[0]
			s.ready = s.ready[1:]
			s.mutex.Unlock()
			return output, nil
		}
		err, news := s.err, s.news
		s.mutex.Unlock()
		if err != nil {
			return nil, err
		}
		select {
		case <-news:
		case <-s.ended:
		case <-ctx.Done():
			return nil, contextError(ctx.Err())
		}
	}
}

// Finish tells the daemon that no more frames will come, and waits until all are answered. Outputs can still be received.
// DeadlineExceeded if none is answered, and the stream does not end, for as long as a call may take.
func (s *Stream) Finish(ctx context.Context) error {
	s.bookNoMore()
	for left, isOver := s.countInFlight(), false; !isOver; {
		timer := time.NewTimer(s.deadline)
		defer timer.Stop()
		select {
		case <-s.ended:
			isOver = true
		case <-ctx.Done():
			return contextError(ctx.Err())
		case <-timer.C:
			now := s.countInFlight()
			if now >= left {
				s.Close()
				return failf(codes.DeadlineExceeded, "", "the daemon did not end the stream within %v (Options.Deadline)", s.deadline)
			}
			left = now
		}
	}
	if err := s.Err(); err != errFinished {
		return err
	}
	return nil
}

func (s *Stream) countInFlight() int {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	return len(s.inFlight)
}

func (s *Stream) bookNoMore() {
	s.booking.Lock()
	defer s.booking.Unlock()
	s.mutex.Lock()
	defer s.mutex.Unlock()
	if !s.isFinishing {
		s.isFinishing = true
		close(s.booked)
	}
}

// Close ends the stream; frames in flight are withdrawn.
func (s *Stream) Close() {
	s.cancel()
	<-s.ended
}

var errFinished error = failf(codes.FailedPrecondition, "", "the stream has ended, as Finish asked for")

// post sends a frame. answer: where its output goes; nil: to Receive.
func (s *Stream) post(ctx context.Context, frame *v1.Frame, answer chan *Output) (uint64, error) {
	if lack := s.features.Check(frame, "frame"); lack != nil {
		return 0, errorOfLack(lack)
	}
	if err := s.takeCredit(ctx); err != nil {
		return 0, err
	}
	s.booking.Lock()
	defer s.booking.Unlock()
	request := &v1.StreamFramesRequest{Request: &v1.StreamFramesRequest_Frame{Frame: frame}}
	if err := s.book(request, answer); err != nil {
		s.credits <- struct{}{}
		return 0, err
	}
	select {
	case s.booked <- request: // there is room, unless the daemon answers what it cannot have received
		return frame.FrameId, nil
	case <-s.ended:
		return 0, s.Err()
	}
}

// writeAll is a goroutine of its own, as gRPC waits, whatever the context of a frame, for a daemon that does not read.
func (s *Stream) writeAll(ctx context.Context) {
	defer close(s.written)
	for {
		select {
		case request, isMore := <-s.booked:
			if !isMore {
				_ = s.call.CloseSend()
				return
			}
			if s.call.Send(request) != nil {
				return // readAll is told why
			}
		case <-ctx.Done():
			return
		}
	}
}

func (s *Stream) takeCredit(ctx context.Context) error {
	if ctx.Err() != nil {
		return contextError(ctx.Err())
	}
	select {
	case <-s.credits:
		return nil
	case <-s.ended:
		return s.Err()
	case <-ctx.Done():
		return contextError(ctx.Err())
	}
}

// book gives the frame an id if it has none, and expects its answer.
func (s *Stream) book(request *v1.StreamFramesRequest, answer chan *Output) error {
	frame := request.GetFrame()
	s.mutex.Lock()
	defer s.mutex.Unlock()
	if s.err != nil {
		return s.err
	}
	if s.isFinishing {
		return errFinished
	}
	if frame.FrameId == 0 {
		frame.FrameId = s.lastID + 1
	}
	if bytes := uint64(proto.Size(request)); bytes > s.maxBytes {
		return failf(codes.ResourceExhausted, "frame", "frame is %d bytes; the daemon's limit is %d (--max-message-mb)",
			bytes, s.maxBytes)
	}
	if frame.Edit != nil {
		s.hasEdits.Store(true)
	}
	if frame.FrameId > s.lastID { // else it is refused
		s.lastID = frame.FrameId
	}
	s.inFlight = append(s.inFlight, &inFlight{newOutput(frame), answer})
	return nil
}

// readAll reads until the stream ends. An answer that contradicts itself ends it: what follows cannot be trusted.
func (s *Stream) readAll() {
	for {
		response, err := s.call.Recv()
		if err == nil {
			if err = s.take(response); err == nil {
				continue
			}
		}
		s.release()
		<-s.written
		s.conclude(err)
		return
	}
}

func (s *Stream) release() {
	s.cancel()
	s.connection.Close()
}

func (s *Stream) conclude(err error) {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	switch {
	case err != io.EOF:
		s.err = errorOf(err)
	case s.isFinishing:
		s.err = errFinished
	default:
		s.err = failf(codes.Unavailable, "", "the stream has ended")
	}
	close(s.ended)
}

func (s *Stream) take(response *v1.StreamFramesResponse) error {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	if draining := response.GetDraining(); draining != nil {
		s.drainsAt = time.Now().Add(time.Duration(draining.DeadlineSeconds * float64(time.Second)))
		return nil
	}
	if response.Response == nil {
		return nil // of a later version
	}
	if len(s.inFlight) == 0 || s.inFlight[0].output.FrameID != response.FrameId {
		return failf(codes.DataLoss, "", "an answer is of frame %d, which is not the oldest in flight", response.FrameId)
	}
	output := s.inFlight[0].output
	switch answer := response.Response.(type) {
	case *v1.StreamFramesResponse_Contacts:
		return output.add(fieldContacts, answer.Contacts)
	case *v1.StreamFramesResponse_Limits:
		return output.addLimits(answer.Limits)
	case *v1.StreamFramesResponse_Shortened:
		return output.Shortened.add(answer.Shortened)
	case *v1.StreamFramesResponse_Pairs:
		return output.addPairs(answer.Pairs)
	case *v1.StreamFramesResponse_Done:
		if err := s.finishFrame(output, answer.Done); err != nil {
			return err
		}
	case *v1.StreamFramesResponse_Error:
		output.Err = errorOfFrame(answer.Error)
	case *v1.StreamFramesResponse_Skipped:
		if !s.maySkip {
			return failf(codes.DataLoss, "", "the daemon skipped frame %d of a stream that answers each one", response.FrameId)
		}
		output.Skipped = true
	default:
		return failf(codes.DataLoss, "", "the answer of frame %d is %T", response.FrameId, answer)
	}
	s.complete()
	return nil
}

func (s *Stream) finishFrame(output *Output, done *v1.FrameDone) error {
	if err := output.finish(done); err != nil {
		return err
	}
	if err := output.checkTotal(); err != nil || s.hasEdits.Load() {
		return err
	}
	return output.checkIDs(s.size)
}

// complete gives the oldest output to whom it belongs. The mutex is held.
func (s *Stream) complete() {
	oldest := s.inFlight[0]
	s.inFlight = s.inFlight[1:]
	s.credits <- struct{}{} // there is room: one was taken for the frame
	if oldest.detect != nil {
		oldest.detect <- oldest.output
		return
	}
	s.ready = append(s.ready, oldest.output)
	close(s.news)
	s.news = make(chan struct{})
}
