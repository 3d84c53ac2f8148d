/* The collision engine in the process, for C and for every language that calls C.
 *
 *   collided_scene_spec spec = {.struct_size = sizeof spec};
 *   ... spec.meshes, spec.mesh_count ...
 *   collided_scene* scene;
 *   if (collided_scene_create(&spec, &scene) != COLLIDED_OK) puts(collided_error_message());
 *   for each frame:
 *     collided_result* result;
 *     collided_detect(scene, &frame, &result);
 *     collided_result_contacts(result, COLLIDED_VERTEX_TRIANGLE, &contacts);
 *     collided_result_free(result);
 *   collided_scene_free(scene);
 *
 * No daemon runs and nothing is sent. Contacts are the same bytes as a daemon's for the same input.
 *
 * Structures. The first member of each is its size in bytes as the program was compiled: set it to sizeof. All other
 * members may be 0, which is the default. In an array all elements have the same struct_size. A later version of the
 * library adds members at the end only, so a program need not be compiled again for it. An older library accepts a
 * newer program's structure if the members that it does not know are 0, and else refuses it with
 * COLLIDED_UNIMPLEMENTED.
 *
 * Ownership. The library copies what it is given before a call returns. Arrays that it hands out belong to the scene or
 * result they come from, and are valid until that is freed. A result may outlive its scene.
 *
 * Threads. Calls for different scenes may run at once. A second call for a scene that is busy is refused with
 * COLLIDED_FAILED_PRECONDITION. A scene or result must not be freed while another call uses it. Scenes do not survive
 * fork(): a child process makes its own. The thread's current CUDA device is the same after a call as before it.
 *
 * Errors. Every function that can fail returns a collided_status. Unless it is COLLIDED_OK, nothing has changed, the
 * scene remains usable, and collided_error_message() says what was wrong, with field, value and limit. No C++ exception
 * leaves the library. A null pointer where one is needed is refused. Arrays must have as many entries as their counts
 * say: that is the one thing that the library cannot check.
 *
 * Lengths are in the unit of the positions. Numbers are in the byte order of the host, which must be little-endian.
 */
#ifndef COLLIDED_H_
#define COLLIDED_H_

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define COLLIDED_API __attribute__((visibility("default")))
#else
#define COLLIDED_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. It changes when a program has to be compiled again; the library's soname is the same
 * number. */
#define COLLIDED_ABI_VERSION 1
COLLIDED_API uint32_t collided_abi_version(void);
/* Release of the library, such as "0.1.0". */
COLLIDED_API const char* collided_version(void);

/* Outcome of a call; the numbers are those of gRPC. */
typedef int32_t collided_status;
enum {
  COLLIDED_OK = 0,
  COLLIDED_CANCELLED = 1,           /* collided_frame.cancelled returned a value other than 0 */
  COLLIDED_INVALID_ARGUMENT = 3,    /* a value cannot be used; collided_error_field() names it */
  COLLIDED_RESOURCE_EXHAUSTED = 8,  /* memory of the host or device, or the scene's memory_budget, is not enough */
  COLLIDED_FAILED_PRECONDITION = 9, /* the call does not fit the state: the scene is busy, or had no frame yet */
  COLLIDED_UNIMPLEMENTED = 12,      /* a structure has a member that this version of the library does not know */
  COLLIDED_INTERNAL = 13,           /* a bug */
  COLLIDED_UNAVAILABLE = 14 /* there is no CUDA device, or it has failed and its scenes cannot be used any more */
};

/* Of the last call on this thread that failed; empty before the first. Valid until the next call that fails on this
 * thread. */
COLLIDED_API const char* collided_error_message(void);
/* The member at fault, such as "thickness" or "updates[1].end"; empty if it is none. */
COLLIDED_API const char* collided_error_field(void);

/* ---- Devices ---- */

typedef struct collided_device_info {
  size_t struct_size;
  char id[16];           /* "cpu:0", "cuda:0": what collided_scene_spec.device takes */
  char name[128];        /* for people, cut if it is longer */
  uint64_t memory_bytes; /* 0 for the CPU */
} collided_device_info;

/* Number of devices that can be used now: the CPU, then CUDA devices. */
COLLIDED_API collided_status collided_device_count(uint32_t* count);
/* index: 0 to count - 1. */
COLLIDED_API collided_status collided_device(uint32_t index, collided_device_info* info);

/* ---- Scenes ---- */

