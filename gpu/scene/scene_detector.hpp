#pragma once
// A scene on one backend: keeps positions resident, applies frames atomically, runs the pipeline.

#include <stdexcept>
#include <utility>

#include "gpu/base/float_environment.hpp"
#include "gpu/contacts/world_results.hpp"
#include "gpu/detector.hpp"
#include "gpu/positions/sample.hpp"
#include "gpu/scene/edit.hpp"
#include "gpu/scene/far_meshes.hpp"
#include "gpu/scene/known_lengths.hpp"
#include "gpu/scene/parts/meeting.hpp"
#include "gpu/scene/resident_positions.hpp"
#include "gpu/scene/rest_pairs.hpp"
#include "gpu/scene/rules.hpp"
#include "gpu/scene/scene_model.hpp"
#include "gpu/step/advance.hpp"
#include "gpu/step/pipeline.hpp"
#include "gpu/tables/tables.hpp"

namespace collided {

template <Executor Exec, class Real>
class SceneDetector final : public Detector {
 public:
  /// `part`: the scene is a part of another; may be null.
  template <class... ExecArgs>
  SceneDetector(SceneSpec spec, FeatureTables features, const PartOf* part, ExecArgs... args)
      : part_(part),
        exec_(args...),
        model_(exec_, std::move(spec), std::move(features)),
        positions_(exec_, model_.shape(), scene_),
        pipeline_(exec_, spec_, model_.counts(), scene_),
        rest_pairs_(exec_, spec_, scene_, pipeline_),
        told_(spec_.expected) {
    if (part_ != nullptr) scene_.share.take(part_->share);
  }

  FrameResult detect(const FrameInput& frame) override {
    const DefaultFloatEnvironment environment;
    check_frame(spec_, frame);
    FrameSettings settings = settings_of(spec_, frame);
    settings.encoding = encoding_;
    exec_.asks().begin(frame.cancelled);
    FrameResult result =
        exec_.frame([&] { return frame.edit ? detect_edited(frame, settings) : detect(frame, settings); });
    if (list_lengths().exceed(told_)) tell_lengths();
    result.unused_options = unused_options(spec_, frame);
    return result;
  }

  void read_positions(const VertexSample& sample, std::span<std::byte> to) override {
    const DefaultFloatEnvironment environment;
    if (!positions_.has_frame()) throw std::logic_error("positions are read before the first frame");
    exec_.make_current();
    exec_.asks().no_more();  // of a frame that was given up
    scene_.sample.ensure(sample.count);
    exec_.for_each(
        "sample_positions", sample.count,
        SamplePositions<Real>{positions_.last_good().data() + sample.first, sample.stride, scene_.sample.data()});
    exec_.download(to.data(), scene_.sample.data(), to.size());
  }

  std::shared_ptr<FrameSlot> make_slot() override { return new_slot(); }

  std::vector<MemoryPart> memory() const override {
    std::vector<MemoryPart> parts = exec_.ledger().parts();
    if (pipeline_.answer_bytes() > 0) parts.push_back({"answers", pipeline_.answer_bytes()});
    return parts;
  }
  ListLengths list_lengths() const override { return pipeline_.list_lengths(); }
  const SceneSpec& spec() const override { return spec_; }
  const Topology& topology() const override { return model_.topology(); }
  DeviceInfo device() const override {
    DeviceInfo info = exec_.device();
    info.device = spec_.device;
    return info;
  }

  /// What is told then may be less than was expected.
  ~SceneDetector() override {
    try {
      if (positions_.has_frame()) tell_lengths();
    } catch (...) {  // whoever comes next knows less
    }
  }

 private:
  using Slot = SceneSlot<Exec, Real>;
  using Parts = typename SceneModel<Exec, Real>::Parts;
  using Saved = typename ResidentPositions<Exec, Real>::Saved;

  std::shared_ptr<Slot> new_slot() const { return std::make_shared<Slot>(model_.slot_shape(), exec_); }

