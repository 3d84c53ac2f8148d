#pragma once
// A connection to a daemon: scenes and streams. Every function throws Error with the daemon's code and message.

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/connect_options.hpp"
#include "client/cpp/error.hpp"
#include "client/cpp/frame_stream.hpp"
#include "client/cpp/local_options.hpp"
#include "client/cpp/watcher.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::client {

/// A mesh of a new scene, of triangles, loose edges and loose points, one of them or more. They are borrowed. There
/// may be any number of triangles: many go up in chunks. The loose elements of all meshes are sent in one message.
struct MeshInput {
  std::string name = "";
  uint32_t vertex_count = 0;
  std::span<const std::array<uint32_t, 3>> triangles = {};
  bool is_static = false;
  bool is_rigid = false;            ///< after its first frame it is moved by FrameUpdate::transform alone
  uint32_t exclude_rings = 0;       ///< leave out self contacts of features that so many edges or fewer connect; 0 to 8
  bool exclude_rest_pairs = false;  ///< likewise of features within the spec's rest_distance in the first frame
  std::span<const std::array<uint32_t, 2>> edges = {};  ///< such as the segments of a hair
  std::span<const uint32_t> points = {};                ///< such as particles
  uint32_t groups = 0;                                  ///< bits of the groups that it is in; 0: the first
  uint32_t collide_mask = 0;                            ///< bits of the groups that it can touch; 0: all
  bool no_self_contacts = false;                        ///< leave out its contacts with itself
  /// Half of what it is thick beyond the spec's thickness, >= 0, finite, in the unit of the positions: two meshes are
  /// in contact up to the thickness and both halves, a mesh and itself up to the thickness and twice its half.
  double half_thickness = 0;
  /// It bounds a volume: of triangles alone, closed, with normals outwards. Then scenes can ask what is inside it, with
  /// v1::CONTACT_KIND_VERTEX_SOLID, v1::CONTACT_FIELD_PAIR_STATES and v1::CONTACT_FIELD_SIGNED_DISTANCE.
  bool solid = false;
};

/// The mesh as an edit brings it (FrameOptions::edit): added, or in place of another; with its elements, or without
/// them where those that it has stay. An empty name stays, too. Throws Error (INVALID_ARGUMENT).
v1::MeshEdit edited_mesh(uint32_t mesh, const MeshInput& input);
/// Removes a mesh.
v1::MeshEdit removed_mesh(uint32_t mesh);

/// A mesh of a living scene.
struct MeshElements {
  uint32_t vertex_count = 0;  ///< 0: it was removed
  /// In the order of their scene-wide ids: triangles, then loose edges as a b b, then loose points as a a a, numbered
  /// within the mesh.
  std::vector<std::array<uint32_t, 3>> elements;
  uint64_t edit_count = 0;  ///< of the scene, when this was so
};

class ChannelFactory;

/// How a stream is opened.
struct StreamOptions {
  uint32_t window = 0;  ///< frames in flight, up to the daemon's limit; 0: the daemon chooses
  v1::DeliveryPolicy delivery = v1::DELIVERY_POLICY_UNSPECIFIED;
  std::string resume_token = "";  ///< the scene's; takes it over from a stream that may still be open
  LocalOptions local = {};        ///< memory shared with a daemon on this host
  KeeperPace keeper = {};         ///< of the thread that reads while no caller waits
};

/// A connection to a daemon, and the scenes that it creates.
class Client {
 public:
  /// `address` is host:port or unix:/path. Waits for the connection. Throws Error: UNAVAILABLE if no daemon answers in
  /// time, INVALID_ARGUMENT for bad options, and for an address without a port from 1 to 65535.
  static Client connect(const std::string& address, const ConnectOptions& options = {});
  /// For the library's own use: a session connects again, and collided::local() to what it has made.
  static Client connect(const ChannelFactory& channels);
  /// What this client was made with; for the library's own use.
  const ChannelFactory& channels() const;
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  /// The daemon's version, devices and limits, as of the connection.
  const v1::GetServerInfoResponse& server_info() const;
  /// Lists all fields of contacts that the daemon knows, for SceneSpec.fields. An older daemon may lack the last ones.
  /// States of pairs of meshes are not among them: they are no field of a contact, and need a solid.
  std::vector<v1::ContactField> contact_fields() const;
  /// Creates a scene of `spec` (which must have no meshes) and `meshes`, ready for frames. Retries if the answer is
  /// lost, without ever creating two scenes. The scene is deleted after `lease_seconds` without a stream or a call; 0:
  /// the daemon's default.
  v1::Scene create_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes, double lease_seconds = 0);
  /// The same for `count` scenes of one spec, a set with one id, whose triangles are sent and held once; SceneSet
  /// (client/cpp/batch/scene_set.hpp) has their frames.
  v1::Scene create_scenes(v1::SceneSpec spec, std::span<const MeshInput> meshes, uint32_t count,
                          double lease_seconds = 0);
  /// What create_scene of the same arguments would cost, before anything is made: no triangle is sent, loose elements
  /// are. `spec` may have meshes, too, whose numbers of triangles are enough. Throws what create_scene would throw for
  /// a bad spec.
  v1::EstimateSceneResponse estimate_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes);
  /// A scene of this client as it is now, without triangles. Throws Error: NOT_FOUND if there is none.
  v1::Scene get_scene(const std::string& scene_id);
  /// The scenes of this client, by id.
  std::vector<v1::Scene> list_scenes();
  /// What a mesh of the scene is made of, whoever created it. Throws Error (ABORTED) if edits keep changing it.
  MeshElements mesh_elements(const std::string& scene_id, uint32_t mesh);
  /// Ends its stream and frees its memory at once. Throws Error as get_scene does.
  void delete_scene(const std::string& scene_id);
  /// Opens a stream: over shared memory if options.local allows it, else on a separate connection to the scene's
  /// endpoint; in process neither is needed.
  FrameStream stream(const v1::Scene& scene, const StreamOptions& options = {});
  /// Resumes a scene whose stream broke: send the frames after the new stream's scene().last_frame_id() again. Takes
  /// all of `options` but the token, which is the scene's.
  FrameStream resume(const v1::Scene& scene, StreamOptions options = {});
  /// Watches the frames that others send to a scene of this client, on a separate connection.
  Watcher watch(const std::string& scene_id, const WatchOptions& options = {});

 private:
  struct State;
  explicit Client(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
