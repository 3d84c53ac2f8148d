// A resident scene: its plan, its detector, its worker, and its visible state.
#include "server/scenes/scene.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include "server/auth/secrets.hpp"
#include "server/errors.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {

namespace {

// Ids rise strictly, from 1.
void check_frame_id(uint64_t frame_id, uint64_t last_frame_id) {
  if (frame_id == 0) throw InvalidInput("frame.frame_id", "frame.frame_id is 0, but ids start at 1");
  if (frame_id <= last_frame_id)
    throw FailedPrecondition("frame.frame_id",
                             fmt::format("frame.frame_id is {}, but must be greater than {}, the last frame applied",
                                         frame_id, last_frame_id));
}

uint64_t element_bytes(const SceneSpec& spec) {
  uint64_t bytes = 0;
  for (const auto& mesh : spec.meshes)
    bytes += mesh.triangles.capacity() * sizeof(mesh.triangles[0]) + mesh.edges.capacity() * sizeof(mesh.edges[0]) +
             mesh.points.capacity() * sizeof(mesh.points[0]);
  return bytes;
}

// A copy; the elements, which may be many, are never copied.
MeshSpec without_elements(MeshSpec& mesh) {
  auto triangles = std::exchange(mesh.triangles, {});
  auto edges = std::exchange(mesh.edges, {});
  auto points = std::exchange(mesh.points, {});
  MeshSpec out = mesh;
  mesh.triangles = std::move(triangles);
  mesh.edges = std::move(edges);
  mesh.points = std::move(points);
  return out;
}

std::shared_ptr<PartedBytes> parted_bytes(const ScenePlan& plan) {
  if (plan.parts.empty()) return nullptr;
  return std::make_shared<PartedBytes>(DeviceBytes::of_scene(plan.engine.memory_budget, plan.quota), plan.parts);
}

std::vector<Device> devices_of(const SceneSpec& spec) {
  if (spec.part_devices.empty()) return {spec.device};
  const std::set<Device> devices(spec.part_devices.begin(), spec.part_devices.end());
  return {devices.begin(), devices.end()};
}

std::vector<Turns*> turns_on(ServedDevices& served, const std::vector<Device>& devices) {
  std::vector<Turns*> turns;
  for (const Device& device : devices) turns.push_back(&served.turns(device));
  return turns;
}

}  // namespace

Scene::Scene(SceneIdentity identity, ScenePlan plan, SceneContext context)
    : identity_(std::move(identity)),
      context_(std::move(context)),
      parted_(parted_bytes(plan)),
      quota_(parted_ ? parted_->whole() : DeviceBytes::of_scene(plan.engine.memory_budget, plan.quota)),
      device_(plan.engine.device),
      devices_(devices_of(plan.engine)),
      turns_(turns_on(context_.devices, devices_), identity_.owner->turn_path()),
      host_turns_({&context_.devices.host_turns()}, identity_.owner->turn_path()),
      held_(quota_),
      worker_(identity_.queue_capacity) {
  held_.resize(plan_bytes(plan) + element_bytes(plan.engine));
  auto meshes = std::move(plan.engine.meshes);
  plan.engine.meshes.clear();
  pending_ = plan.engine;
  pending_.memory_quota = quota_;
  if (parted_) pending_.memory_quota = parted_;
  pending_.meshes = std::move(meshes);
  for (size_t i = 0; i < plan.meshes.size(); ++i) {
    shown_.vertices += pending_.meshes[i].vertex_count;
    shown_.triangles += plan.meshes[i].triangles;
    awaited_.push_back(plan.meshes[i].awaited);
    uploading_.push_back(false);
    plan.engine.meshes.push_back(without_elements(pending_.meshes[i]));
    excludes_rest_pairs_ |= pending_.meshes[i].excludes_rest_pairs;
  }
  shown_.plan = std::make_shared<const ScenePlan>(std::move(plan));
}

SceneSnapshot Scene::snapshot() const {
  std::lock_guard lock(mutex_);
  SceneSnapshot now = shown_;
  if (!now.ready) now.memory = {{"host", quota_->held()}};  // includes what uploads have received so far
  return now;
}

uint64_t Scene::device_bytes() const {
  const std::lock_guard lock(mutex_);
  uint64_t bytes = 0;
  for (const auto& part : shown_.memory) bytes += part.bytes;
  return bytes;
}

uint64_t Scene::awaited(uint32_t mesh) const {
  std::lock_guard lock(mutex_);
  return awaited_.at(mesh);
}

void Scene::begin_upload(uint32_t mesh) {
  std::lock_guard lock(mutex_);
  if (awaited_[mesh] == 0)
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, shown_.plan->meshes[mesh].name));
  if (uploading_[mesh])
    throw FailedPrecondition("mesh", fmt::format("mesh is {} (\"{}\"), which another upload is sending", mesh,
                                                 shown_.plan->meshes[mesh].name));
  uploading_[mesh] = true;
}

