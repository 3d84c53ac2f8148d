// What the frames of a stream found and cost in all.

#include "client/measure/play/totals.hpp"

#include <algorithm>
#include <utility>

#include "client/app/report/contacts.hpp"
#include "client/measure/stage_medians.hpp"
#include "client/measure/statistics.hpp"

namespace collided::cli {

void Totals::add(client::FrameOutput output) {
  output.check();
  const v1::FrameMetrics& m = output.done.metrics();
  contacts_ += output.done.contact_count();
  for_each_kind([](v1::ContactKind, uint64_t& sum, const client::Contacts& found) { sum += found.count; }, of_kind_,
                output);
  digest_.add(output);
  any_contact_ |= output.done.any_contact();
  bytes_in_ += m.bytes_in();
  bytes_out_ += m.bytes_out();
  replays_ += m.replays();
  if (output.done.has_advanced()) least_advanced_ = std::min(least_advanced_.value_or(1), output.done.advanced());
  keep_earliest(output);
  metrics_.push_back(std::move(*output.done.mutable_metrics()));
}

void Totals::keep_earliest(const client::FrameOutput& output) {
  const auto contact = earliest_contact(output);
  if (!contact || (earliest_ && earliest_->at("toi") <= contact->at("toi"))) return;
  earliest_ = Json{{"frame", output.frame_id}};
  earliest_->update(*contact);
}

Json Totals::contacts_json() const {
  if (report_ == v1::REPORT_ANY_HIT) return {{"contact_count", nullptr}, {"any_contact", any_contact_}};
  Json out = {{"contact_count", contacts_}};
  out.update(contact_counts_json(of_kind_));
  out["any_contact"] = any_contact_;
  out["contacts_digest"] = digest_.text();
  if (least_advanced_) out["least_advanced"] = *least_advanced_;
  if (earliest_) out["earliest"] = *earliest_;
  return out;
}

/// Medians over the frames.
Json Totals::times_json() const {
  const auto median_of = [&](double (v1::FrameMetrics::*time)() const) {
    std::vector<double> ms;
    for (const v1::FrameMetrics& frame : metrics_) ms.push_back((frame.*time)());
    return median(std::move(ms));
  };
  Json stages = median_stages(metrics_);
  stages.erase("total");
  return {{"total_ms", median_of(&v1::FrameMetrics::total_milliseconds)},
          {"queue_ms", median_of(&v1::FrameMetrics::queue_milliseconds)},
          {"step_ms", median_of(&v1::FrameMetrics::step_milliseconds)},
          {"stage_ms", stages}};
}

Json Totals::json() const {
  const v1::FrameMetrics& last = metrics_.back();
  Json counts = counts_json(last.counts());
  if (report_ == v1::REPORT_ANY_HIT) clear_contact_counts(counts);
  Json out = contacts_json();
  out["median"] = times_json();
  out["last_frame"] = {{"counts", counts}, {"device_bytes", last.device_bytes()}};
  out["replays"] = replays_;
  out["bytes_in"] = bytes_in_;
  out["bytes_out"] = bytes_out_;
  out["warnings"] = warnings_json(metrics_);
  return out;
}

}  // namespace collided::cli
