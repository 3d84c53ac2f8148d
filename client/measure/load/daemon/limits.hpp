#pragma once
// Limits of a daemon that a load would exceed: they are named before anything is sent.

#include <string>
#include <vector>

#include "client/measure/load/settings.hpp"
#include "collided/v1/collision_service.pb.h"

namespace collided::cli::load {

/// A limit that is too small: the daemon's option, its value, and the value that is needed.
struct TooSmall {
  std::string option;
  double value = 0, needed = 0;
};

/// Limits without which the streams cannot be opened.
std::vector<TooSmall> limits_in_the_way(const v1::ServerLimits& limits, const StreamSettings& streams);
/// What is too small and what to do about it, in one line.
std::string explain(const std::vector<TooSmall>& limits);
/// Whether so many frames a second would be refused in part: what to tell; else empty.
std::string rate_warning(const v1::ServerLimits& limits, double frames_per_second);

/// Raises the soft limit of open files to the hard one. Throws std::runtime_error if that is below what so many
/// connections need.
void allow_connections(uint32_t connections);

}  // namespace collided::cli::load
