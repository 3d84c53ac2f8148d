// How many frames a second are due, over time.

#include "client/measure/load/pace/profile.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include "client/app/options/usage_error.hpp"

namespace collided::cli::load {

namespace {

constexpr double kMaxRate = 1e6, kMaxSeconds = 1e6;

double frames_of(const Stretch& stretch) { return (stretch.from + stretch.to) / 2 * stretch.seconds; }

/// The time within the stretch at which `frames` are due: the root of from t + (to - from) / (2 seconds) t^2, in the
/// form that is exact for a constant rate and for one that begins at 0.
double time_within(const Stretch& stretch, double frames) {
  const double change = (stretch.to - stretch.from) / stretch.seconds;
  const double root = std::sqrt(std::max(0.0, stretch.from * stretch.from + 2 * change * frames));
  return frames > 0 ? 2 * frames / (stretch.from + root) : 0;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

bool read_number(const std::string& word, double max, double& out) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc{} && end == word.data() + word.size() && out >= 0 && out <= max;
}

}  // namespace

std::vector<Stretch> parse_ramp(const std::string& option, const std::string& text) {
  std::vector<Stretch> stretches;
  for (const std::string& ramp : split(text, ',')) {
    const std::vector<std::string> words = split(ramp, ':');
    Stretch stretch;
    const bool is_read = words.size() == 3 && read_number(words[0], kMaxRate, stretch.from) &&
                         read_number(words[1], kMaxRate, stretch.to) &&
                         read_number(words[2], kMaxSeconds, stretch.seconds);
    if (!is_read || stretch.seconds == 0 || stretch.from + stretch.to == 0)
      throw UsageError(option + ": '" + ramp + "' is not FROM:TO:SECONDS, such as 10:60:30 (frames a second, seconds)");
    stretches.push_back(stretch);
  }
  if (stretches.empty()) throw UsageError(option + " is empty; it takes FROM:TO:SECONDS, such as 10:60:30");
  return stretches;
}

RateProfile::RateProfile(std::vector<Stretch> stretches) : stretches_(std::move(stretches)) {
  for (const Stretch& stretch : stretches_) {
    seconds_ += stretch.seconds;
    frames_ += frames_of(stretch);
  }
}

double RateProfile::max_rate() const {
  double rate = 0;
  for (const Stretch& stretch : stretches_) rate = std::max({rate, stretch.from, stretch.to});
  return rate;
}

double RateProfile::time_of(double frames) const {
  double begin = 0;
  for (const Stretch& stretch : stretches_) {
    const double own = frames_of(stretch);
    if (frames < own) return begin + time_within(stretch, frames);
    frames -= own;
    begin += stretch.seconds;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace collided::cli::load