/* collided_scene_spec.mode, collided_frame.mode. */
enum {
  COLLIDED_MODE_DEFAULT = 0, /* of a scene CCD; of a frame its scene's, and CCD in a scene of both */
  COLLIDED_DCD = 1,          /* features that are at most `thickness` apart at the frame's end */
  COLLIDED_CCD = 2,          /* features that meet on the way from the last frame's end to this one's */
  COLLIDED_DCD_AND_CCD = 3   /* each frame chooses; of a scene only */
};

enum {
  COLLIDED_ACCURACY_DEFAULT = 0, /* of a scene CERTIFIED; of a frame its scene's */
  COLLIDED_CANDIDATES = 1,       /* pairs of features whose boxes overlap; no narrow phase */
  COLLIDED_FAST = 2,             /* working precision, no guarantee */
  COLLIDED_GUARDED = 3,          /* no contact is missed and no time of impact is late; computed in float */
  COLLIDED_CERTIFIED = 4,        /* as GUARDED, in double where float cannot decide */
  COLLIDED_EXACT = 5             /* contacts are those of real arithmetic, no more and no less */
};

enum {
  COLLIDED_REPORT_DEFAULT = 0, /* of a scene ALL; of a frame its scene's */
  COLLIDED_REPORT_ALL = 1,
  COLLIDED_REPORT_EARLIEST_ONLY = 2, /* CCD from GUARDED on */
  COLLIDED_REPORT_ANY_HIT = 3        /* from FAST on; no contacts are listed */
};

enum {
  COLLIDED_F32 = 1, /* float[3] per vertex; the default */
  COLLIDED_F64 = 2, /* double[3] per vertex, used in full */
  COLLIDED_Q16 = 3  /* uint16_t[3] per vertex: fixed point in quantized_in */
};

enum {
  COLLIDED_DEFORMABLE = 1, /* any vertex may move in any frame; the default */
  COLLIDED_STATIC = 2,     /* positions come with the first frame alone */
  COLLIDED_RIGID = 3       /* positions come with the first frame; later frames bring transforms of those */
};

/* Broad phase; all find the same pairs. 0: the library chooses by measured times. */
enum {
  COLLIDED_OCTREE = 1,
  COLLIDED_TOP_DOWN_OCTREE = 2,
  COLLIDED_BOTTOM_UP_OCTREE = 3,
  COLLIDED_UNIFORM_GRID = 4,
  COLLIDED_TWO_LEVEL_GRID = 5,
  COLLIDED_LBVH = 6,
  COLLIDED_VSS = 7,
  COLLIDED_ALL_PAIRS = 8
};

/* Reuse of candidate lists from frame to frame. 0: where it is faster. */
enum { COLLIDED_REUSE_ON = 1, COLLIDED_REUSE_OFF = 2 };

/* collided_frame.advance_mode: what goes its own fraction of the way. */
enum {
  COLLIDED_ADVANCE_ALL_OR_ONE = 1, /* the scene; the default */
  COLLIDED_ADVANCE_PER_MESH = 2,   /* each mesh */
  COLLIDED_ADVANCE_PER_VERTEX = 3  /* each vertex; rigid meshes go as a whole */
};

/* Kinds of contacts. */
enum {
  COLLIDED_VERTEX_TRIANGLE = 1,
  COLLIDED_EDGE_EDGE = 2,
  COLLIDED_TRIANGLE_TRIANGLE = 3,
  COLLIDED_EDGE_TRIANGLE = 4, /* an edge goes through a triangle: in frames of DCD alone, not with Q16 or CANDIDATES */
  COLLIDED_VERTEX_SOLID = 5   /* a vertex inside another mesh, a solid, and the triangle there that is nearest to it:
                                 likewise */
};
/* Masks of collided_scene_spec.kinds: 1 << (kind - 1). 0: the first two. */
enum {
  COLLIDED_KINDS_VERTEX_TRIANGLE = 1,
  COLLIDED_KINDS_EDGE_EDGE = 2,
  COLLIDED_KINDS_TRIANGLE_TRIANGLE = 4,
  COLLIDED_KINDS_EDGE_TRIANGLE = 8,
  COLLIDED_KINDS_VERTEX_SOLID = 16 /* needs a solid */
};