void Scene::end_upload(uint32_t mesh) {
  std::lock_guard lock(mutex_);
  uploading_[mesh] = false;
}

bool Scene::awaits_triangles() const {
  return std::any_of(awaited_.begin(), awaited_.end(), [](uint64_t n) { return n > 0; });
}

void Scene::throw_awaits(const std::string& field) const {
  const auto mesh = static_cast<size_t>(
      std::find_if(awaited_.begin(), awaited_.end(), [](uint64_t n) { return n > 0; }) - awaited_.begin());
  if (mesh == awaited_.size())
    throw FailedPrecondition(field, fmt::format("{}: scene {} has all its triangles and is being built", field, id()));
  const MeshPlan& plan = shown_.plan->meshes[mesh];
  const auto others = std::count_if(awaited_.begin(), awaited_.end(), [](uint64_t n) { return n > 0; }) - 1;
  throw FailedPrecondition(
      field, fmt::format("{}: scene {} takes no frames yet: mesh {} (\"{}\") awaits {} of its {} triangles{}; send "
                         "them with UploadMesh",
                         field, id(), mesh, plan.name, awaited_[mesh], plan.triangles,
                         others > 0 ? fmt::format(", and {} more meshes await theirs", others) : ""));
}

bool Scene::unusable() const {
  std::lock_guard lock(mutex_);
  return !shown_.ready && !awaits_triangles();
}

void Scene::check_open() const {
  if (!closed_) return;
  throw NotFound("scene_id", fmt::format("scene {} {}", id(), end_.text(std::chrono::steady_clock::now())));
}

void Scene::check_built() const {
  if (build_failure_) std::rethrow_exception(build_failure_);
}

void Scene::check_token(const std::string& token, bool has_stream) const {
  if (token.empty() && has_stream)
    throw FailedPrecondition("open.resume_token",
                             fmt::format("open.resume_token is empty, but another stream of scene {} is open", id()));
  if (!token.empty() && !is_equal_secret(token, identity_.resume_token))
    throw PermissionDenied("open.resume_token", fmt::format("open.resume_token is not the token of scene {}", id()));
}

void Scene::check_is_one(const std::string& field) const {
  if (const uint32_t worlds = plan()->engine.worlds; worlds > 0)
    throw FailedPrecondition(field,
                             fmt::format("{}: scene {} is a set of {} scenes, whose frames come by DetectBatch or "
                                         "StreamFrames",
                                         field, id(), worlds));
}

std::shared_ptr<SceneStream> Scene::begin_stream(const std::shared_ptr<SceneStream>& stream, const std::string& token) {
  const std::lock_guard lock(mutex_);
  check_open();
  if (!shown_.ready) throw_awaits("open.scene_id");
  check_token(token, stream_ != nullptr);
  return std::exchange(stream_, stream);
}

bool Scene::would_take_over(const std::string& token) const {
  const std::lock_guard lock(mutex_);
  return stream_ && is_equal_secret(token, identity_.resume_token);
}

void Scene::end_stream(const SceneStream& stream) {
  std::shared_ptr<SceneStream> ended;
  const std::lock_guard lock(mutex_);
  if (stream_.get() == &stream) ended.swap(stream_);
}

std::shared_ptr<SceneStream> Scene::stream() const {
  const std::lock_guard lock(mutex_);
  return stream_;
}

void Scene::close(const SceneEnd& end) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    end_ = end;  // read without the lock once closed_ is set
    closed_ = true;
  }
  const auto why = std::make_exception_ptr(NotFound("scene_id", fmt::format("scene {} {}", id(), end.text(end.when))));
  if (const auto open = stream()) open->end(why);
  for (const auto& watcher : watchers_.all()) watcher->end(why);
}

void Scene::begin_watch(std::shared_ptr<SceneWatcher> watcher) {
  check_is_one("scene_id");
  const std::lock_guard lock(mutex_);  // so that close() finds it
  check_open();
  watchers_.add(std::move(watcher));
}

std::shared_ptr<FrameSlot> Scene::take_slot() {
  std::shared_ptr<SlotPool> slots;
  {
    const std::lock_guard lock(mutex_);
    slots = slots_;
  }
  if (auto slot = slots ? slots->take() : nullptr) return slot;
  check_open();
  const std::lock_guard lock(mutex_);
  throw_awaits("scene_id");
}

uint64_t Scene::max_position_bytes() const {
  const auto now = plan();
  return count_worlds(now->engine) * count_vertices(now->engine) * max_vertex_bytes(now->engine);
}

