// Limits of a daemon that a load would exceed.

#include "client/measure/load/daemon/limits.hpp"

#include <sys/resource.h>

#include <stdexcept>

#include "client/app/report/numbers.hpp"

namespace collided::cli::load {

namespace {

constexpr rlim_t kOtherFiles = 64;  // besides the connections of streams

}  // namespace

std::vector<TooSmall> limits_in_the_way(const v1::ServerLimits& limits, const StreamSettings& streams) {
  std::vector<TooSmall> found;
  const auto check = [&](const char* option, double value, double needed) {
    if (value < needed) found.push_back({option, value, needed});
  };
  check("--max-scenes", limits.max_scenes(), streams.count());
  check("--max-scenes-per-client", limits.max_scenes_per_client(), streams.count());
  check("--max-streams", limits.max_streams(), streams.count());
  check("--max-streams-per-client", limits.max_streams_per_client(), streams.count());
  check("--max-window", limits.max_window(), streams.window);
  return found;
}

std::string explain(const std::vector<TooSmall>& limits) {
  std::string is, needs;
  for (const TooSmall& limit : limits) {
    is += (is.empty() ? "" : ", ") + limit.option + " " + format_double("%.10g", limit.value);
    needs += " " + limit.option + " " + format_double("%.10g", limit.needed);
  }
  return "the daemon's limits are too low for this load: " + is + "; start it with" + needs +
         ", or ask for fewer --clients, --scenes or a smaller --window";
}

std::string rate_warning(const v1::ServerLimits& limits, double frames_per_second) {
  if (frames_per_second <= limits.max_frames_per_second()) return "";
  return format_double("%.10g", frames_per_second) + " frames a second are more than the daemon takes of one client (" +
         format_double("%.10g", limits.max_frames_per_second()) +
         "): it will refuse the rest; --max-frames-per-second of the daemon raises that";
}

void allow_connections(uint32_t connections) {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  const rlim_t needed = connections + kOtherFiles;
  if (files.rlim_max < needed)
    throw std::runtime_error(std::to_string(connections) + " connections need " + std::to_string(needed) +
                             " open files, and this process may have " + std::to_string(files.rlim_max) +
                             " (ulimit -Hn): raise that, or use --shared-connections");
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
}

}  // namespace collided::cli::load
