#pragma once
// How work on many pairs of frames ends.

#include <stdexcept>

#include "client/app/report/json.hpp"

namespace collided::cli {

/// Done, but some pairs have failed; their rows say why. Exit code 3.
struct PairsFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws PairsFailed if the summary has some.
inline void check_failed_pairs(const Json& summary) {
  const auto failed = summary.at("failed_pairs").get<uint64_t>();
  if (failed > 0)
    throw PairsFailed(std::to_string(failed) + (failed == 1 ? " pair has" : " pairs have") +
                      " failed; the table of 'collidectl merge' tells why");
}

}  // namespace collided::cli
