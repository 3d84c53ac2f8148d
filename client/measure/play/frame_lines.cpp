// What each frame of a stream found: a line each on standard output, or an array of objects.

#include "client/measure/play/frame_lines.hpp"

#include <unistd.h>

#include "client/app/output/output.hpp"
#include "client/app/report/digest.hpp"
#include "client/app/report/frame_line.hpp"

namespace collided::cli {

void FrameLines::add(const client::FrameOutput& output) {
  output.check();
  const auto index = static_cast<size_t>(shown_++);
  const std::string file = index < options_.files.size() ? options_.files[index] : "";
  if (!options_.json) {
    print_line("frame " + std::to_string(shown_) + " of " + std::to_string(options_.frames) +
               (file.empty() ? "" : ", " + file) + ": " + frame_text(output.done, options_.spec) +
               advance_text(output));
    return;
  }
  Json frame = {{"frame", output.frame_id}};
  if (!file.empty()) frame["file"] = file;
  frame.update(frame_result_json(output.done, options_.spec));
  frame.update(advance_json(output));
  if (options_.spec.report() != v1::REPORT_ANY_HIT) frame["contacts_digest"] = digest_of(output);
  frames_.push_back(std::move(frame));
}

bool FrameLines::show_progress() const { return !options_.json && isatty(STDOUT_FILENO) != 0; }

}  // namespace collided::cli
