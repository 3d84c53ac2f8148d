package collided

import v1 "collided.invalid/client/go/v1"

// Short names of messages and values that are used most; package v1 has all of them, and says what they mean.
type (
	SceneSpec       = v1.SceneSpec
	Scene           = v1.Scene
	SceneEdit       = v1.SceneEdit
	MeshPair        = v1.MeshPair
	QuantizationBox = v1.QuantizationBox
)

// Values of SceneSpec.Mode and Frame.Mode.
const (
	DCD       = v1.DetectionMode_DETECTION_MODE_DCD
	CCD       = v1.DetectionMode_DETECTION_MODE_CCD
	DCDAndCCD = v1.DetectionMode_DETECTION_MODE_DCD_AND_CCD
)

// Values of SceneSpec.PositionFormat.
const (
	FormatF32 = v1.PositionFormat_POSITION_FORMAT_F32
	FormatF64 = v1.PositionFormat_POSITION_FORMAT_F64
	FormatQ16 = v1.PositionFormat_POSITION_FORMAT_Q16
)

// Values of Mesh.Motion.
const (
	Deformable = v1.MeshMotion_MESH_MOTION_DEFORMABLE
	Static     = v1.MeshMotion_MESH_MOTION_STATIC
	Rigid      = v1.MeshMotion_MESH_MOTION_RIGID
)

// Values of SceneSpec.Accuracy and Frame.Accuracy.
const (
	Candidates = v1.Accuracy_ACCURACY_CANDIDATES
	Fast       = v1.Accuracy_ACCURACY_FAST
	Guarded    = v1.Accuracy_ACCURACY_GUARDED
	Certified  = v1.Accuracy_ACCURACY_CERTIFIED
	Exact      = v1.Accuracy_ACCURACY_EXACT
)

// Values of SceneSpec.Report and Frame.Report.
const (
	ReportAll          = v1.Report_REPORT_ALL
	ReportEarliestOnly = v1.Report_REPORT_EARLIEST_ONLY
	ReportAnyHit       = v1.Report_REPORT_ANY_HIT
)

// Values of Frame.AdvanceMode.
const (
	AllOrOne  = v1.AdvanceMode_ADVANCE_MODE_ALL_OR_ONE
	PerMesh   = v1.AdvanceMode_ADVANCE_MODE_PER_MESH
	PerVertex = v1.AdvanceMode_ADVANCE_MODE_PER_VERTEX
)

// Values of SceneSpec.Kinds.
const (
	VertexTriangle   = v1.ContactKind_CONTACT_KIND_VERTEX_TRIANGLE
	EdgeEdge         = v1.ContactKind_CONTACT_KIND_EDGE_EDGE
	TriangleTriangle = v1.ContactKind_CONTACT_KIND_TRIANGLE_TRIANGLE
	EdgeTriangle     = v1.ContactKind_CONTACT_KIND_EDGE_TRIANGLE
	VertexSolid      = v1.ContactKind_CONTACT_KIND_VERTEX_SOLID
)

// Values of SceneSpec.Fields.
const (
	FieldElements       = v1.ContactField_CONTACT_FIELD_ELEMENTS
	FieldStencil        = v1.ContactField_CONTACT_FIELD_STENCIL
	FieldTOI            = v1.ContactField_CONTACT_FIELD_TOI
	FieldDistance       = v1.ContactField_CONTACT_FIELD_DISTANCE
	FieldWeights        = v1.ContactField_CONTACT_FIELD_WEIGHTS
	FieldNormal         = v1.ContactField_CONTACT_FIELD_NORMAL
	FieldFlags          = v1.ContactField_CONTACT_FIELD_FLAGS
	FieldFeatures       = v1.ContactField_CONTACT_FIELD_FEATURES
	FieldPairStates     = v1.ContactField_CONTACT_FIELD_PAIR_STATES
	FieldSignedDistance = v1.ContactField_CONTACT_FIELD_SIGNED_DISTANCE
)

// Values of PairOfMeshes.State.
const (
	PairTouching     = v1.MeshPairState_MESH_PAIR_STATE_TOUCHING
	PairOverlapping  = v1.MeshPairState_MESH_PAIR_STATE_OVERLAPPING
	PairFirstInside  = v1.MeshPairState_MESH_PAIR_STATE_FIRST_INSIDE
	PairSecondInside = v1.MeshPairState_MESH_PAIR_STATE_SECOND_INSIDE
)

// Masks of Contacts.Flags: contacts.Flags[i]&collided.IsInitial != 0.
const (
	IsCertified  = byte(v1.ContactFlag_CONTACT_FLAG_CERTIFIED)
	IsNear       = byte(v1.ContactFlag_CONTACT_FLAG_NEAR)
	IsCapped     = byte(v1.ContactFlag_CONTACT_FLAG_CAPPED)
	IsInitial    = byte(v1.ContactFlag_CONTACT_FLAG_INITIAL)
	IsSeparating = byte(v1.ContactFlag_CONTACT_FLAG_SEPARATING)
	IsCovered    = byte(v1.ContactFlag_CONTACT_FLAG_COVERED)
	IsTouching   = byte(v1.ContactFlag_CONTACT_FLAG_TOUCHING)
)

// Values of StreamOptions.Delivery.
const (
	Lossless   = v1.DeliveryPolicy_DELIVERY_POLICY_LOSSLESS
	LatestWins = v1.DeliveryPolicy_DELIVERY_POLICY_LATEST_WINS
)
