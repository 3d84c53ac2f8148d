// One stream of frames to one scene.
#include "server/frames/session.hpp"

#include <algorithm>
#include <ranges>
#include <utility>
#include <vector>

#include "server/errors.hpp"
#include "server/frames/log.hpp"

namespace collided::server {
namespace {

// Whether nobody misses what `older` does to a mesh. A transform does not take the place of the positions it moves.
bool covers(const UpdatedMesh& latest, const UpdatedMesh& older) {
  return latest.mesh == older.mesh && latest.is_whole && (latest.has_positions || !older.has_positions);
}

// Whether nobody misses what `older` does to the scene: `latest` has whole positions for every mesh that it updates.
bool covers(const PendingFrame& latest, const PendingFrame& older) {
  const bool is_lost = latest.input.trial && !older.input.trial;
  if (older.input.edit || latest.input.edit || latest.worlds != older.worlds) return false;
  if (is_lost || latest.input.start_fraction) return false;  // which begins on the way of the frame before it
  return std::ranges::all_of(older.meshes, [&](const UpdatedMesh& old) {
    return std::ranges::any_of(latest.meshes, [&](const UpdatedMesh& mesh) { return covers(mesh, old); });
  });
}

// Whether the answer to `waiting` depends on what frames before it do to what `latest` covers: not if they are about
// different worlds of a set.
bool depends_on_earlier(const PendingFrame& waiting, const PendingFrame& latest) {
  if (waiting.input.edit || waiting.worlds.empty() || latest.worlds.empty()) return true;
  std::vector<bool> is_covered(kMaxWorlds);
  for (const uint32_t world : latest.worlds) is_covered[world] = true;
  return std::ranges::any_of(waiting.worlds, [&](uint32_t world) { return is_covered[world]; });
}

// Whether no later frame of the stream can be answered either.
bool is_fatal(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const NotFound&) {
    return true;
  } catch (const DeviceError&) {
    return true;
  } catch (const Cancelled&) {
    return true;
  } catch (...) {
    return false;
  }
}

}  // namespace

std::shared_ptr<FrameSession> FrameSession::open(SceneUse scene, const std::string& resume_token, Delivery delivery,
                                                 std::shared_ptr<FrameSink> sink, CallIds ids) {
  std::shared_ptr<FrameSession> session(new FrameSession(std::move(scene), delivery, std::move(sink), std::move(ids)));
  const auto before = session->scene().begin_stream(session, resume_token);
  if (before)
    before->end(std::make_exception_ptr(
        TakenOver("open.scene_id", "open.scene_id: another stream took over scene " + session->scene().id())));
  if (!resume_token.empty()) session->scene().observer().counted(session->scene(), CounterId::kReconnects, 1);
  session->post([own = session.get()] {
    if (const auto sink = own->sink()) sink->opened(own->scene());
  });
  return session;
}

// On the scene's thread. What fails there ends this stream only.
void FrameSession::post(std::function<void()> job) {
  scene_->worker().post([self = shared_from_this(), job = std::move(job)] {
    try {
      job();
    } catch (...) {
      self->end(std::current_exception());
    }
  });
}

void FrameSession::submit(PendingFrame frame) {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  if (delivery_ == Delivery::kLatestWins && !frame.refusal) skip_older_locked(frame);
  waiting_.push_back({std::move(frame)});
  start_next_locked();
}

// A frame that is already refused stays, so that its error is reported; so do all of a scene that has yet to see where
// its meshes rest, and what a frame between them and the latest begins at.
void FrameSession::skip_older_locked(const PendingFrame& latest) {
  if (scene_->record().awaits_rest()) return;
  for (Waiting& older : waiting_ | std::views::reverse) {
    if (older.is_skipped || older.frame.refusal) continue;
    if (!covers(latest, older.frame)) {
      if (depends_on_earlier(older.frame, latest)) return;
      continue;
    }
    older.is_skipped = true;
    older.frame.input = {};
    older.frame.memory.reset();
  }
}

void FrameSession::start_next_locked() {
  last_active_ = scene_->now();
  if (is_working_ || is_held_ || waiting_.empty()) return;
  is_working_ = true;
  post([this] { work(); });
}

// One frame per job, so that the scene's other work can run in between.
void FrameSession::work() {
  Waiting next;
  std::shared_ptr<FrameSink> sink;
  {
    const std::lock_guard lock(mutex_);
    is_working_ = false;
    if (is_held_ || waiting_.empty()) return;
    is_working_ = true;
    next = std::move(waiting_.front());
    waiting_.pop_front();
    sink = sink_;
  }
  if (sink) run(next, *sink);
  const std::lock_guard lock(mutex_);
  is_working_ = false;
  start_next_locked();
}

void FrameSession::run(Waiting& next, FrameSink& sink) {
  PendingFrame& frame = next.frame;
  if (next.is_skipped) {
    tell_skipped(*scene_, frame.frame_id, ids_);
    return sink.skipped(frame.frame_id);
  }
  std::shared_ptr<AnsweredFrame> answered;
  try {
    answered = std::make_shared<AnsweredFrame>();  // before the scene changes
    *answered = run_frame(*scene_, frame, [this] { return closed_.load(); });
  } catch (...) {
    return fail(frame.frame_id, std::current_exception(), sink);
  }
  answer(answered, frame.input.trial, sink);
}

// A frame that was applied must not be refused: without its answer the stream ends, and resumes after the frame.
void FrameSession::answer(const std::shared_ptr<AnsweredFrame>& answered, bool is_trial, FrameSink& sink) {
  try {
    sink.answered(*scene_, answered);
    tell_answered(*scene_, *answered, ids_);
  } catch (...) {
    end(unanswered(answered->frame_id, is_trial, std::current_exception()));
  }
}

void FrameSession::fail(uint64_t frame_id, const std::exception_ptr& error, FrameSink& sink) {
  if (closed_) return;
  if (!is_fatal(error)) return sink.refused(frame_id, tell_refused(*scene_, frame_id, error, ids_));
  scene_->observer().refused(*scene_, frame_id, error);
  end(error);
}

void FrameSession::hold(bool is_held) {
  const std::lock_guard lock(mutex_);
  is_held_ = is_held;
  last_active_ = scene_->now();
  if (!is_held && !closed_) start_next_locked();
}

void FrameSession::close() {
  std::list<Waiting> dropped;
  std::shared_ptr<FrameSink> sink;
  SceneUse use;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    use = std::move(use_);
    dropped.swap(waiting_);
    sink.swap(sink_);
  }
  scene_->record().end_stream(*this);
}

void FrameSession::end(const std::exception_ptr& why) {
  const auto last = sink();
  close();
  if (last) last->ended(why);
}

void FrameSession::announce_stop(double seconds) {
  if (knows_of_stop_.exchange(true)) return;
  post([this, seconds] {
    if (const auto open = sink()) open->draining(seconds);
  });
}

std::shared_ptr<FrameSink> FrameSession::sink() const {
  const std::lock_guard lock(mutex_);
  return sink_;
}

double FrameSession::idle_seconds() const {
  const std::lock_guard lock(mutex_);
  if (is_working_ || (!waiting_.empty() && !is_held_)) return 0;
  return seconds_between(last_active_, scene_->now());
}

size_t FrameSession::waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size();
}

}  // namespace collided::server
