#pragma once
// Frames that go as far as they can. The frame's own step has told the contacts of the whole way. Then the scene goes
// towards the frame's positions. Each group of vertices goes as far as all pairs keep their floors
// (step/shorten_phase.hpp).

#include <cmath>
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
    });
    const WaysMeasure measured = pipeline_.measure_ways();
    StageRange own_search;
    FrameResult result = find_pairs(boxes_static, frame, settings, rules(measured), own_search);
    positions_.keep_target();
    WaysGone gone = GoneOfWay<Real>::nothing();
    if (run_rounds())
      pipeline_.shorten_by_parts([&](ShortenPhase<Exec, Real>& shorten) {
        gone = shorten.add_up(positions_.target(), measured.longest);
        if (gone.least_bits != kWholeBits)
          tell(frame.advance_mode, shorten.fractions(positions_.target()), result.shortened);
      });
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
                         const WayRules& rules, StageRange& own_search) {
    if (!model_.spec().kinds.triangle_triangle)
      return pipeline_.detect_blocking(boxes_static, settings, frame.bytes_beside_contact, frame.room, rules);
    FrameResult result = pipeline_.detect_contacts(boxes_static, settings, frame.bytes_beside_contact, frame.room);
    const FrameResult found = pipeline_.find_blocking(rules);
    own_search = {result.stages.size(), found.stages.size()};
    result.replays += found.replays;
    return result;
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

  /// Goes on until no pair fails. Returns whether any did.
  bool run_rounds() {
    if (shard_ != nullptr) join_starts();
    uint32_t round = 0;
    while (any_failed()) {
      const uint32_t end = round + rounds_together(round);
      pipeline_.shorten(round, end, [&](ShortenPhase<Exec, Real>& shorten) {
        exec_.stage("advance", [&] {
          for (uint32_t r = round; r < end; ++r) run_round(shorten, r);
        });
      });
      round = end;
    }
    return round > 0;
  }
  /// Rounds that need nothing of the host go together, but for late ones, which are rare. Those that no failed pair is
  /// left for change nothing.
  uint32_t rounds_together(uint32_t round) const {
    constexpr uint32_t kFirst = 2, kLater = 4;
    const bool need_host = shard_ != nullptr || positions_.has_rigid(),
               is_late = shortening_of(round + kLater) > Shortening::kPlanes;
    return need_host || is_late || !Exec::kLaunchesCost ? 1 : round == 0 ? kFirst : kLater;
  }
  void run_round(ShortenPhase<Exec, Real>& shorten, uint32_t round) {
    shorten.propose(round);
    join_shares();
    if (shortening_of(round) == Shortening::kIslands) join_islands(shorten);
    shorten.take_shares(round);
    positions_.go();
    shorten.judge_changed(round);
  }
  void join_islands(ShortenPhase<Exec, Real>& shorten) {
    while (any(shorten.join_islands(positions_.target()) > 0)) join_shares();
  }

  // What shards of a scene have to know of each other.
  bool any_failed() { return any(pipeline_.count_failed() > 0); }
  bool any(bool here) { return shard_ == nullptr ? here : shard_->meeting.meet({here, 1}, exec_.asks()).any_contact; }
  void join_starts() {
    join_least(ways_.clearances);
    pipeline_.shorten_by_parts([&](ShortenPhase<Exec, Real>& shorten) { shorten.judge_all(); });
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

  void tell(AdvanceMode mode, const std::vector<double>& fractions, ShortenedWays& told) const {
    if (mode == AdvanceMode::kAllOrOne) return;
    const auto add = [&](uint32_t id, uint32_t group) {
      if (group == kStands || fractions[group] == 1) return;
      told.ids.push_back(id);
      told.fractions.push_back(fractions[group]);
    };
    for (uint32_t mesh = 0; mesh < shape().meshes(); ++mesh) {
      const uint32_t first = shape().vertex_offset[mesh], end = shape().vertex_offset[mesh + 1];
      if (first == end) continue;
      if (mode == AdvanceMode::kPerMesh)
        add(mesh, group_of(mode, mesh, first));
      else
        for (uint32_t v = first; v < end; ++v) add(v, group_of(mode, mesh, v));
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
};

}  // namespace collided