void Scene::begin_use() {
  const std::lock_guard lock(mutex_);
  ++uses_;
}

void Scene::end_use() {
  const std::lock_guard lock(mutex_);
  --uses_;
  last_use_ = now();
}

bool Scene::is_expired(std::chrono::steady_clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  return uses_ == 0 && now - last_use_ > std::chrono::duration<double>(identity_.lease_seconds);
}

void Scene::release() {
  std::shared_ptr<SlotPool> slots;
  {
    const std::lock_guard lock(mutex_);
    slots.swap(slots_);
  }
  if (slots) slots->close();
  samples_.clear();
  detector_.reset();
  pending_ = {};
  held_.resize(0);
}

void Scene::build_if_complete() {
  check_open();
  if (awaits_triangles()) return;  // only this thread writes what is read here
  make_detector();
  {
    const std::lock_guard lock(mutex_);
    slots_ = std::make_shared<SlotPool>(detector_);
  }
  publish();
}

void Scene::make_detector() try {
  const auto is_closed = [this] { return closed_.load(); };
  auto turn = host_turns_.take(is_closed);
  detector_ = naming_paths(spec_path, [&] {
    return Detector::create(std::move(pending_), [&] {
      turn.yield_turn(is_closed);
      return is_closed();
    });
  });
  pending_ = {};
  held_.resize(host_bytes());
} catch (const Cancelled&) {
  check_open();
  throw;
} catch (...) {
  build_failure_ = std::current_exception();
  throw;
}

uint64_t Scene::host_bytes() const {
  return plan_bytes(*shown_.plan) + count_tables(shown_.plan->engine) * topology_bytes(detector_->topology());
}

std::string Scene::mesh_name(uint32_t mesh) const {
  return fmt::format("mesh {} (\"{}\")", mesh, plan()->meshes[mesh].name);
}

void Scene::add_triangles(uint32_t mesh, ReceivedTriangles& triangles) {
  check_open();
  const uint64_t wanted = awaited(mesh);
  if (wanted == 0)
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, shown_.plan->meshes[mesh].name));
  if (triangles.size() != wanted)
    throw InvalidInput("triangles",
                       fmt::format("triangles is incomplete: the upload ended after {} of {} triangles, in {}",
                                   triangles.size(), wanted, mesh_name(mesh)));
  triangles.move_to(pending_.meshes[mesh].triangles, held_);  // may throw, so the mesh is complete only afterwards
  {
    std::lock_guard lock(mutex_);
    awaited_[mesh] = 0;
  }
  build_if_complete();
}

FrameResult Scene::apply(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis) {
  check_open();
  if (!detector_) throw_awaits("scene_id");    // only this thread writes what is read here
  const uint64_t last = shown_.last_frame_id;  // written by this thread only
  check_frame_id(frame_id, last);
  if (basis.plan && basis.plan != shown_.plan) throw_edited(frame_id);
  samples_.clear();
  FrameResult result = naming_paths(frame_path, [&] { return detect(frame_id, frame, basis); });
  if (!frame.trial) {
    std::lock_guard lock(mutex_);
    shown_.last_frame_id = frame_id;
  }
  try {
    publish();
  } catch (const std::bad_alloc&) {  // the frame was applied; its successor will tell what the scene holds
  }
  return result;
}

FrameResult Scene::detect(uint64_t frame_id, const FrameInput& frame, const FrameBasis& basis) try {
  if (!frame.edit) return detector_->detect(frame);
  MemoryHold making(quota_);
  making.resize(count_tables(shown_.plan->engine) *
                max_edit_bytes(*frame.edit));  // once the engine has applied the edit nothing may fail
  FrameResult result = detector_->detect(frame);
  take_edit(basis, making);
  return result;
} catch (const InvalidInput& e) {
  if (e.field() == "slot") throw_edited(frame_id);  // taken while the edit was in work
  throw;
}

std::shared_ptr<const std::string> Scene::positions(const VertexSample& sample) {
  check_open();
  for (const auto& [before, positions] : samples_)
    if (before == sample) return positions;
  std::string bytes(sample.count * position_bytes(shown_.plan->engine.scalar), '\0');
  if (sample.count > 0) detector_->read_positions(sample, std::as_writable_bytes(std::span(bytes)));
  samples_.emplace_back(sample, std::make_shared<const std::string>(std::move(bytes)));
  return samples_.back().second;
}

void Scene::publish() {
  auto memory = detector_->memory();
  memory.push_back({"host", held_.bytes()});
  const auto& topology = detector_->topology();
  auto device = detector_->device().name;
  std::lock_guard lock(mutex_);
  shown_.ready = true;
  shown_.device = std::move(device);
  shown_.edges = topology.edges.size();
  shown_.memory = std::move(memory);
}

}  // namespace collided::server