/* Masks of collided_scene_spec.fields. 0: all but WEIGHTS, NORMALS, FEATURES and those after it. */
enum {
  COLLIDED_FIELDS_ELEMENTS = 1,
  COLLIDED_FIELDS_STENCILS = 2,
  COLLIDED_FIELDS_TOI = 4,
  COLLIDED_FIELDS_DISTANCE = 8,
  COLLIDED_FIELDS_WEIGHTS = 16,
  COLLIDED_FIELDS_NORMALS = 32,
  COLLIDED_FIELDS_FLAGS = 64,
  COLLIDED_FIELDS_FEATURES = 128, /* with it frames of DCD also have FLAG_COVERED, and normals where surfaces touch */
  COLLIDED_FIELDS_SIGNED_DISTANCE = 256,
  COLLIDED_FIELDS_PAIR_STATES = 512 /* of pairs of meshes, for collided_result_mesh_pair; needs a solid and DCD */
};

/* One mesh. It has one element or more, of any kinds. Vertices are numbered within the mesh. */
typedef struct collided_mesh {
  size_t struct_size;
  const uint32_t* triangles; /* [triangle_count][3] */
  const uint32_t* edges;     /* [edge_count][2]: loose ones, of no triangle, such as the segments of a hair */
  const uint32_t* points;    /* [point_count]: loose ones, such as particles */
  uint64_t triangle_count;
  uint64_t edge_count;
  uint64_t point_count;
  uint32_t vertex_count; /* 1 or more */
  int32_t motion;        /* COLLIDED_DEFORMABLE ... */
  uint32_t groups;       /* bits of the groups that the mesh is in; 0: 1 */
  uint32_t collide_mask; /* bits of the groups that it can touch; 0: all */
  int32_t no_self_contacts;
  uint32_t excluded_rings;     /* 0 to 8: leave out self contacts of features that so many edges or fewer connect */
  int32_t excludes_rest_pairs; /* leave out self contacts of features within rest_distance in the first frame */
  int32_t reserved;            /* 0 */
  double half_thickness;       /* >= 0, finite: two meshes are in contact up to thickness and both halves, a mesh and
                                  itself up to thickness and twice its half */
  int32_t solid; /* it bounds a volume: of triangles alone, each edge used as often in one direction as in the other,
                    and normals outwards */
  int32_t reserved2; /* 0 */
} collided_mesh;

typedef struct collided_scene_spec {
  size_t struct_size;
  const collided_mesh* meshes; /* [mesh_count], 1 or more; the array's stride is meshes[0].struct_size */
  uint64_t mesh_count;
  const uint32_t* excluded_meshes; /* [excluded_mesh_count][2]: pairs of meshes that never touch, each once */
  uint64_t excluded_mesh_count;
  const char* device; /* "cpu", "cuda", "cuda:1"; null or "auto": the first CUDA device, or the CPU if there is none */
  int32_t mode;       /* COLLIDED_CCD ... */
  int32_t accuracy;   /* COLLIDED_CERTIFIED ... */
  int32_t report;     /* COLLIDED_REPORT_ALL ... */
  int32_t position_format;    /* COLLIDED_F32 ... */
  int32_t broad_phase_engine; /* COLLIDED_OCTREE ... */
  int32_t reuse;              /* COLLIDED_REUSE_ON ... */
  uint32_t kinds;             /* masks COLLIDED_KINDS_... */
  uint32_t fields;            /* masks COLLIDED_FIELDS_...: what is left out is not computed */
  double thickness;           /* DCD: contact distance, >= 0, finite */
  double delta;               /* CCD from GUARDED on: tolerance, >= 0, finite; 0: relative to each pair's size */
  double min_separation;      /* CCD: distance that frames with `advance` keep, >= 0, finite */
  double rest_distance;       /* of excludes_rest_pairs, >= 0, finite; 0: each mesh's own contact distance */
  const double* quantized_in; /* [6] of Q16: lower x y z, upper x y z, finite, lower <= upper; else null */
  uint64_t memory_budget;     /* bytes on the device; 0: no limit but the device's */
  uint64_t expected_contacts; /* of a frame, below 2^32: memory is reserved for so many; 0: for few */
  int32_t threads;            /* CPU threads, 0 to 4096; 0: all cores */
  int32_t reserved;           /* 0 */
} collided_scene_spec;

typedef struct collided_scene collided_scene;

/* Sets *scene, to be freed by collided_scene_free; to null if it fails. */
COLLIDED_API collided_status collided_scene_create(const collided_scene_spec* spec, collided_scene** scene);
/* scene: may be null. */
COLLIDED_API void collided_scene_free(collided_scene* scene);

