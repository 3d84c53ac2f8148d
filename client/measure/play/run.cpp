// Plays frames and reports what they found and cost.

#include "client/measure/play/run.hpp"

#include <chrono>
#include <exception>
#include <utility>

#include "client/app/output/output.hpp"
#include "client/app/report/text.hpp"
#include "client/measure/play/frame_lines.hpp"
#include "client/measure/play/totals.hpp"

namespace collided::cli {

namespace {

/// Seconds of the frames; `failure` takes what ended them early.
double timed_play(client::FrameStream& stream, const FrameSource& source,
                  const std::function<void(client::FrameOutput)>& take, std::exception_ptr& failure) {
  const auto start = std::chrono::steady_clock::now();
  try {
    play(stream, source, take);
  } catch (const std::exception&) {
    failure = std::current_exception();
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

void play_and_report(client::FrameStream& stream, const v1::Scene& scene, FrameSource source,
                     const PlayOptions& options) {
  FrameLines lines({.spec = scene.spec(), .frames = source.frames, .files = options.files, .json = options.json});
  Totals totals(scene.spec().report());
  source.is_quiet = options.has_lines && lines.show_progress();
  std::exception_ptr failure;
  const auto take = [&](client::FrameOutput output) {
    if (options.take && !output.error) options.take(output);
    if (options.has_lines) lines.add(output);
    totals.add(std::move(output));
  };
  const double seconds = timed_play(stream, source, take, failure);
  if (!totals.is_empty()) {
    Json summary = options.input;
    summary.update(Json{{"scene", scene_json(scene)}, {"frames", totals.frames()}, {"seconds", seconds}});
    summary.update(totals.json());
    summary.update(transport_json(stream));
    if (options.has_lines && options.json) summary["per_frame"] = lines.json();
    print_summary(options.out, options.json ? json_text(summary) + "\n" : report_text(summary));
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace collided::cli
