// The last frames of a scene, as far as a table shows them.

#include "client/cli/live/history.hpp"

#include <algorithm>

#include "client/app/report/frame_line.hpp"

namespace collided::cli {

void History::add(const client::WatchedFrame& frame, const v1::SceneSpec& spec, Clock::time_point now) {
  using Unit = Series::Unit;
  const v1::FrameMetrics& m = frame.done.metrics();
  begin_frame();
  put("total", Unit::kMilliseconds, m.total_milliseconds());
  put("queue", Unit::kMilliseconds, m.queue_milliseconds());
  put("step", Unit::kMilliseconds, m.step_milliseconds());
  const Json stages = stages_json(m);
  for (const auto& [stage, ms] : stages.items())
    if (stage != "total") put("  " + stage, Unit::kMilliseconds, ms.get<double>());
  if (spec.report() != v1::REPORT_ANY_HIT)
    put("contacts", Unit::kCount, static_cast<double>(frame.done.contact_count()));
  put_counts(frame_json(frame.done, spec.report()).at("counts"));
  put("bytes_in", Unit::kBytes, static_cast<double>(m.bytes_in()));
  put("bytes_out", Unit::kBytes, static_cast<double>(m.bytes_out()));
  put("device_bytes", Unit::kBytes, static_cast<double>(m.device_bytes()));
  arrivals_.push_back({now, frame.skipped_frames + 1});
  if (arrivals_.size() > kFrames) arrivals_.pop_front();
  ++frames_;
  skipped_ += frame.skipped_frames;
  last_frame_id_ = frame.frame_id;
  earliest_toi_ = has_times(frame.done, spec) ? std::optional(frame.done.earliest_toi()) : std::nullopt;
  any_contact_ = frame.done.any_contact();
}

// A stage that does not run in a frame takes no time there: its last value is that of the last frame, as of all others.
// One that ran in none of them goes.
void History::begin_frame() {
  for (Series& one : series_) {
    one.values.push_back(0);
    if (one.values.size() > kFrames) one.values.pop_front();
  }
  std::erase_if(series_, [](const Series& one) {
    return one.name.starts_with(' ') && one.values.size() == kFrames &&
           std::ranges::all_of(one.values, [](double value) { return value == 0; });
  });
}

void History::put_counts(const Json& counts) {
  for (const auto& [name, value] : counts.items())
    if (!value.is_null()) put("  " + name, Series::Unit::kCount, value.get<double>());
}

void History::put(const std::string& name, Series::Unit unit, double value) {
  auto found = std::find_if(series_.begin(), series_.end(),
                            [&](const Series& one) { return one.unit == unit && one.name == name; });
  if (found == series_.end()) {
    if (value == 0 && unit == Series::Unit::kCount && name.starts_with(' ')) return;
    // After those of its unit, so that a stage that a later frame needs stands with the others.
    found = std::find_if(series_.rbegin(), series_.rend(), [&](const Series& one) { return one.unit <= unit; }).base();
    found = series_.insert(found, {name, unit, {0}});
  }
  found->values.back() = value;
}

double History::rate() const {
  if (arrivals_.size() < 2) return 0;
  uint64_t frames = 0;
  for (auto at = arrivals_.begin() + 1; at != arrivals_.end(); ++at) frames += at->frames;
  const double seconds = std::chrono::duration<double>(arrivals_.back().time - arrivals_.front().time).count();
  return seconds > 0 ? static_cast<double>(frames) / seconds : 0;
}

}  // namespace collided::cli
