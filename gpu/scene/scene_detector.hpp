#pragma once
// A scene on one backend: keeps positions resident, applies frames atomically, runs the pipeline.

#include <stdexcept>
#include <utility>

#include "gpu/base/float_environment.hpp"
#include "gpu/contacts/world_results.hpp"
#include "gpu/detector.hpp"
#include "gpu/positions/sample.hpp"
#include "gpu/scene/advances.hpp"
#include "gpu/scene/far_meshes.hpp"
#include "gpu/scene/frame_checks.hpp"
#include "gpu/scene/known_lengths.hpp"
#include "gpu/scene/scene_edits.hpp"

namespace collided {

template <Executor Exec, class Real>
class SceneDetector final : public Detector {
 public:
  /// `shard`: the scene is a shard of another; may be null.
  template <class... ExecArgs>
  SceneDetector(SceneSpec spec, FeatureTables features, const ShardOf* shard, ExecArgs... args)
      : shard_(shard),
        exec_(args...),
        model_(exec_, std::move(spec), std::move(features)),
        positions_(exec_, model_.shape(), scene_),
        pipeline_(exec_, spec_, model_.counts(), scene_),
        rest_pairs_(exec_, spec_, scene_, pipeline_),
        volumes_(exec_, model_, scene_),
        edits_(exec_, model_, positions_, pipeline_, rest_pairs_, volumes_),
        advances_(exec_, model_, shard, positions_, pipeline_),
        told_(spec_.expected) {
    if (shard_ != nullptr) scene_.share.take(shard_->share);
  }

  FrameResult detect(const FrameInput& frame) override {
    const DefaultFloatEnvironment environment;
    const CheckedFrame checked = checks_.check(spec_, frame);
    FrameSettings settings = checked.settings;
    settings.encoding = encoding_;
    exec_.asks().begin(frame.cancelled);
    FrameResult result = exec_.frame([&] { return frame.edit ? edit(frame, settings) : detect(frame, settings); });
    if (list_lengths().exceed(told_)) tell_lengths();
    result.unused_options = frame.edit ? unused_options(spec_, frame) : checked.unused;
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

  std::shared_ptr<Slot> new_slot() const { return std::make_shared<Slot>(model_.slot_shape(), exec_); }

  FrameResult edit(const FrameInput& frame, const FrameSettings& settings) {
    checks_.forget();
    own_slot_ = nullptr;  // the edited scene may need its memory
    return edits_.apply(frame, settings.is_ccd(), [&] {
      FrameSettings edited = settings;
      edited.thickest = settings_of(spec_, frame).thickest;  // the edit may have changed it
      return detect(frame, edited);
    });
  }
  void tell_lengths() {
    told_ = list_lengths();
    if (spec_.known) spec_.known->learn(hash_of_scene(spec_, model_.topology()), told_);
  }
  FrameResult detect(const FrameInput& frame, const FrameSettings& settings) {
    const bool begins_at_rest = rest_pairs_.are_awaited();
    if (shard_ != nullptr) scene_.share.take(shard_->share);
    if (have_edges(kinds_looked_for(spec_)) &&
        (settings.accuracy != Accuracy::kCandidates || begins_at_rest || frame.room.stencils))
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
      volumes_.check();
    });
    if (worlds) return detect_worlds(std::move(*worlds), *slot, settings, frame.bytes_beside_contact);
    RestCosts rest;
    if (begins_at_rest) rest = find_rest_pairs();
    FrameResult result = search(frame, settings, boxes_static);
    if (begins_at_rest) add_costs(rest, result);
    exec_.asks().ask();
    if (shard_ != nullptr) shard_->take_answer(result, exec_.asks());
    if (frame.trial) {
      positions_.end_trial();
      return result;
    }
    exec_.asks().no_more();
    positions_.commit(*slot);
    rest_pairs_.settle();
    volumes_.settle();
    return result;
  }

  /// Finds the contacts of the positions that are resident.
  FrameResult search(const FrameInput& frame, const FrameSettings& settings, bool boxes_static) {
    try {
      if (frame.advance) return advances_.detect(boxes_static, frame, settings);
      return pipeline_.detect_contacts(boxes_static, settings, frame.bytes_beside_contact, frame.room);
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

  /// The frame's slot, or the scene's own with the frame's positions.
  Slot& sent_slot(const FrameInput& frame) {
    if (frame.slot == nullptr) {
      if (own_slot_ == nullptr || !own_slot_->is_of(model_.slot_shape())) own_slot_ = nullptr, own_slot_ = new_slot();
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

  const ShardOf* const shard_;
  Exec exec_;
  SceneModel<Exec, Real> model_;
  const SceneSpec& spec_ = model_.spec();
  SceneBuffers<Exec, Real>& scene_ = model_.buffers();
  const double encoding_ = 2 * encoding_error(spec_);  ///< of two positions
  ResidentPositions<Exec, Real> positions_;
  Pipeline<Exec, Real> pipeline_;
  RestPairs<Exec, Real> rest_pairs_;
  SolidVolumes<Exec, Real> volumes_;
  SceneEdits<Exec, Real> edits_;
  Advances<Exec, Real> advances_;
  FrameChecks checks_;
  std::shared_ptr<Slot> own_slot_;
  ListLengths told_;  ///< to scenes alike, or by them
};

}  // namespace collided
