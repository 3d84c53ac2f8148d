#pragma once
// What 'collidectl bench' measures, and on which daemon.

#include <string>

#include "client/app/options/values.hpp"

namespace collided::cli {

struct BenchSettings {
  ServerOptions server;
  DetectionOptions detection;
  std::string position_format = "f32";
  int steps = 50;
  int warm_up = 10;  ///< steps before the measured ones
};

}  // namespace collided::cli