  /// The scene stays as edited if the frame counts, and else as it was.
  FrameResult detect_edited(const FrameInput& frame, const FrameSettings& settings) {
    if (!positions_.has_frame())
      throw InvalidInput("edit", "edit is given in the scene's first frame, which has its meshes by the scene's spec");
    Parts before(exec_);
    Saved saved = positions_.save();
    bool is_begun = false;
    try {
      exec_.stage("edit", [&] {
        MemoryHold making(spec_.memory_quota);
        EditedScene edited = edit_scene(spec_, model_.topology(), frame, settings.is_ccd());
        FeatureTables features;
        if (edited.changes_features)
          features = make_tables(edited.spec, making, exec_.asks());
        else
          features.rings = make_rings(edited.spec, model_.topology(), making, exec_.asks());
        model_.swap(before);
        is_begun = true;
        begin_edited(std::move(edited), std::move(features), before, saved);
      });
      FrameResult result = detect(frame, settings);
      release_unneeded();
      return result;
    } catch (...) {
      if (is_begun) undo(before, std::move(saved));
      throw;
    }
  }
  void begin_edited(EditedScene edited, FeatureTables features, const Parts& before, const Saved& saved) {
    own_slot_ = nullptr;
    if (edited.changes_features)
      model_.take(std::move(edited.spec), std::move(features));
    else
      model_.take_rules(std::move(edited.spec), before, features.rings);
    pipeline_.resize(model_.topology());
    positions_.edit(saved, before.buffers, before.shape.vertex_offset, std::move(edited.first));
    rest_pairs_.edit(before.buffers.topology.rest_pairs, IdShift(before.topology, model_.topology()),
                     edited.begins_at_rest);
  }
  void undo(Parts& before, Saved saved) {
    own_slot_ = nullptr;
    model_.swap(before);
    pipeline_.resize(model_.topology());
    positions_.restore(std::move(saved));
    rest_pairs_.settle();
  }
  void tell_lengths() {
    told_ = list_lengths();
    if (spec_.known) spec_.known->learn(hash_of_scene(spec_, model_.topology()), told_);
  }
  /// Lists that a much larger scene needed.
  void release_unneeded() {
    const size_t triangles = model_.topology().triangles.size();
    most_triangles_ = std::max(most_triangles_, triangles);
    if (2 * triangles > most_triangles_) return;
    most_triangles_ = triangles;
    pipeline_.release_lists();
  }

  FrameResult detect(const FrameInput& frame, const FrameSettings& settings) {
    const bool begins_at_rest = rest_pairs_.are_awaited();
    if (part_ != nullptr) scene_.share.take(part_->share);
    if (spec_.kinds.edge_edge && (settings.accuracy != Accuracy::kCandidates || begins_at_rest || frame.room.stencils))
      model_.require_edges();
    const bool boxes_static = !positions_.are_boxes_good();
    Slot* slot = nullptr;
    std::optional<WorldFrames> worlds;
    exec_.stage("upload", [&] {
      slot = &sent_slot(frame);
      if (spec_.worlds > 0)
        worlds = slot->arrive_by_world(positions_.first(), exec_.asks());
      else
        slot->arrive(positions_.first());
      if (worlds) positions_.begin_worlds(*worlds);
      if (worlds && worlds->count() == 0) return;
      positions_.check_start_fraction(frame.start_fraction);
      positions_.require(*slot, frame);
      positions_.place(*slot, frame, settings.is_ccd());
      check_straight(frame, settings);
    });
    if (worlds) return detect_worlds(std::move(*worlds), *slot, settings, frame.bytes_beside_contact);
    RestCosts rest;
    if (begins_at_rest) rest = find_rest_pairs();
    FrameResult result = search(frame, settings, boxes_static);
    if (begins_at_rest) add_costs(rest, result);
    exec_.asks().ask();
    if (part_ != nullptr) part_->take_answer(result, exec_.asks());
    if (frame.trial) {
      positions_.end_trial();
      return result;
    }
    exec_.asks().no_more();
    positions_.commit(*slot);
    rest_pairs_.settle();
    return result;
  }

  /// Finds the contacts of the positions that are resident.
  FrameResult search(const FrameInput& frame, const FrameSettings& settings, bool boxes_static) {
    try {
      const bool has_margin = frame.advance && settings.accuracy != Accuracy::kExact;
      const double margin = has_margin ? advance_margin(pipeline_.measure_way(), spec_.min_separation) : 0;
      const FrameSettings own = frame.advance ? with_margin(settings, margin) : settings;
      FrameResult result = pipeline_.detect_contacts(boxes_static, own, frame.bytes_beside_contact, frame.room);
      if (frame.advance) advance(own, margin, result);
      return result;
    } catch (...) {
      if (frame.progress != nullptr) tell_progress(settings.is_ccd(), *frame.progress);
      throw;
    }
  }
  /// Serves a message alone, so that a failure here is ignored.
  void tell_progress(bool is_ccd, FrameProgress& progress) noexcept try {
    exec_.asks().no_more();
    progress = pipeline_.progress();
    if (is_ccd) progress.far_meshes = far_meshes(exec_, scene_, model_.topology());
  } catch (...) {
  }

  /// What all parts of the scene found; of a scene that is one: what it did. Once all have come they go on alike.
  Found share(const FrameResult& result) {
    const Found found{result.any_contact, result.earliest_toi};
    return part_ == nullptr ? found : part_->meeting.meet(found, exec_.asks());
  }

