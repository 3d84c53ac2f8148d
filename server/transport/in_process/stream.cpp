// A stream of frames for a caller in this process.
#include "server/transport/in_process/stream.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "proto/constants.hpp"
#include "server/convert/mesh_pairs.hpp"
#include "server/errors.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/decode.hpp"
#include "server/frames/log.hpp"

namespace collided::server {
namespace {

constexpr StreamKind kKind{"stream in process", "InProcessStream"};
constexpr size_t kNoCut = size_t{1} << 31;  // so that a chunk's count fits its field
constexpr uint64_t kAlignment = 64;
constexpr size_t kFewBytes = 64;  // stay in the message

uint64_t aligned(uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

// Each array may begin at the next multiple of the alignment.
uint64_t most_bytes(const Scene& scene) {
  constexpr uint64_t kArrays = 3;  // of an update
  const auto plan = scene.plan();
  return max_position_bytes(plan->engine) + kArrays * kAlignment * plan->meshes.size();
}

uint64_t bytes_of(const std::vector<PlacedPositions>& arrays) {
  uint64_t bytes = 0;
  for (const auto& [start, end, indices] : arrays)
    bytes += aligned(start.size()) + aligned(end.size()) + aligned(indices.size());
  return bytes;
}

/// What the ranges of an answer name.
struct AnswerMemory {
  std::shared_ptr<AnsweredFrame> frame;
  std::deque<MadeArrays> made;
};

void share(const Chunk& chunk, const Topology& topology, AnswerMemory& memory, pb::ContactChunk* out) {
  memory.made.push_back(chunk.make_arrays(topology));
  share_chunk(chunk, memory.made.back(), out, [](std::span<const std::byte> bytes, pb::SharedRange* range) {
    range->set_offset(reinterpret_cast<uintptr_t>(bytes.data()));
    range->set_size(bytes.size());
  });
}

}  // namespace

std::shared_ptr<InProcessStream> InProcessStream::open(const pb::OpenStream& open, const InProcessRules& rules) {
  const std::shared_ptr<InProcessStream> stream(new InProcessStream(rules));
  const Client client = rules.authenticator.identify("", "");
  rules.host.check_serving();
  SceneUse scene = rules.host.scenes().find(client, open.scene_id());
  stream->ticket_ = rules.host.begin_stream(client, *scene, open.resume_token());
  stream->terms_ = parse_open(open, rules.host.limits());
  stream->scene_id_ = scene->id();
  stream->flow_.open(stream->terms_.window);
  stream->begin(
      FrameSession::open(std::move(scene), open.resume_token(), stream->terms_.delivery, stream, stream->ids_));
  rules.host.tell_of_stop(*stream->session_);
  log_stream_opened(kKind, stream->session_->scene(), stream->terms_.window, stream->ids_);
  return stream;
}

// Another stream may have taken the scene over by now.
void InProcessStream::begin(std::shared_ptr<FrameSession> session) {
  const std::lock_guard lock(mutex_);
  session_ = std::move(session);
  if (end_) session_->close();
}

void InProcessStream::await_edit() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !flow_.has_edit() || end_; });
}

// A slot has one room, so that it is as large as it can ever be once the caller writes there itself.
void InProcessStream::take_slot(uint64_t bytes) {
  if (slot_) return;
  slot_ = session_->scene().engine().take_slot();
  used_ = 0;
  room_ = slot_->room(bytes);
}

// Empty if there is not enough left.
std::span<std::byte> InProcessStream::take_room(uint64_t bytes) {
  if (used_ > room_.size() || bytes > room_.size() - used_) return {};
  const auto room = room_.subspan(used_, bytes);
  used_ += aligned(bytes);
  return room;
}

std::span<std::byte> InProcessStream::input(uint64_t bytes) {
  await_edit();
  take_slot(most_bytes(session_->scene()));
  const auto room = take_room(bytes);
  if (room.size() == bytes) return room;
  throw LimitExceeded(
      "input", fmt::format("input of {} bytes was requested, but only {} of the {} for one frame are left", bytes,
                           room_.size() - std::min<uint64_t>(used_, room_.size()), room_.size()));
}

// Where the backend reads the bytes: where they are if that is the slot, else a copy there. What is short, or longer
// than any frame of the scene, goes into the message and is refused there unless an edit makes room for it.
std::span<const std::byte> InProcessStream::place(std::span<const std::byte> bytes, std::string* otherwise) {
  if (bytes.empty()) return {};
  const auto offset = reinterpret_cast<uintptr_t>(bytes.data()) - reinterpret_cast<uintptr_t>(room_.data());
  const bool is_there = offset <= room_.size() && bytes.size() <= room_.size() - offset;
  if (is_there && offset % pb::kRangeAlignment == 0) return bytes;
  const auto room = bytes.size() > kFewBytes ? take_room(bytes.size()) : std::span<std::byte>();
  if (room.empty()) return otherwise->assign(reinterpret_cast<const char*>(bytes.data()), bytes.size()), room;
  std::memcpy(room.data(), bytes.data(), bytes.size());
  return room;
}