/* How the scene numbers its features: vertices and elements of each mesh follow those of the meshes before it. */
typedef struct collided_topology {
  size_t struct_size;
  const uint32_t* elements;       /* [element_count][3]: of each mesh its triangles, then its loose edges as a b b, then
                                     its loose points as a a a; scene-wide vertices */
  const uint32_t* edges;          /* [edge_count][2], lower vertex first, sorted */
  const uint32_t* vertex_offsets; /* [mesh_count + 1]: the first vertex of each mesh */
  const uint32_t* element_offsets; /* [mesh_count + 1]: the first element of each mesh */
  uint64_t vertex_count;
  uint64_t element_count;
  uint64_t edge_count;
  uint64_t mesh_count;
} collided_topology;

COLLIDED_API collided_status collided_scene_topology(collided_scene* scene, collided_topology* topology);
/* Bytes that the scene holds on its device and, for its tables and answers, on the host. */
COLLIDED_API collided_status collided_scene_memory(collided_scene* scene, uint64_t* bytes);
/* The device that the scene is on. */
COLLIDED_API collided_status collided_scene_device(collided_scene* scene, collided_device_info* info);
/* Copies the positions of a mesh at the end of the last frame that counted, as float[3] or, in F64 scenes, double[3]
 * per vertex. bytes: size of `to`, exactly that of the positions. COLLIDED_FAILED_PRECONDITION before the first frame.
 */
COLLIDED_API collided_status collided_scene_positions(collided_scene* scene, uint32_t mesh, void* to, uint64_t bytes);

/* ---- Frames ---- */

/* New positions of one mesh, packed x y z in the scene's format. They may lie in memory of the scene's CUDA device:
 * collided_frame.stream names the stream that writes them. */
typedef struct collided_update {
  size_t struct_size;
  const void* start;       /* CCD: at t = 0; null: where the last frame left the mesh */
  const void* end;         /* at t = 1 */
  uint64_t start_bytes;    /* size of `start` */
  uint64_t end_bytes;      /* size of `end`: that of all vertices, or of those in `indices` */
  const uint32_t* indices; /* [index_count] of a sparse update: strictly ascending vertices of the mesh */
  uint64_t index_count;
  int32_t is_sparse; /* only the vertices of `indices` change; else index_count is 0 */
  uint32_t mesh;     /* its number in the scene; each mesh at most once in a frame */
  /* Rigid meshes: rows of [R | t], 12 doubles. R is a rotation to within 1e-4, and transforms the positions of the
   * first frame. */
  const double* transform;       /* at t = 1 */
  const double* start_transform; /* CCD: at t = 0; null: where the last frame left the mesh */
} collided_update;

typedef struct collided_frame {
  size_t struct_size;
  const collided_update* updates; /* [update_count]; the stride is updates[0].struct_size. The first frame names every
                                     mesh, later ones those that move */
  uint64_t update_count;
  int32_t mode;                 /* of this frame; 0: the scene's */
  int32_t accuracy;             /* likewise */
  int32_t report;               /* likewise */
  int32_t ignore_separating;    /* CCD from GUARDED on: contacts that come no closer do not count in earliest_toi */
  int32_t advance;              /* CCD from CERTIFIED on: go only as far as is certified: features keep min_separation,
                                   and those that start closer come no closer */
  int32_t trial;                /* answer, and leave the scene as it was */
  const double* delta;          /* of this frame; null: the scene's */
  const double* start_fraction; /* CCD: begin this far along the last frame's way, 0 to 1; null: at its end */
  int32_t (*cancelled)(void* context); /* may be null. The calling thread asks it about every 8 ms; other than 0: give
                                          up. It must not use this scene, nor leave by an exception or longjmp */
  void* cancelled_context;
  /* A cudaStream_t of the scene's CUDA device. The frame begins after the work that the stream holds now, which may
   * write the updates' positions or read `room`; the program need not wait for it. cudaStreamLegacy and
   * cudaStreamPerThread are accepted. A stream that is being captured is refused. Null: no such work is left. */
  void* stream;
  /* Memory of the scene's device (of the host, where that is the CPU), aligned to 64 bytes. Contacts stay there, and
   * collided_result_contacts_in_room names them; those that do not fit come to the host. They are complete when the
   * call returns. Null: all contacts come to the host. */
  void* room;
  uint64_t room_bytes;
  int32_t advance_mode; /* with `advance` alone: COLLIDED_ADVANCE_ALL_OR_ONE ... */
  int32_t limits;       /* with `advance` alone: find what limits the way, for collided_result_limits */
} collided_frame;

typedef struct collided_result collided_result;

