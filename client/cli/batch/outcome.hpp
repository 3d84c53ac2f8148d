#pragma once
// How work on many pairs of frames ends.

#include "client/app/report/json.hpp"
#include "client/app/report/outcome.hpp"

namespace collided::cli {

/// Throws DoneBut if some pairs of the summary have failed; their rows say why.
inline void check_failed_pairs(const Json& summary) {
  const auto failed = summary.at("failed_pairs").get<uint64_t>();
  if (failed > 0)
    throw DoneBut(std::to_string(failed) + (failed == 1 ? " pair has" : " pairs have") +
                  " failed; the table of 'collidectl merge' tells why");
}

}  // namespace collided::cli
