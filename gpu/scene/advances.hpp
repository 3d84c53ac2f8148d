#pragma once
// Frames that go as far as they can. The frame's own step has told the contacts of the whole way. Then the scene goes
// towards the frame's positions. Each group of vertices goes as far as all pairs keep their floors
// (step/shorten_phase.hpp).

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gpu/base/groups.hpp"
#include "gpu/scene/resident_positions.hpp"
#include "gpu/scene/scene_model.hpp"
#include "gpu/scene/shards/meeting.hpp"
#include "gpu/scene/stage_costs.hpp"
#include "gpu/step/pipeline.hpp"

namespace collided {

template <Executor Exec, class Real>
class Advances {
 public:
  /// `shard`: the scene is a shard of another; may be null.
  Advances(Exec& exec, SceneModel<Exec, Real>& model, const ShardOf* shard, ResidentPositions<Exec, Real>& positions,
           Pipeline<Exec, Real>& pipeline)
      : exec_(exec),
        model_(model),
        topology_(model.buffers().topology),
        ways_(model.buffers().ways),
        shard_(shard),
        positions_(positions),
        pipeline_(pipeline) {}

  /// Finds the contacts on the whole way to the frame's positions, then goes as far as the scene can.
  FrameResult detect(bool boxes_static, const FrameInput& frame, const FrameSettings& settings) {
    exec_.stage("advance", [&] {
      require_neighbours();
      require_groups(frame.advance_mode);
      positions_.tell_turns();
    });
    StageRange own_search;
    FrameResult result = find_pairs(boxes_static, frame, settings, own_search);
    if (shard_ != nullptr) join_starts();
    if (frame.limits) result.limits = pipeline_.limits(frame.bytes_beside_contact);
    const WaysGone gone = go(frame.advance_mode);
    tell_shortened(frame.advance_mode, result.shortened);
    result.advanced = detail::bit_copy<double>(gone.least_bits);
    const double share = gone.all > 0 ? static_cast<double>(gone.gone) / static_cast<double>(gone.all) : 0;
    result.way = max(share, *result.advanced);  // whole units are a little less than what is gone
    add_costs(own_search, result);
    return result;
  }

 private:
  const SceneShape& shape() const { return model_.shape(); }
  uint32_t vertices() const { return shape().vertex_offset.back(); }

  /// Stages [first, end) of a frame.
  struct StageRange {
    size_t first = 0, end = 0;
  };
  /// Finds the frame's contacts and judges the pairs that may block ways. `own_search`: the stages of a search for the
  /// latter alone, if there is one.
  FrameResult find_pairs(bool boxes_static, const FrameInput& frame, const FrameSettings& settings,
                         StageRange& own_search) {
    if (!model_.spec().kinds.triangle_triangle)
      return by_rules([&](const WayRules& rules) {
        return pipeline_.detect_blocking(boxes_static, settings, frame.bytes_beside_contact, frame.room, rules);
      });
    FrameResult result = pipeline_.detect_contacts(boxes_static, settings, frame.bytes_beside_contact, frame.room);
    const FrameResult found = by_rules([&](const WayRules& rules) { return pipeline_.find_blocking(rules); });
    own_search = {result.stages.size(), found.stages.size()};
    result.replays += found.replays;
    return result;
  }
  /// Searches by the rules that follow from how far vertices go, which the step measures itself. It begins with the
  /// last frame's measure, and searches again in the rare case that its own gives other rules. A guess that could make
  /// it search more than twice as far as it must is not used.
  template <class Search>
  FrameResult by_rules(const Search& search) {
    const double most = 2 * model_.spec().min_separation;
    if (!measured_ || rules(*measured_).reach() > most) measured_ = pipeline_.measure_ways();
    const WayRules guess = rules(*measured_);
    std::optional<FrameResult> result;
    try {
      result = search(guess);
      measured_ = pipeline_.found().ways;
    } catch (const ResourceExhausted&) {
      measured_ = pipeline_.measure_ways();
      if (rules(*measured_) == guess) throw;
    }
    if (rules(*measured_) == guess) return std::move(*result);
    const uint32_t replays = result ? result->replays + 1 : 1;
    result = search(rules(*measured_));
    result->replays += replays;
    return std::move(*result);
  }

  void require_neighbours() {
    if (topology_.neighbour_begin.capacity() > 0) return;
    MemoryHold making(model_.spec().memory_quota);
    const RingTables neighbours = make_neighbours(model_.topology(), making);
    upload(topology_.neighbours, neighbours.vertices);
    upload(topology_.neighbour_begin, neighbours.begin);  // the last one: now all are there
    exec_.wait();
  }
  void require_groups(AdvanceMode mode) {
    if (topology_.group_of.capacity() > 0 && topology_.groups_are_of == mode) return;
    MemoryHold making(model_.spec().memory_quota);
    making.resize(vertices() * sizeof(uint32_t));
    std::vector<uint32_t> groups(vertices());
    for (uint32_t mesh = 0; mesh < shape().meshes(); ++mesh)
      for (uint32_t v = shape().vertex_offset[mesh]; v < shape().vertex_offset[mesh + 1]; ++v)
        groups[v] = group_of(mode, mesh, v);
    upload(topology_.group_of, groups);
    exec_.wait();
    topology_.groups_are_of = mode;
  }
  uint32_t group_of(AdvanceMode mode, uint32_t mesh, uint32_t vertex) const {
    const MeshMotion motion = shape().mesh(mesh).motion;
    if (motion == MeshMotion::kStatic) return kStands;
    if (mode == AdvanceMode::kAllOrOne) return 0;
    return mode == AdvanceMode::kPerMesh || motion == MeshMotion::kRigid ? shape().vertex_offset[mesh] : vertex;
  }
  void upload(Buffer<uint32_t, Exec>& to, const std::vector<uint32_t>& from) {
    to.allocate(from.size());
    exec_.upload(to.data(), from.data(), from.size() * sizeof(uint32_t));
  }

