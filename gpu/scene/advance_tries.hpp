#pragma once
// Frames that go as far as they can (step/advance.hpp): the frame's own step, and the tries of shorter ones after it.

#include "gpu/scene/resident_positions.hpp"
#include "gpu/scene/shards/meeting.hpp"
#include "gpu/scene/stage_costs.hpp"
#include "gpu/step/advance.hpp"
#include "gpu/step/pipeline.hpp"

namespace collided {

template <Executor Exec, class Real>
class AdvanceTries {
 public:
  /// `shard`: the scene is a shard of another; may be null.
  AdvanceTries(Exec& exec, const SceneSpec& spec, const ShardOf* shard, ResidentPositions<Exec, Real>& positions,
               Pipeline<Exec, Real>& pipeline)
      : exec_(exec), spec_(spec), shard_(shard), positions_(positions), pipeline_(pipeline) {}

  /// Returns the settings of the frame's own step, which is the first try where it asks the same question.
  FrameSettings begin(FrameSettings settings) {
    margin_ = settings.accuracy == Accuracy::kExact ? 0 : advance_margin(pipeline_.measure_way(), spec_.min_separation);
    if (settings.accuracy == Accuracy::kCertified && settings.thickness == spec_.min_separation)
      settings.thickness += margin_;
    return settings;
  }
  /// Goes back from the end of that step as far as the scene has to.
  void finish(const FrameSettings& settings, FrameResult& result) {
    const FrameSettings attempt = settings_of_try(spec_, settings.accuracy, margin_);
    const bool is_same_question = settings.start_thickness == spec_.min_separation && settings.encoding == 0 &&
                                  settings.report != Report::kAnyHit;
    const Found found = share(result);
    AdvanceSearch search(is_same_question ? found.earliest_toi : 1);
    // The earliest time is 1 without contacts, and may be 1 with an exact one.
    const bool may_end_in_contact = settings.accuracy == Accuracy::kExact && found.any_contact;
    if (search.fraction() < 1 || !is_same_question || !covers(settings, attempt) || may_end_in_contact)
      try_until_free(search, attempt, result);
    result.advanced = search.fraction();
  }

 private:
  /// Returns what all shards of the scene found together. All of them wait here for each other.
  Found share(const FrameResult& result) {
    const Found found{result.any_contact, result.earliest_toi};
    return shard_ == nullptr ? found : shard_->meeting.meet(found, exec_.asks());
  }
  void try_until_free(AdvanceSearch& search, const FrameSettings& attempt, FrameResult& result) {
    positions_.keep_target();
    const size_t own_stages = result.stages.size();
    while (search.can_try()) {
      if (search.fraction() < 1) positions_.go(search.fraction());
      const FrameResult tried = pipeline_.detect_contacts(false, attempt, 0);
      add_costs(result, own_stages, tried);
      const Found found = share(tried);
      if (!found.any_contact) return;
      search.fail(found.earliest_toi);
    }
    positions_.go(search.fraction());
  }
  /// Adds the costs of a try, which the backend reports for the whole frame so far. All tries are one stage.
  static void add_costs(FrameResult& result, size_t own_stages, const FrameResult& tried) {
    result.replays += tried.replays;
    result.allocations = tried.allocations;
    result.graph_launches = tried.graph_launches;
    result.step_milliseconds = tried.step_milliseconds;
    result.stages = tried.stages;
    make_one_stage(result.stages, own_stages, tried.stages.size(), "advance");
  }

  Exec& exec_;
  const SceneSpec& spec_;
  const ShardOf* const shard_;
  ResidentPositions<Exec, Real>& positions_;
  Pipeline<Exec, Real>& pipeline_;
  double margin_ = 0;  ///< that the thickness of tries grows by, of the frame in work
};

}  // namespace collided
