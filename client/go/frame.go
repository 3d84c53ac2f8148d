package collided

import (
	"fmt"

	"google.golang.org/protobuf/proto"

	v1 "collided.invalid/client/go/v1"
)

// Frame is one step. What is not set is the scene's; proto/collided/v1/frame.proto describes each field.
type Frame struct {
	// ID is greater than the last frame's, up to 2^63 - 1. On a stream it may be 0: one more than the last one's.
	ID uint64
	// Updates are of the meshes that moved. A scene's first frame names every mesh.
	Updates []Update
	// Mode is the question of this frame in scenes of DCD_AND_CCD.
	Mode             v1.DetectionMode
	Accuracy         v1.Accuracy
	Delta            *float64
	Report           v1.Report
	IgnoreSeparating bool
	// Advance goes only as far as is certified; Done.Advanced tells how far, and MoveAlong moves your copy likewise.
	Advance bool
	// AdvanceMode is what goes its own fraction of the way, with Advance alone: the scene, or PerMesh, or PerVertex. How far each
	// went is in Output.Shortened.
	AdvanceMode v1.AdvanceMode
	// Limits has Output.Limits answered, too, with Advance alone: the contacts that limit the way.
	Limits bool
	// Trial answers and leaves the scene as it was.
	Trial bool
	// FromLastFraction begins this far along the way of the last frame, in [0, 1].
	FromLastFraction *float64
	// Edit changes what the scene is made of: EditedMesh, RemovedMesh, and pairs of meshes.
	Edit *SceneEdit
}

// Update has new positions of one mesh, or the pose of a rigid one.
type Update struct {
	// Mesh is the index in the scene's spec.
	Mesh uint32
	// Positions at t = 1, of all vertices, or of those of Indices: F32, F64 or Q16, as the scene's format is.
	Positions Positions
	// StartPositions at t = 0 (CCD), as many; nil: where the last frame ended.
	StartPositions Positions
	// Indices are strictly ascending: only these vertices change. nil: all of the mesh.
	Indices []uint32
	// Transform at t = 1 moves a rigid mesh's first positions.
	Transform *Matrix
	// StartTransform at t = 0 (CCD), with Transform; nil: where the last frame left the mesh.
	StartTransform *Matrix
}

func (f *Frame) message(format v1.PositionFormat) (*v1.Frame, error) {
	frame := &v1.Frame{
		FrameId:          f.ID,
		Mode:             f.Mode,
		Accuracy:         f.Accuracy,
		Delta:            f.Delta,
		Report:           f.Report,
		IgnoreSeparating: f.IgnoreSeparating,
		Advance:          f.Advance,
		AdvanceMode:      f.AdvanceMode,
		Limits:           f.Limits,
		Trial:            f.Trial,
		FromLastFraction: f.FromLastFraction,
	}
	if f.Edit != nil {
		frame.Edit = proto.Clone(f.Edit).(*SceneEdit)
	}
	for i, mesh := range frame.Edit.GetMeshes() {
		if err := checkText(mesh.GetSpec().GetName(), fmt.Sprintf("frame.edit.meshes[%d].spec.name", i)); err != nil {
			return nil, err
		}
	}
	for i := range f.Updates {
		update, err := f.Updates[i].message(format, fmt.Sprintf("frame.updates[%d]", i))
		if err != nil {
			return nil, err
		}
		frame.Updates = append(frame.Updates, update)
	}
	return frame, nil
}

func (u *Update) message(format v1.PositionFormat, path string) (*v1.MeshUpdate, error) {
	update := &v1.MeshUpdate{Mesh: u.Mesh}
	var err error
	if update.Positions, err = packPositions(u.Positions, format, path+".positions"); err != nil {
		return nil, err
	}
	if update.StartPositions, err = packPositions(u.StartPositions, format, path+".start_positions"); err != nil {
		return nil, err
	}
	if u.Indices != nil {
		update.Sparse = &v1.SparseIndices{Indices: packIndices(u.Indices)}
	}
	if u.Transform != nil {
		update.Rigid = &v1.RigidTransform{Matrix: u.Transform.pack(), StartMatrix: u.StartTransform.pack()}
	} else if u.StartTransform != nil {
		return nil, invalidf(path+".rigid.start_matrix", "(StartTransform) is set, which needs Transform")
	}
	return update, nil
}
