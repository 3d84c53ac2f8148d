// Frames between the protocol and the engine.
#include "server/convert/frame.hpp"

#include "server/convert/kinds.hpp"
#include "server/convert/options.hpp"
#include "server/refusals/field_path.hpp"
#include "server/refusals/refuse.hpp"

namespace collided::server {
namespace {

std::span<const std::byte> either(std::span<const std::byte> placed, const std::string& bytes) {
  return placed.empty() ? std::as_bytes(std::span(bytes)) : placed;
}

void check_update(const pb::MeshUpdate& update, int index) {
  const auto path = [&](const char* field) { return fmt::format("frame.updates[{}].{}", index, field); };
  if (update.has_rigid() && update.rigid().matrix().empty())
    throw_invalid(path("rigid.matrix"), "is empty, but must have the 12 numbers of [R | t]");
  const char* why = "is set, but there is no shared memory on this stream";
  if (update.has_shared_positions()) throw_invalid(path("shared_positions"), why);
  if (update.has_shared_start_positions()) throw_invalid(path("shared_start_positions"), why);
  if (update.sparse().has_shared_indices()) throw_invalid(path("sparse.shared_indices"), why);
}

MeshPositions parse_update(const pb::MeshUpdate& update, const PlacedPositions& placed) {
  MeshPositions positions;
  positions.mesh = update.mesh();
  positions.start = either(placed.start, update.start_positions());
  positions.end = either(placed.end, update.positions());
  positions.is_sparse = update.has_sparse();
  positions.indices = either(placed.indices, update.sparse().indices());
  positions.transform = std::as_bytes(std::span(update.rigid().matrix()));
  positions.start_transform = std::as_bytes(std::span(update.rigid().start_matrix()));
  return positions;
}

AdvanceMode advance_mode_of(const pb::Frame& frame) {
  constexpr auto kField = "frame.advance_mode";
  const AdvanceMode mode = parse<AdvanceMode>(frame.advance_mode(), kField).value_or(AdvanceMode::kAllOrOne);
  if (frame.advance_mode() != pb::ADVANCE_MODE_UNSPECIFIED && !frame.advance())
    throw_invalid(kField, fmt::format("is {}, but frame.advance is false", pb::AdvanceMode_Name(frame.advance_mode())));
  return mode;
}

void fill_counts(const FrameCounts& counts, pb::FrameCounts* out) {
  out->set_cells(counts.cells);
  out->set_leaves(counts.leaves);
  out->set_top_level(counts.top_level);
  out->set_base_level(counts.base_level);
  out->set_registrations(counts.registrations);
  out->set_tests(counts.tests);
  out->set_pairs(counts.pairs);
  fill_counts_of_kinds(counts, out);
  out->set_exact_decisions(counts.exact_decisions);
  out->set_inside_out(counts.inside_out);
}

}  // namespace

FrameInput parse_frame(const pb::Frame& frame, std::span<const PlacedPositions> placed, const SceneSpec& scene) {
  FrameInput input;
  if (frame.mode() != pb::DETECTION_MODE_UNSPECIFIED) input.mode = parse_mode(frame.mode(), "frame.mode");
  input.accuracy = parse<Accuracy>(frame.accuracy(), "frame.accuracy");
  if (frame.has_delta()) input.delta = frame.delta();
  input.report = parse<Report>(frame.report(), "frame.report");
  input.ignore_separating = frame.ignore_separating();
  input.advance = frame.advance();
  input.advance_mode = advance_mode_of(frame);
  input.limits = frame.limits();
  input.trial = frame.trial();
  if (frame.has_from_last_fraction()) input.start_fraction = frame.from_last_fraction();
  check_frame_options(scene, input);
  for (int i = 0; i < frame.updates_size(); ++i) {
    check_update(frame.updates(i), i);
    const auto index = static_cast<size_t>(i);
    input.updates.push_back(parse_update(frame.updates(i), index < placed.size() ? placed[index] : PlacedPositions{}));
  }
  return input;
}

namespace {

void fill_reuse(const ReuseFacts& reuse, pb::FrameMetrics* out) {
  out->set_list_use(to_message(reuse.use));
  out->set_reuse_reason(to_message(reuse.reason));
  out->set_list_margin(reuse.margin);
  out->set_list_frames(reuse.frames);
  out->set_list_milliseconds(reuse.list_milliseconds);
  out->set_search_milliseconds(reuse.search_milliseconds);
}

void fill_shard(const ShardFacts& shard, pb::PartMetrics* out) {
  out->set_share(shard.share);
  out->set_step_milliseconds(shard.step_milliseconds);
  out->set_pairs(shard.pairs);
  out->set_contacts(shard.contacts);
}

}  // namespace

void fill_result(const FrameResult& result, pb::FrameDone* out) {
  auto* metrics = out->mutable_metrics();
  for (const auto& stage : result.stages) {
    auto* added = metrics->add_stages();
    added->set_stage(stage.stage);
    added->set_milliseconds(stage.milliseconds);
  }
  fill_counts(result.counts, metrics->mutable_counts());
  metrics->set_replays(result.replays);
  metrics->set_allocations(result.allocations);
  metrics->set_graph_launches(result.graph_launches);
  metrics->set_step_milliseconds(result.step_milliseconds);
  metrics->set_broad_phase_engine(to_message(result.broad_phase.engine));
  metrics->set_broad_phase_reason(to_message(result.broad_phase.reason));
  metrics->set_octree_milliseconds(result.broad_phase.octree_milliseconds);
  metrics->set_lbvh_milliseconds(result.broad_phase.lbvh_milliseconds);
  metrics->set_all_pairs_milliseconds(result.broad_phase.all_pairs_milliseconds);
  fill_reuse(result.reuse, metrics);
  for (const ShardFacts& shard : result.shards) fill_shard(shard, metrics->add_parts());
  for (const std::string& option : result.unused_options) metrics->add_unused_options(spec_path(option));
  if (result.input_resolution) metrics->add_warnings(pb::FRAME_WARNING_INPUT_RESOLUTION);
  out->set_contact_count(count_contacts(result));
  out->set_earliest_toi(result.earliest_toi);
  out->set_any_contact(result.any_contact);
  if (!result.advanced) return;
  out->set_advanced(*result.advanced);
  out->set_way(result.way);
}

}  // namespace collided::server