  /// The rest of a set's frame, for the worlds that take part in it.
  FrameResult detect_worlds(WorldFrames worlds, Slot& slot, const FrameSettings& settings,
                            uint64_t bytes_beside_contact) {
    FrameResult result;
    if (worlds.count() > 0) {
      result = pipeline_.detect_contacts(true, settings, bytes_beside_contact);
      exec_.asks().ask();
      exec_.asks().no_more();
      positions_.commit(slot, worlds);
    }
    result.worlds = divide_by_world(scene_.topology.shape, result);
    result.worlds.refused = std::move(worlds).refused();
    return result;
  }

  /// What decides on the straight paths of positions cannot on the arcs of a mesh that turns.
  void check_straight(const FrameInput& frame, const FrameSettings& settings) const {
    const std::optional<uint32_t> mesh = positions_.turning();
    if (!mesh || !settings.is_ccd()) return;
    const std::string turns = "but rigid mesh " + std::to_string(*mesh) + " turns in this step, on no straight path";
    if (frame.advance) throw InvalidInput("advance", "advance is on, " + turns);
    if (settings.accuracy == Accuracy::kExact) throw InvalidInput("accuracy", "accuracy is EXACT, " + turns);
  }

  /// What the first frame's step for rest pairs cost, and where its stages are among the frame's.
  struct RestCosts {
    uint32_t replays = 0;
    size_t first_stage = 0, end_stage = 0;
  };
  RestCosts find_rest_pairs() {
    const size_t first_stage = exec_.stage_times().size();
    const uint32_t replays = rest_pairs_.find();
    return {replays, first_stage, exec_.stage_times().size()};
  }
  static void add_costs(const RestCosts& rest, FrameResult& result) {
    result.replays += rest.replays;
    make_one_stage(result.stages, rest.first_stage, rest.end_stage, "rest_pairs");
  }

  /// Where a step with the frame's own settings can serve as the first try of an advance, it does.
  FrameSettings with_margin(FrameSettings settings, double margin) const {
    if (settings.accuracy == Accuracy::kCertified && settings.thickness == spec_.min_separation)
      settings.thickness += margin;
    return settings;
  }

  /// After the frame's own step, from whose end the scene goes back as far as it has to.
  void advance(const FrameSettings& settings, double margin, FrameResult& result) {
    const FrameSettings attempt = settings_of_try(spec_, settings.accuracy, margin);
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
  /// What the backend tells of a try is of the whole frame so far; all tries are one stage.
  static void add_costs(FrameResult& result, size_t own_stages, const FrameResult& tried) {
    result.replays += tried.replays;
    result.allocations = tried.allocations;
    result.graph_launches = tried.graph_launches;
    result.step_milliseconds = tried.step_milliseconds;
    result.stages = tried.stages;
    make_one_stage(result.stages, own_stages, tried.stages.size(), "advance");
  }
  /// Stages [first, end) become one.
  static void make_one_stage(std::vector<StageTime>& stages, size_t first, size_t end, const char* name) {
    StageTime all{name, 0};
    for (size_t i = first; i < end; ++i) all.milliseconds += stages[i].milliseconds;
    const auto at = stages.begin() + static_cast<std::ptrdiff_t>(first);
    stages.insert(stages.erase(at, at + static_cast<std::ptrdiff_t>(end - first)), all);
  }

  /// The frame's slot, or the scene's own with the frame's positions.
  Slot& sent_slot(const FrameInput& frame) {
    if (frame.slot == nullptr) {
      if (own_slot_ == nullptr) own_slot_ = new_slot();
      own_slot_->send_after(frame.stream, frame.updates);
      return *own_slot_;
    }
    if (!frame.updates.empty())
      throw InvalidInput("updates", "updates has " + std::to_string(frame.updates.size()) +
                                        " meshes; it must be empty where a slot brings the positions");
    Slot* slot = dynamic_cast<Slot*>(frame.slot.get());
    if (slot == nullptr || !slot->is_of(model_.slot_shape()))
      throw InvalidInput("slot", "slot is of another scene than the frame, or of this one before an edit");
    return *slot;
  }

  const PartOf* const part_;
  Exec exec_;
  SceneModel<Exec, Real> model_;
  const SceneSpec& spec_ = model_.spec();
  SceneBuffers<Exec, Real>& scene_ = model_.buffers();
  const double encoding_ = 2 * encoding_error(spec_);  ///< of two positions
  ResidentPositions<Exec, Real> positions_;
  Pipeline<Exec, Real> pipeline_;
  RestPairs<Exec, Real> rest_pairs_;
  size_t most_triangles_ = model_.topology().triangles.size();  ///< since lists were released
  std::shared_ptr<Slot> own_slot_;
  ListLengths told_;  ///< to scenes alike, or by them
};

}  // namespace collided
