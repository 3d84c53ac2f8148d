// DetectFrame: a frame and its answer in one message each.
#include "server/transport/grpc/detect_frame.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "proto/constants.hpp"
#include "server/convert/mesh_pairs.hpp"
#include "server/errors.hpp"
#include "server/frames/answer.hpp"
#include "server/frames/intake.hpp"
#include "server/frames/log.hpp"
#include "server/frames/run.hpp"

namespace collided::server {
namespace {

using Call = UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>;

constexpr size_t kMaxArrayBytes = pb::kMaxAnswerBytes - (size_t{64} << 10);  // leaves room for framing and metrics

void check_no_stream(const Scene& scene) {
  if (scene.record().stream())
    throw FailedPrecondition(
        "scene_id", fmt::format("scene_id: scene {} has an open stream, which alone may send its frames", scene.id()));
}

void check_size(const AnsweredFrame& frame) {
  if (frame.cost.bytes_out <= kMaxArrayBytes) return;
  throw LimitExceeded(
      "frame",
      fmt::format("frame {} was applied, but its contacts, pairs of meshes, limits and shortened ways "
                  "take {} bytes, and one answer holds at most {}; use StreamFrames, which sends them in chunks",
                  frame.frame_id, frame.cost.bytes_out, kMaxArrayBytes));
}

void fill_answer(const Scene& scene, AnsweredFrame& frame, pb::DetectFrameResponse& response) {
  const Topology& topology = scene.engine().topology();
  pb::FrameDone last;
  encode_contacts(scene, frame, kMaxChunkBytes, kMaxChunkBytes,
                  [&](std::span<const Chunk> contacts, std::span<const Chunk> limits) {
                    check_size(frame);
                    for (const Chunk& chunk : contacts) fill_chunk(chunk, topology, response.add_contacts());
                    for (const Chunk& chunk : limits) fill_chunk(chunk, topology, last.add_limits());
                  });
  *response.mutable_done() = done_message(frame);
  response.mutable_done()->mutable_limits()->Swap(last.mutable_limits());
  if (const ShortenedWays& ways = frame.result.shortened; !ways.ids.empty())
    fill_ways({ways.ids, ways.fractions}, response.mutable_done()->mutable_shortened());
  if (const auto& pairs = frame.result.pair_states; !pairs.empty())
    fill_pairs(pairs, response.mutable_done()->mutable_pairs());
}

// On the scene's worker thread. A refusal is counted and logged with the call, but that of a frame that was given up.
void answer(Call& call, Scene& scene, PendingFrame& frame) {
  guard(call, [&] {
    bool has_run = false;
    try {
      check_no_stream(scene);
      auto answered = run_frame(scene, frame, [&call] { return call.is_cancelled(); });
      has_run = true;
      fill_answer(scene, answered, call.response());
      tell_answered(scene, answered, call.caller().ids);
      call.finish();
    } catch (...) {
      const auto why = std::current_exception();
      if (call.is_cancelled()) scene.observer().refused(scene, frame.frame_id, why);
      std::rethrow_exception(has_run ? unanswered(frame.frame_id, frame.input.trial, why) : why);
    }
  });
}

}  // namespace

void detect_frame(Call& call, SceneHost& host, const std::shared_ptr<void>& held) {
  const SceneUse scene = host.scenes().find(call.caller().client, call.request().scene_id());
  scene->record().check_is_one("scene_id");
  IncomingFrame incoming;
  incoming.message = std::move(*call.request().mutable_frame());
  auto frame = std::make_shared<PendingFrame>(admit_frame(host, *scene, std::move(incoming)));
  if (!scene->worker().try_post([&call, scene, frame, held] { answer(call, *scene, *frame); }))
    throw LimitExceeded::quota(
        "scene:" + scene->id(),
        fmt::format("max_window is {}, and as many frames wait for scene {}", host.limits().max_window, scene->id()));
}

}  // namespace collided::server