  WayRules rules(const WaysMeasure& measured) const {
    const Vec3<float> extent = measured.start.hi - measured.start.lo;
    return {FloorRules::of(model_.spec().min_separation, std::fmax(extent.x, std::fmax(extent.y, extent.z))),
            rounded_up(positions_.off_straight()), PositionNoise<Real>::kOfFloor * largest_coordinate(measured)};
  }
  static double largest_coordinate(const WaysMeasure& measured) {
    const double start = max(largest_component(measured.start.lo), largest_component(measured.start.hi));
    return rounded_up(start + static_cast<double>(measured.longest));
  }
  /// To a power of two: steps with other numbers are recorded anew.
  static double rounded_up(double x) { return x > 0 ? std::exp2(std::ceil(std::log2(x))) : 0; }

  using Shorten = ShortenPhase<Exec, Real>;

  /// Goes as far as all pairs keep their floors. Returns what that came to.
  WaysGone go(AdvanceMode mode) {
    if (!any_failed()) return GoneOfWay<Real>::nothing();
    const bool need_host = shard_ != nullptr || positions_.has_rigid();
    if (!need_host)
      pipeline_.shorten(static_cast<uint64_t>(mode), [&](Shorten& shorten) {
        exec_.stage("advance", [&] {
          positions_.keep_target();
          exec_.repeat(shorten.goes_on(), [&] { run_round(shorten); });
          sum_up(shorten, mode);
        });
      });
    if (any_failed())
      pipeline_.shorten_by_parts([&](Shorten& shorten) {
        exec_.stage("advance", [&] {
          if (need_host) positions_.keep_target();
          run_rounds_with_host(shorten, mode);
          sum_up(shorten, mode);
        });
      });
    return pipeline_.found().gone;
  }
  void run_round(Shorten& shorten) {
    shorten.propose();
    shorten.take_shares();
    positions_.go();
    shorten.judge_changed();
  }
  void run_rounds_with_host(Shorten& shorten, AdvanceMode mode) {
    do {
      shorten.propose();
      join_shares();
      if (shortening_of(pipeline_.found().round.number) == Shortening::kIslands) join_islands(shorten);
      shorten.take_shares();
      positions_.go();
      positions_.go_rigid([&](uint32_t mesh) { return group_of(mode, mesh, shape().vertex_offset[mesh]); });
      shorten.judge_changed();
      pipeline_.look_at_rounds();
    } while (any_failed());
  }
  void join_islands(Shorten& shorten) {
    while (any(shorten.join_islands(positions_.target()) > 0)) join_shares();
  }
  void sum_up(Shorten& shorten, AdvanceMode mode) {
    shorten.add_up(positions_.target());
    if (mode != AdvanceMode::kAllOrOne) shorten.list_shortened(positions_.target(), mode == AdvanceMode::kPerMesh);
  }

  // What shards of a scene have to know of each other.
  bool any_failed() { return any(pipeline_.found().round.count_failed() > 0); }
  bool any(bool here) { return shard_ == nullptr ? here : shard_->meeting.meet({here, 1}, exec_.asks()).any_contact; }
  void join_starts() {
    join_least(ways_.clearances);
    pipeline_.shorten_by_parts([&](Shorten& shorten) { shorten.judge_all(); });
  }
  void join_shares() {
    if (shard_ != nullptr) join_least(ways_.shares);
  }
  void join_least(Buffer<uint64_t, Exec>& values) {
    MemoryHold held(model_.spec().memory_quota);
    held.resize(2 * uint64_t{vertices()} * sizeof(uint64_t));  // and the meeting's own
    std::vector<uint64_t> here(vertices());
    exec_.download(here.data(), values.data(), here.size() * sizeof(uint64_t));
    shard_->meeting.meet_least(here, exec_.asks());
    exec_.upload(values.data(), here.data(), here.size() * sizeof(uint64_t));
    exec_.wait();
  }

  /// Tells the fractions of vertices, or of meshes.
  void tell_shortened(AdvanceMode mode, ShortenedWays& told) {
    const uint64_t count = pipeline_.found().shortened, bytes = count * sizeof(ShortenedWay);
    if (count == 0) return;
    auto* const first = reinterpret_cast<ShortenedWay*>(exec_.host_memory(bytes));
    const std::span<ShortenedWay> listed(first, count);
    exec_.download(first, ways_.shortened.data(), bytes);
    std::sort(listed.begin(), listed.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
    for (const ShortenedWay& way : listed) {
      const uint32_t vertex = static_cast<uint32_t>(way.vertex);
      told.ids.push_back(mode == AdvanceMode::kPerMesh ? shape().mesh_of(vertex) : vertex);
      told.fractions.push_back(way.fraction);
    }
  }

  /// Adds the costs of the advance, as one stage.
  void add_costs(const StageRange& own_search, FrameResult& result) {
    result.allocations = exec_.allocations();
    result.graph_launches = exec_.graph_launches();
    result.step_milliseconds = exec_.step_milliseconds();
    result.stages = exec_.stage_times();
    if (own_search.first < own_search.end) make_one_stage(result.stages, own_search.first, own_search.end, "advance");
    gather_stages(result.stages, "advance");
  }

  Exec& exec_;
  SceneModel<Exec, Real>& model_;
  ResidentTopology<Exec>& topology_;
  FractionBuffers<Exec>& ways_;
  const ShardOf* const shard_;
  ResidentPositions<Exec, Real>& positions_;
  Pipeline<Exec, Real>& pipeline_;
  std::optional<WaysMeasure> measured_;  ///< in the last frame
};

}  // namespace collided