/* Applies one frame and finds its contacts. Sets *result, to be freed by collided_result_free; to null if it fails. */
COLLIDED_API collided_status collided_detect(collided_scene* scene, const collided_frame* frame,
                                             collided_result** result);
/* result: may be null. */
COLLIDED_API void collided_result_free(collided_result* result);

/* Contacts of one kind, sorted by their two elements. An array is null if there are no contacts, or if the scene does
 * not ask for it, or if mode and accuracy do not compute it. */
typedef struct collided_contacts {
  size_t struct_size;
  uint64_t count;
  const uint32_t* elements; /* [count][2]: vertex and element, two edges, two elements, or edge and triangle;
                               scene-wide */
  const uint32_t* stencils; /* [count][4]: vertex and its triangle's three, or the ends of both edges; scene-wide */
  const double* toi;        /* [count]: time of impact, 0 to 1 of the step (CCD from FAST on) */
  const double* distance;   /* [count]: at the time of impact or, in DCD, of the frame (from FAST on); >= 0, but of
                               VERTEX_SOLID minus the depth */
  const double* weights;    /* [count][2]: of the triangle's second and third corner, or along each edge */
  const float* normals;     /* [count][3]: unit length, from the second feature to the first */
  const uint8_t* flags;     /* [count]: masks COLLIDED_FLAG_... (from FAST on) */
  const uint8_t* features;  /* [count]: masks COLLIDED_CLOSEST_..., of VERTEX_TRIANGLE and EDGE_EDGE (DCD from FAST on,
                               REPORT_ALL) */
  /* [count], likewise, in scenes with a solid: minus `distance` where a closest point is inside the other mesh; NaN
   * where neither mesh is a solid, and where one of two features at a distance above 0 meets the other mesh. */
  const double* signed_distance;
} collided_contacts;

enum {
  COLLIDED_FLAG_CERTIFIED = 1,   /* certain in exact arithmetic */
  COLLIDED_FLAG_NEAR = 2,        /* certain only to within delta and the working precision */
  COLLIDED_FLAG_CAPPED = 4,      /* the iteration limit was met; toi is still a lower bound */
  COLLIDED_FLAG_INITIAL = 8,     /* in contact at t = 0 (with NEAR: to within delta) */
  COLLIDED_FLAG_SEPARATING = 16, /* in contact at t = 0, and certain to come no closer in the step */
  COLLIDED_FLAG_COVERED = 32,    /* with `features`: another contact is between the same two features, or is nearer */
  COLLIDED_FLAG_TOUCHING = 64 /* EDGE_TRIANGLE: they touch, and the order of their vertices' ids makes it a crossing */
};

/* Masks of collided_contacts.features. The closest points are p, of the first feature, and q, of the second. Ties go to
 * the feature of the lowest dimension. */
enum {
  COLLIDED_CLOSEST_ON_TRIANGLE = 7,       /* VERTEX_TRIANGLE, q: 0 within the face, 1 to 3 on the side opposite to this
                                             corner of the stencil's three, 4 to 6 on a corner */
  COLLIDED_CLOSEST_ON_FIRST_EDGE = 3,     /* EDGE_EDGE, p: 0 within the edge, 1 or 2 on this end of it in the stencil */
  COLLIDED_CLOSEST_ON_SECOND_EDGE = 12,   /* EDGE_EDGE, q, likewise: 0, 4 or 8 */
  COLLIDED_CLOSEST_NEARER_AT_FIRST = 16,  /* the first surface comes clearly nearer beside p */
  COLLIDED_CLOSEST_NEARER_AT_SECOND = 32, /* the second surface comes clearly nearer beside q */
  COLLIDED_CLOSEST_SAME_AS_BEFORE = 64    /* an earlier contact is between the same two features; VERTEX_TRIANGLE comes
                                             before EDGE_EDGE */
};

/* Gives the contacts on the host: all of them, or those that did not fit into collided_frame.room. */
COLLIDED_API collided_status collided_result_contacts(const collided_result* result, int32_t kind,
                                                      collided_contacts* contacts);
/* Gives the contacts in collided_frame.room, which come before those on the host; the arrays lie in it. */
COLLIDED_API collided_status collided_result_contacts_in_room(const collided_result* result, int32_t kind,
                                                              collided_contacts* contacts);

/* Gives the contacts of one kind that limit the way of a frame with `limits`, sorted as contacts are: the pairs of
 * features that the whole way would bring nearer than they may come. All arrays are there, whatever the scene asks for,
 * and on the host. `distance` is the least that the pair keeps, `toi` the fraction of the whole way at which it comes
 * to that, no later than in truth; weights and normals are those of `toi`. */
