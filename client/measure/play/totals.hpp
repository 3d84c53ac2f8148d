#pragma once
// What the frames of a stream found and cost in all.

#include <optional>
#include <vector>

#include "client/app/report/digest.hpp"
#include "client/app/report/json.hpp"

namespace collided::cli {

/// Sums over the frames. Contacts are counted and dropped, except the earliest.
class Totals {
 public:
  explicit Totals(v1::Report report) : report_(report) {}

  /// Throws Error if the frame was refused.
  void add(client::FrameOutput output);
  bool is_empty() const { return metrics_.empty(); }
  size_t frames() const { return metrics_.size(); }
  /// Contacts and a digest of all their fields, medians of times, the last frame's counts, bytes and warnings. There
  /// must be a frame.
  Json json() const;

 private:
  void keep_earliest(const client::FrameOutput& output);
  Json contacts_json() const;
  Json times_json() const;

  v1::Report report_;
  std::vector<v1::FrameMetrics> metrics_;
  uint64_t contacts_ = 0;
  ContactsDigest digest_;
  client::PerKind<uint64_t> of_kind_;
  uint64_t bytes_in_ = 0, bytes_out_ = 0, replays_ = 0;
  bool any_contact_ = false;
  std::optional<double> least_advanced_;
  std::optional<Json> earliest_;
};

}  // namespace collided::cli
