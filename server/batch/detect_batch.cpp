// DetectBatch: frames of sets of worlds and their answers in one message each.
#include "server/batch/detect_batch.hpp"

#include <spdlog/fmt/fmt.h>

#include <atomic>
#include <new>
#include <set>
#include <utility>

#include "proto/constants.hpp"
#include "server/batch/set_answer.hpp"
#include "server/convert/options.hpp"
#include "server/errors.hpp"
#include "server/frames/intake.hpp"
#include "server/frames/log.hpp"
#include "server/frames/messages.hpp"
#include "server/frames/run.hpp"
#include "server/refusals/refuse.hpp"
#include "server/sets/set_frame.hpp"

namespace collided::server {
namespace {

using Call = UnaryCall<pb::DetectBatchRequest, pb::DetectBatchResponse>;

constexpr int kMostFrames = 64;
constexpr uint64_t kFramingBytes = uint64_t{64} << 10;  // of an answer, with its metrics

uint64_t parse_answer_bytes(const pb::DetectBatchRequest& request, uint64_t limit) {
  const uint64_t asked = request.max_answer_bytes();
  if (asked > limit)
    throw LimitExceeded("max_answer_bytes",
                        fmt::format("max_answer_bytes is {}, more than max_message_bytes, {}", asked, limit));
  const uint64_t bytes = asked > 0 ? asked : pb::kMaxAnswerBytes;
  return bytes - std::min(bytes, kFramingBytes);
}

void check_frames(const pb::DetectBatchRequest& request) {
  const int count = request.frames_size();
  if (count == 0 || count > kMostFrames)
    throw_invalid("frames", fmt::format("has {} entries, but must have 1 to {}", count, kMostFrames));
  std::set<std::string> ids;
  for (int i = 0; i < count; ++i)
    if (!ids.insert(request.frames(i).scene_id()).second)
      throw_invalid(fmt::format("frames[{}].scene_id", i), "is that of an earlier frame, but a set has one in a batch");
}

/// A batch until the last of its frames is done.
class Batch {
 public:
  Batch(Call& call, SceneHost& host, std::shared_ptr<void> held)
      : call_(call),
        host_(host),
        held_(std::move(held)),
        bytes_(parse_answer_bytes(call.request(), host.limits().max_message_bytes)),
        left_(call.request().frames_size() + 1) {
    check_frames(call.request());
    for (const pb::SetFrame& frame : call.request().frames()) {
      pb::SetAnswer& answer = *call.response().add_answers();
      answer.set_scene_id(frame.scene_id());
      answer.set_frame_id(frame.frame_id());
    }
  }

  /// Tries all frames; `self` lives until they are done.
  static void start(const std::shared_ptr<Batch>& self) {
    for (int i = 0; i < self->call_.request().frames_size(); ++i) self->admit(self, i);
    self->end_one();
  }

 private:
  /// A frame on its way.
  struct Admitted {
    PendingFrame frame;
    std::vector<uint32_t> worlds;
  };

  void admit(const std::shared_ptr<Batch>& self, int i) {
    const pb::SetFrame& message = call_.request().frames(i);
    SceneUse set;
    try {
      set = find(message, i);
      auto admitted = std::make_shared<Admitted>(take_in(message, *set));
      const auto run = [self, set, admitted, i] { self->run(set, *admitted, i); };
      if (!set->worker().try_post(run))
        throw LimitExceeded::quota(
            "scene:" + set->id(),
            fmt::format("max_window is {}, and as many frames wait for set {}", host_.limits().max_window, set->id()));
    } catch (...) {
      refuse(set, message.frame_id(), i, std::current_exception());
      end_one();
    }
  }
  SceneUse find(const pb::SetFrame& message, int i) {
    SceneUse set = host_.scenes().find(call_.caller().client, message.scene_id());
    if (set->plan()->engine.worlds == 0)
      throw FailedPrecondition(
          fmt::format("frames[{}].scene_id", i),
          fmt::format("frames[{}].scene_id: scene {} is one, and no set of CreateScenes: DetectFrame "
                      "and StreamFrames take its frames",
                      i, set->id()));
    return set;
  }
  Admitted take_in(const pb::SetFrame& message, Scene& set) {
    Admitted admitted;
    PendingFrame& frame = admitted.frame;
    frame.basis.plan = set.plan();
    frame.frame_id = message.frame_id();
    check_frame_id(message.frame_id());
    host_.usage().count_frame(set.identity().owner);
    SetFrameInput parsed = parse_set_frame(message, frame.basis.plan->engine);
    if (parsed.input.accuracy)
      check_max_accuracy(*parsed.input.accuracy, set.identity().owner->limits.max_accuracy, "frame.accuracy");
    send_in_one_piece(set, parsed.input);
    frame.bytes_in = message.positions().size() + message.start_positions().size();
    frame.input = std::move(parsed.input);
    frame.decode_milliseconds = milliseconds_since(frame.arrival);
    admitted.worlds = std::move(parsed.worlds);
    return admitted;
  }

  /// On the set's worker.
  void run(const SceneUse& set, Admitted& admitted, int i) {
    try {
      AnsweredFrame answered = run_frame(*set, admitted.frame, [this] { return call_.is_cancelled(); });
      fill_answer(*set, answered, admitted.worlds, static_cast<size_t>(i), bytes_, call_.response().mutable_answers(i));
      tell_answered(*set, answered, call_.caller().ids);
    } catch (...) {
      refuse(set, admitted.frame.frame_id, i, std::current_exception());
    }
    admitted = {};  // its slot is free before the client has the answer
    end_one();
  }

  /// Other frames of the batch may be running: without the memory to say why one is refused, all end together.
  void refuse(const SceneUse& set, uint64_t frame_id, int i, const std::exception_ptr& error) try {
    if (set) set->observer().refused(*set, frame_id, error);
    pb::SetAnswer& answer = *call_.response().mutable_answers(i);
    answer.clear_contacts();
    answer.clear_errors();
    fill_error(at_frame(describe(error), static_cast<size_t>(i)), answer.mutable_error());
  } catch (const std::bad_alloc&) {
    is_short_ = true;
  }
  void end_one() {
    if (--left_ > 0) return;
    guard(call_, [&] {
      if (is_short_) throw std::bad_alloc();
      call_.finish();
    });
  }

  Call& call_;
  SceneHost& host_;
  const std::shared_ptr<void> held_;
  AnswerBytes bytes_;
  std::atomic<int> left_;
  std::atomic<bool> is_short_ = false;  // of memory
};

}  // namespace

void detect_batch(Call& call, SceneHost& host, const std::shared_ptr<void>& held) {
  Batch::start(std::make_shared<Batch>(call, host, held));
}

}  // namespace collided::server