void InProcessStream::place(LentFrame& frame, IncomingFrame& incoming) {
  const Scene& scene = session_->scene();
  check_update_count(frame.message, scene.plan()->meshes.size(), "frame");
  const uint64_t bytes = bytes_of(frame.arrays),
                 most = std::max(most_bytes(scene), rules_.host.limits().max_message_bytes);
  if (bytes > most)
    throw LimitExceeded("frame",
                        fmt::format("frame has {} bytes of positions and indices; the limit is {}", bytes, most));
  if (bytes > 0) take_slot(std::min(bytes, most_bytes(scene)));
  for (size_t i = 0; i < frame.arrays.size(); ++i) {
    auto& [start, end, indices] = frame.arrays[i];
    pb::MeshUpdate& update = *frame.message.mutable_updates(static_cast<int>(i));
    start = place(start, update.mutable_start_positions());
    end = place(end, update.mutable_positions());
    if (!indices.empty()) indices = place(indices, update.mutable_sparse()->mutable_indices());
  }
  incoming.placed = std::move(frame.arrays);
}

bool InProcessStream::submit(LentFrame frame) {
  await_edit();
  Scene& scene = session_->scene();
  scene.worker().wake_early();
  IncomingFrame incoming;
  try {
    place(frame, incoming);
  } catch (...) {
    incoming.refusal = std::current_exception();
  }
  incoming.slot = std::exchange(slot_, nullptr);
  room_ = {};
  incoming.message = std::move(frame.message);
  incoming.answer_bytes_per_contact = scene.plan()->fields.made_bytes();
  PendingFrame pending = admit_frame(rules_.host, scene, std::move(incoming));
  {
    const std::lock_guard lock(mutex_);
    if (!flow_.accepts()) return false;
    flow_.submit(pending.frame_id, pending.input.edit != nullptr);
  }
  session_->submit(std::move(pending));
  return true;
}

InProcessStream::Arrival InProcessStream::read(InProcessAnswer& answer, Time deadline) {
  std::unique_lock lock(mutex_);
  const auto has_news = [&] { return end_ || !answers_.empty(); };
  if (deadline == Time::max())
    changed_.wait(lock, has_news);
  else if (!changed_.wait_until(lock, deadline, has_news))
    return Arrival::kNothing;
  if (answers_.empty()) return Arrival::kEnd;
  answer = std::move(answers_.front());
  answers_.pop_front();
  return Arrival::kMessage;
}

void InProcessStream::half_close() {
  const std::lock_guard lock(mutex_);
  flow_.half_close();
  end_if_complete_locked();
}

void InProcessStream::cancel() {
  const std::lock_guard lock(mutex_);
  answers_.clear();
  end_locked({grpc::StatusCode::CANCELLED, "the stream was cancelled"});
}

Failure InProcessStream::end() const {
  const std::lock_guard lock(mutex_);
  return end_.value_or(Failure{});
}

void InProcessStream::opened(const Scene& scene) {
  push({opened_message(scene, terms_.window), {}});
  const std::lock_guard lock(mutex_);
  flow_.opened();
  end_if_complete_locked();
}

void InProcessStream::answered(const Scene& scene, const std::shared_ptr<AnsweredFrame>& frame) {
  for (pb::StreamFramesResponse& errors : world_error_messages(*frame)) push({std::move(errors), {}});
  const auto memory = std::make_shared<AnswerMemory>();
  memory->frame = frame;
  InProcessAnswer answer{{}, memory};
  answer.message.set_frame_id(frame->frame_id);
  pb::FrameDone& done = *answer.message.mutable_done();
  const Topology& topology = scene.engine().topology();
  std::vector<pb::ContactChunk> named, copied;
  encode_contacts(scene, *frame, kNoCut, kMaxChunkBytes,
                  [&](std::span<const Chunk> contacts, std::span<const Chunk> limits) {
                    for (const Chunk& chunk : contacts) share(chunk, topology, *memory, &named.emplace_back());
                    for (const Chunk& chunk : limits) fill_chunk(chunk, topology, &copied.emplace_back());
                  });
  done = done_message(*frame);
  for (pb::ContactChunk& chunk : copied) *done.add_limits() = std::move(chunk);
  if (const ShortenedWays& ways = frame->result.shortened; !ways.ids.empty())
    fill_ways({ways.ids, ways.fractions}, done.mutable_shortened());
  if (const auto& pairs = frame->result.pair_states; !pairs.empty()) fill_pairs(pairs, done.mutable_pairs());
  for (pb::ContactChunk& chunk : named) *done.add_contacts() = std::move(chunk);
  push(std::move(answer), frame->frame_id);
}

void InProcessStream::refused(uint64_t frame_id, const Failure& failure) {
  push({refusal_message(frame_id, failure), {}}, frame_id);
}

void InProcessStream::skipped(uint64_t frame_id) { push({skipped_message(frame_id), {}}, frame_id); }

void InProcessStream::draining(double seconds) { push({draining_message(seconds), {}}); }

void InProcessStream::ended(const std::exception_ptr& why) {
  const std::lock_guard lock(mutex_);
  end_locked(describe(why));
}

void InProcessStream::push(InProcessAnswer answer, std::optional<uint64_t> answered_frame) {
  const std::lock_guard lock(mutex_);
  if (end_) return;
  answers_.push_back(std::move(answer));
  if (answered_frame) {
    flow_.answer(*answered_frame);
    flow_.release();
  }
  end_if_complete_locked();
  changed_.notify_all();
}

void InProcessStream::end_if_complete_locked() {
  if (flow_.is_complete()) end_locked({});
}

void InProcessStream::end_locked(const Failure& why) {
  if (end_) return;
  end_ = why;
  flow_.end();
  ticket_.reset();
  if (session_) session_->close();
  tell_stream_ended(kKind, {.scene = scene_id_, .code = why.code, .reason = why.message}, ids_, rules_.metrics);
  changed_.notify_all();
}

}  // namespace collided::server
