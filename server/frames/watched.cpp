// A frame as its scene's watchers see it.
#include "server/frames/watched.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include "server/convert/chunks.hpp"
#include "server/frames/answer.hpp"

namespace collided::server {
namespace {

// Those on the host: of a frame whose contacts stay on the device, what was brought for who watched when it began.
const PerKind<ContactSet>& first_contacts(const FrameResult& result) {
  const bool stay = count_contacts(result) > count_contacts(static_cast<const PerKind<ContactSet>&>(result));
  return stay ? result.first : result;
}

// The rest of the contacts is not copied: a watcher that stops reading must not hold a whole answer's memory.
void fill_first_contacts(const Scene& scene, const FrameResult& result, uint32_t max_of_kind, pb::FrameDone* out) {
  for (Chunk& chunk :
       cut_into_chunks(first_contacts(result), scene.plan()->fields, std::numeric_limits<size_t>::max())) {
    chunk.end = std::min<size_t>(chunk.end, max_of_kind);
    fill_chunk(chunk, scene.engine().topology(), out->add_contacts());
  }
}

std::shared_ptr<const WatchedFrame> show(const Scene& scene, const AnsweredFrame& frame, uint32_t max_of_kind) {
  auto shown =
      std::make_shared<WatchedFrame>(WatchedFrame{frame.frame_id, scene.record().edits(), done_message(frame)});
  if (max_of_kind > 0) fill_first_contacts(scene, frame.result, max_of_kind, &shown->done);
  return shown;
}

}  // namespace

uint32_t most_watched(const SceneWatchers& watchers) {
  uint32_t max_of_kind = 0;
  for (const auto& watcher : watchers.all()) max_of_kind = std::max(max_of_kind, watcher->max_contacts());
  return max_of_kind;
}

void tell_watchers(const Scene& scene, const AnsweredFrame& frame) {
  const auto watchers = scene.record().watchers().all();
  if (watchers.empty()) return;
  try {
    const auto shown = show(scene, frame, most_watched(scene.record().watchers()));
    for (const auto& watcher : watchers) watcher->answered(shown);
  } catch (...) {
    for (const auto& watcher : watchers) watcher->end(std::current_exception());
  }
}

}  // namespace collided::server
