// A resident scene: its plan, its detector, its worker, and what others may see of it.
#include "server/scenes/scene.hpp"

#include <malloc.h>
#include <openssl/crypto.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "server/errors.hpp"
#include "server/scenes/field_path.hpp"
#include "server/scenes/frame_session.hpp"

namespace collided::server {

namespace {

// In the same time, whatever they have in common.
bool is_equal_secret(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

// Ids rise strictly, from 1.
void check_frame_id(uint64_t frame_id, uint64_t last_frame_id) {
  if (frame_id == 0) throw InvalidInput("frame.frame_id", "frame.frame_id is 0, but ids start at 1");
  if (frame_id <= last_frame_id)
    throw FailedPrecondition("frame.frame_id",
                             fmt::format("frame.frame_id is {}, but must be greater than {}, the last frame applied",
                                         frame_id, last_frame_id));
}

}  // namespace

Scene::Scene(SceneFacts facts, ScenePlan plan, SceneSurroundings surroundings)
    : facts_(std::move(facts)),
      surroundings_(std::move(surroundings)),
      plan_(std::move(plan)),
      pending_(plan_.engine),
      worker_(facts_.queue_capacity) {
  for (size_t i = 0; i < plan_.meshes.size(); ++i) {
    shown_.vertices += pending_.meshes[i].vertex_count;
    shown_.triangles += pending_.meshes[i].triangles.size() + plan_.meshes[i].awaited;
    awaited_.push_back(plan_.meshes[i].awaited);
    uploading_.push_back(false);
    plan_.engine.meshes[i].triangles = {};
  }
}

SceneSnapshot Scene::snapshot() const {
  std::lock_guard lock(mutex_);
  return shown_;
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
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, plan_.meshes[mesh].name));
  if (uploading_[mesh])
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which another upload brings", mesh, plan_.meshes[mesh].name));
  uploading_[mesh] = true;
}

void Scene::end_upload(uint32_t mesh) {
  std::lock_guard lock(mutex_);
  uploading_[mesh] = false;
}

bool Scene::awaits_triangles() const {
  return std::any_of(awaited_.begin(), awaited_.end(), [](uint64_t n) { return n > 0; });
}

bool Scene::unusable() const {
  std::lock_guard lock(mutex_);
  return !shown_.ready && !awaits_triangles();
}

void Scene::check_open() const {
  if (closed_) throw NotFound("scene_id", fmt::format("scene {} was deleted", id()));
}

void Scene::check_token(const std::string& token, bool has_stream) const {
  if (token.empty() && has_stream)
    throw FailedPrecondition("open.resume_token",
                             fmt::format("open.resume_token is empty, but another stream of scene {} is open", id()));
  if (!token.empty() && !is_equal_secret(token, facts_.resume_token))
    throw PermissionDenied("open.resume_token", fmt::format("open.resume_token is not that of scene {}", id()));
}

std::shared_ptr<FrameSession> Scene::begin_stream(const std::shared_ptr<FrameSession>& session,
                                                  const std::string& token) {
  const std::lock_guard lock(mutex_);
  check_open();
  if (!shown_.ready)
    throw FailedPrecondition("open.scene_id", fmt::format("open.scene_id: scene {} still awaits triangles", id()));
  check_token(token, stream_ != nullptr);
  return std::exchange(stream_, session);
}

void Scene::end_stream(const FrameSession& session) {
  std::shared_ptr<FrameSession> ended;
  const std::lock_guard lock(mutex_);
  if (stream_.get() == &session) ended.swap(stream_);
}

std::shared_ptr<FrameSession> Scene::stream() const {
  const std::lock_guard lock(mutex_);
  return stream_;
}

void Scene::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  if (const auto open = stream())
    open->end(std::make_exception_ptr(NotFound("scene_id", fmt::format("scene {} was deleted", id()))));
}

std::shared_ptr<FrameSlot> Scene::take_slot() {
  std::shared_ptr<SlotPool> slots;
  {
    const std::lock_guard lock(mutex_);
    slots = slots_;
  }
  auto slot = slots ? slots->take() : nullptr;
  if (!slot) check_open();
  if (!slot) throw FailedPrecondition("scene_id", fmt::format("scene_id: scene {} still awaits triangles", id()));
  return slot;
}

uint64_t Scene::most_position_bytes() const {
  const uint64_t vertex_bytes = plan_.engine.scalar == Scalar::kF64 ? 24 : 12;
  uint64_t vertices = 0;
  for (const auto& mesh : plan_.engine.meshes) vertices += mesh.vertex_count;
  return vertices * vertex_bytes * (plan_.engine.mode == Mode::kCcd ? 2 : 1);
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
  return uses_ == 0 && now - last_use_ > std::chrono::duration<double>(facts_.lease_seconds);
}

void Scene::release() {
  std::shared_ptr<SlotPool> slots;
  {
    const std::lock_guard lock(mutex_);
    slots.swap(slots_);
  }
  if (slots) slots->close();
  detector_.reset();
  malloc_trim(0);  // by itself the allocator keeps it, for each of its arenas
}

void Scene::build_if_complete() {
  check_open();
  if (awaits_triangles()) return;  // this thread alone writes what it reads
  try {
    detector_ = Detector::create(std::move(pending_));
  } catch (const InvalidInput& e) {
    throw with_path(e, spec_path);
  } catch (const ResourceExhausted& e) {
    throw_if_budget(e);
    throw;
  }
  pending_ = {};
  {
    const std::lock_guard lock(mutex_);
    slots_ = std::make_shared<SlotPool>(detector_);
  }
  publish();
}

void Scene::add_triangles(uint32_t mesh, const Triangles& triangles) {
  check_open();
  const uint64_t wanted = awaited(mesh);
  if (wanted == 0)
    throw FailedPrecondition(
        "mesh", fmt::format("mesh is {} (\"{}\"), which awaits no triangles", mesh, plan_.meshes[mesh].name));
  if (triangles.size() != wanted)
    throw InvalidInput("triangles", fmt::format("triangles is incomplete: the upload ended after {} of {} triangles",
                                                triangles.size(), wanted));
  auto& all = pending_.meshes[mesh].triangles;
  all.insert(all.end(), triangles.begin(), triangles.end());  // may throw, so the mesh counts as complete only after
  {
    std::lock_guard lock(mutex_);
    awaited_[mesh] = 0;
  }
  build_if_complete();
}

FrameResult Scene::apply(uint64_t frame_id, const FrameInput& frame) {
  check_open();
  if (!detector_) throw FailedPrecondition("scene_id", fmt::format("scene_id: scene {} still awaits triangles", id()));
  const uint64_t last = shown_.last_frame_id;  // written by this thread only
  check_frame_id(frame_id, last);
  FrameResult result;
  try {
    result = detector_->detect(frame);
  } catch (const InvalidInput& e) {
    throw with_path(e, frame_path);
  } catch (const ResourceExhausted& e) {
    throw_if_budget(e);
    throw;
  }
  {
    std::lock_guard lock(mutex_);
    shown_.last_frame_id = frame_id;
  }
  publish();
  return result;
}

void Scene::publish() {
  auto memory = detector_->memory();
  const auto& topology = detector_->topology();
  auto device = detector_->device().name;
  std::lock_guard lock(mutex_);
  shown_.ready = true;
  shown_.device = std::move(device);
  shown_.edges = topology.edges.size();
  shown_.memory = std::move(memory);
}

}  // namespace collided::server