COLLIDED_API collided_status collided_result_limits(const collided_result* result, int32_t kind,
                                                    collided_contacts* limits);

/* What a frame found and what it cost, besides its contacts. */
typedef struct collided_facts {
  size_t struct_size;
  uint64_t contact_count;   /* of all kinds */
  double earliest_toi;      /* 0 to 1; 1 where there is none, and where times are not computed */
  double advanced;          /* with `advance`: how far the scene went, 0 to 1: the least fraction of anything that
                               moves; else 1 */
  int32_t any_contact;      /* candidates do not count */
  int32_t input_resolution; /* the positions' own spacing is coarser than delta */
  double step_milliseconds; /* from positions on the device to sorted contacts there */
  uint32_t stage_count;
  uint32_t unused_option_count;
  uint32_t replays;           /* runs of the step that were repeated because memory had to grow */
  uint32_t allocations;       /* of memory on the device */
  uint32_t graph_launches;    /* of CUDA graphs */
  int32_t broad_phase_engine; /* that found the pairs: COLLIDED_OCTREE ... */
  /* Work: */
  uint64_t cells, leaves, registrations, tests, pairs, exact_decisions;
  uint32_t top_level, base_level;
  /* [kind - 1], of the kinds that measure distances and of two triangles: */
  uint64_t candidates[3], survivors[3], contacts[3];
  double way; /* with `advance`: lengths of all vertices' ways that were gone, added up, divided by those of the whole
                 ways, 0 to 1; else 1 */
  /* With `advance` PER_MESH or PER_VERTEX: what did not go all of its way. */
  uint64_t shortened_count;
  const uint32_t* shortened_ids;     /* [shortened_count], ascending: meshes, or scene-wide vertices */
  const double* shortened_fractions; /* [shortened_count]: how far each went, 0 or more and less than 1 */
  uint64_t edge_triangle_contacts;   /* `contacts` of COLLIDED_EDGE_TRIANGLE, which has no candidates */
  uint64_t vertex_solid_contacts;    /* and of COLLIDED_VERTEX_SOLID */
  uint64_t mesh_pair_count;          /* for collided_result_mesh_pair */
  uint64_t inside_out;               /* of it: vertices whose winding number in another mesh, a solid, is below 0 */
} collided_facts;

COLLIDED_API collided_status collided_result_facts(const collided_result* result, collided_facts* facts);
/* collided_mesh_pair.state */
enum {
  COLLIDED_PAIR_TOUCHING = 1,    /* they have points in common, and no volume or, if one is no solid, no triangles that
                                    go through each other */
  COLLIDED_PAIR_OVERLAPPING = 2, /* they meet in more than that, or a vertex of one is in the other, but not as below */
  COLLIDED_PAIR_FIRST_INSIDE = 3, /* surfaces have no point in common; all vertices of the first are in the second */
  COLLIDED_PAIR_SECOND_INSIDE = 4 /* the same the other way round */
};

/* Two meshes, one of them a solid at least, that are not apart, in a DCD frame of a scene with FIELDS_PAIR_STATES. */
typedef struct collided_mesh_pair {
  size_t struct_size;
  uint32_t first; /* numbers of the meshes, first < second */
  uint32_t second;
  int32_t state;          /* COLLIDED_PAIR_TOUCHING ... */
  uint32_t first_inside;  /* vertices of the first mesh that are inside the second */
  uint32_t second_inside; /* and of the second inside the first */
  uint32_t deepest;       /* of these vertices, scene-wide, the least of several; UINT32_MAX: there is none */
  double depth;           /* its distance from the other mesh's surface, >= 0 */
} collided_mesh_pair;

/* One of those pairs, by `first`, then `second`. index: 0 to collided_facts.mesh_pair_count - 1. */
COLLIDED_API collided_status collided_result_mesh_pair(const collided_result* result, uint64_t index,
                                                       collided_mesh_pair* pair);
/* A stage that ran, in order. index: 0 to stage_count - 1. The name belongs to the result. */
COLLIDED_API collided_status collided_result_stage(const collided_result* result, uint32_t index, const char** name,
                                                   double* milliseconds);
/* An option of the scene that is set and had no effect on this frame. index: 0 to unused_option_count - 1. The name
 * belongs to the result. */
COLLIDED_API collided_status collided_result_unused_option(const collided_result* result, uint32_t index,
                                                           const char** name);

#ifdef __cplusplus
}
#endif

#endif
