#include "tests/integration/model/set_session.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

namespace collided::test {
namespace {

struct LiveSet {
  std::string id;
  pb::DetectionMode mode = pb::DETECTION_MODE_CCD;
  uint64_t last_frame_id = 0;
  std::vector<SceneModel> worlds;
};

LiveSet make_set(Numbers& numbers, Stub& stub) {
  LiveSet set;
  if (numbers.one_in(2)) set.mode = pb::DETECTION_MODE_DCD;
  std::vector<ModelMesh> meshes = any_meshes(numbers);
  // Each frame then has positions of every mesh.
  for (ModelMesh& mesh : meshes) mesh.motion = MeshMotion::kDeformable;
  const double thickness = numbers.below(3) / 2.0;
  pb::CreateScenesRequest request;
  *request.mutable_spec() = spec_of(meshes, set.mode, thickness);
  request.set_count(1 + numbers.below(3));
  set.worlds.assign(request.count(), SceneModel(meshes, thickness));
  grpc::ClientContext context;
  set_deadline(context);
  pb::CreateScenesResponse response;
  const auto status = stub.CreateScenes(&context, request, &response);
  require(status.ok(), "a set was refused: " + status.error_message());
  set.id = response.scenes().scene_id();
  return set;
}

/// A world in a frame.
struct Stepped {
  uint32_t world;
  bool bad;
  ModelFrame frame;
};

Stepped step_of(Numbers& numbers, const LiveSet& set, uint32_t world, bool starts) {
  Stepped stepped{world, numbers.one_in(5), {}};
  stepped.frame.id = set.last_frame_id + 1;
  stepped.frame.discrete = set.mode == pb::DETECTION_MODE_DCD;
  const auto& meshes = set.worlds[world].meshes();
  for (uint32_t m = 0; m < meshes.size(); ++m) {
    ModelUpdate update{.mesh = m, .sparse = {}, .matrix = {}, .start = {}, .end = {}};
    update.end = any_positions(numbers, meshes[m].vertex_count);
    if (starts) update.start = any_positions(numbers, meshes[m].vertex_count);
    stepped.frame.updates.push_back(std::move(update));
  }
  return stepped;
}

void add_to(pb::SetFrame& message, const Stepped& stepped) {
  message.add_worlds(stepped.world);
  for (const ModelUpdate& update : stepped.frame.updates) {
    message.mutable_positions()->append(floats(update.end));
    if (update.start) message.mutable_start_positions()->append(floats(*update.start));
  }
  if (!stepped.bad) return;
  std::string& positions = *message.mutable_positions();
  positions.replace(positions.size() - 4, 4, pack<float>({std::numeric_limits<float>::quiet_NaN()}));
}

/// The contacts of the i-th world, with the totals that a scene of its own would have.
void check_world(const SceneModel& model, const Stepped& stepped, size_t i, const pb::SetAnswer& answer) {
  std::vector<pb::ContactChunk> chunks;
  pb::FrameDone done;
  double earliest = 1;
  for (const auto& of_kind : answer.contacts()) {
    uint64_t begin[2];
    require(of_kind.begin().size() >= (i + 2) * sizeof(uint64_t), "a world without contacts' begin");
    std::memcpy(begin, of_kind.begin().data() + i * sizeof(uint64_t), sizeof(begin));
    const auto& all = of_kind.contacts();
    const auto part = [&](const std::string& bytes, size_t each) {
      return bytes.empty() ? bytes : bytes.substr(begin[0] * each, (begin[1] - begin[0]) * each);
    };
    pb::ContactChunk chunk;
    chunk.set_kind(all.kind());
    chunk.set_count(static_cast<uint32_t>(begin[1] - begin[0]));
    chunk.set_elements(part(all.elements(), 8));
    chunk.set_toi(part(all.toi(), 8));
    chunk.set_flags(part(all.flags(), 1));
    for (size_t k = 0; k < chunk.toi().size(); k += 8) {
      double toi;
      std::memcpy(&toi, chunk.toi().data() + k, sizeof(toi));
      earliest = std::min(earliest, toi);
    }
    done.set_contact_count(done.contact_count() + chunk.count());
    chunks.push_back(std::move(chunk));
  }
  done.set_any_contact(done.contact_count() > 0);
  done.set_earliest_toi(earliest);
  check_answer(model, stepped.frame, pb::ACCURACY_EXACT, model.way_of(stepped.frame), chunks, done);
}

void step(Numbers& numbers, LiveSet& set, Stub& stub) {
  const bool starts = set.mode != pb::DETECTION_MODE_DCD && numbers.one_in(3);
  std::vector<Stepped> steps;
  for (uint32_t world = 0; world < set.worlds.size(); ++world)
    if (!numbers.one_in(4)) steps.push_back(step_of(numbers, set, world, starts));
  if (steps.empty()) return;
  pb::DetectBatchRequest request;
  pb::SetFrame& message = *request.add_frames();
  message.set_scene_id(set.id);
  message.set_frame_id(set.last_frame_id + 1);
  for (const Stepped& stepped : steps) add_to(message, stepped);
  const bool spoilt = numbers.one_in(6);
  if (spoilt) message.mutable_positions()->push_back('\0');

  grpc::ClientContext context;
  set_deadline(context);
  pb::DetectBatchResponse response;
  const auto status = stub.DetectBatch(&context, request, &response);
  require(status.ok() && response.answers_size() == 1, "a batch was refused: " + status.error_message());
  const pb::SetAnswer& answer = response.answers(0);
  require_code(answer.error().code(), spoilt ? grpc::INVALID_ARGUMENT : grpc::OK, "a set's frame");
  if (spoilt) return;

  std::map<uint32_t, int> refused;
  for (const auto& error : answer.errors()) refused[error.world()] = error.error().code();
  for (size_t i = 0; i < steps.size(); ++i) {
    const Stepped& stepped = steps[i];
    require(refused.contains(stepped.world) == stepped.bad, "worlds were refused that are good, or the reverse");
    if (stepped.bad) continue;
    SceneModel& world = set.worlds[stepped.world];
    check_world(world, stepped, i, answer);
    world.apply(stepped.frame, world.way_of(stepped.frame));
  }
  set.last_frame_id = message.frame_id();
}

}  // namespace

void run_set(Numbers& numbers, Client& client) {
  Stub& stub = *client.stub;
  LiveSet set = make_set(numbers, stub);
  const uint32_t frames = 1 + numbers.below(3);
  for (uint32_t k = 0; k < frames; ++k) step(numbers, set, stub);
  pb::Scene seen;
  require(get_scene(stub, set.id, &seen).ok(), "a set is gone");
  require(seen.last_frame_id() == set.last_frame_id, "last_frame_id of a set");
  require(seen.worlds() == set.worlds.size(), "worlds of a set");
  require(delete_scene(stub, set.id).ok(), "a set could not be deleted");
}

}  // namespace collided::test
