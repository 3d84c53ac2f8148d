package collided

import (
	"context"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"

	"collided.invalid/client/go/internal/features"
	v1 "collided.invalid/client/go/v1"
)

// WatchOptions tell what a watcher sees, and how often. The daemon checks them.
type WatchOptions struct {
	// FrameInterval shows every so many frames; 0: every one.
	FrameInterval uint32
	// MaxFramesPerSecond; 0: as many as are read.
	MaxFramesPerSecond float64
	// MaxContactsPerKind shows the first in canonical order; 0: only their numbers.
	MaxContactsPerKind uint32
	// PositionMeshes are indices of the meshes whose positions are sent.
	PositionMeshes []uint32
	// VertexStride: positions of every so many vertices; 0: as many as fit in a message.
	VertexStride uint32
}

// SampledPositions are those of vertices 0, VertexStride, 2 VertexStride and so on of a mesh after a frame.
type SampledPositions struct {
	Mesh, VertexStride uint32
	// Positions are F64 if the scene's are, else F32.
	Positions Positions
}

// WatchedFrame is a frame. Of its contacts it has at most those that the options ask for; Done has the frame's own totals.
type WatchedFrame struct {
	Output
	// SkippedFrames were not shown since the last one.
	SkippedFrames uint64
	// OmittedContacts are those that the frame has besides these.
	OmittedContacts uint64
	// EditCount is of the scene's edits so far: where it has risen, GetScene tells what the scene is made of.
	EditCount uint64
	// Positions has one entry for each of PositionMeshes.
	Positions []SampledPositions
}

// Watcher shows the frames that others send to a scene. One goroutine reads; any may close.
type Watcher struct {
	call       v1.CollisionService_WatchSceneClient
	connection *grpc.ClientConn
	cancel     context.CancelFunc
	opened     *v1.WatchOpened
}

func openWatcher(ctx context.Context, connection *grpc.ClientConn, sceneID string, options WatchOptions,
	deadline time.Duration, known *features.Features) (*Watcher, error) {
	ctx, cancel := context.WithCancel(ctx)
	w := &Watcher{connection: connection, cancel: cancel}
	request := &v1.WatchSceneRequest{
		SceneId:            sceneID,
		FrameInterval:      options.FrameInterval,
		MaxFramesPerSecond: options.MaxFramesPerSecond,
		MaxContactsPerKind: options.MaxContactsPerKind,
		PositionMeshes:     options.PositionMeshes,
		VertexStride:       options.VertexStride,
	}
	if lack := known.CheckCall(request); lack != nil {
		w.Close()
		return nil, errorOfLack(lack)
	}
	var err error
	if w.call, err = v1.NewCollisionServiceClient(connection).WatchScene(ctx, request); err == nil {
		err = w.open(deadline)
	}
	if err != nil {
		w.Close()
		return nil, errorOf(err)
	}
	return w, nil
}

func (w *Watcher) open(deadline time.Duration) error {
	first, err := firstWithin(deadline, w.cancel, w.call.Recv)
	if err != nil {
		return err
	}
	if w.opened = first.GetOpened(); w.opened.GetScene() == nil {
		return failf(codes.DataLoss, "", "the first message of a watch is not `opened`")
	}
	return nil
}

// Scene is as of the opening, without triangles.
func (w *Watcher) Scene() *Scene { return w.opened.Scene }

// VertexStride is of all positions; 0 if none were asked for.
func (w *Watcher) VertexStride() uint32 { return w.opened.VertexStride }

// Receive waits for the next frame. It fails once the watch has ended: NotFound if the scene is gone, Canceled after Close.
func (w *Watcher) Receive() (*WatchedFrame, error) {
	response, err := w.call.Recv()
	if err != nil {
		return nil, errorOf(err)
	}
	done := response.GetDone()
	if done == nil {
		return nil, failf(codes.DataLoss, "", "a message of the watch is no frame")
	}
	frame := &WatchedFrame{
		SkippedFrames:   response.SkippedFrames,
		OmittedContacts: response.OmittedContacts,
		EditCount:       response.EditCount,
	}
	for _, sample := range response.Positions {
		if err := w.checkSample(sample); err != nil && response.EditCount == w.Scene().EditCount {
			return nil, err
		}
		positions := unpackPositions(sample.Positions, w.Scene().GetSpec().GetPositionFormat())
		frame.Positions = append(frame.Positions, SampledPositions{sample.Mesh, sample.VertexStride, positions})
	}
	frame.FrameID = response.FrameId
	if err := frame.finish(done); err != nil {
		return nil, err
	}
	if response.EditCount != w.Scene().EditCount {
		return frame, nil // the scene may have another size by now
	}
	return frame, frame.checkIDs(sizeOf(w.Scene().GetSpec()))
}

func (w *Watcher) checkSample(sample *v1.VertexSample) error {
	width, meshes := shownBytes(w.Scene().GetSpec().GetPositionFormat()), len(w.Scene().GetSpec().GetMeshes())
	if len(sample.Positions)%width != 0 || int64(sample.Mesh) >= int64(meshes) {
		return failf(codes.DataLoss, "", "positions of mesh %d has %d bytes; the scene has %d meshes, of %d bytes for a vertex",
			sample.Mesh, len(sample.Positions), meshes, width)
	}
	return nil
}

// Close ends the watch.
func (w *Watcher) Close() {
	w.cancel()
	w.connection.Close()
}
