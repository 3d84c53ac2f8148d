#include "gpu/scene/shards/sharded_scene.hpp"

#include <utility>

#include "gpu/base/float_environment.hpp"
#include "gpu/base/text.hpp"
#include "gpu/contacts/answer_room.hpp"
#include "gpu/exec/cpu/cpu_loops.hpp"
#include "gpu/scene/backends/backends.hpp"
#include "gpu/scene/frame_checks.hpp"
#include "gpu/scene/shards/balance.hpp"
#include "gpu/scene/shards/crew.hpp"
#include "gpu/scene/shards/meeting.hpp"
#include "gpu/scene/shards/merged.hpp"
#include "gpu/scene/shards/sharded_slot.hpp"
#include "gpu/sharded_quota.hpp"
#include "gpu/step/contact_sets.hpp"

namespace collided {
namespace {

AnswerRoom::MakeBlock host_blocks(const Device& device) {
  return device.backend == Backend::kCuda ? cuda_host_blocks(device.ordinal) : cpu_host_blocks();
}

class ShardedScene final : public Detector {
 public:
  ShardedScene(SceneSpec spec, FeatureTables features)
      : spec_(std::move(spec)),
        room_(std::make_shared<AnswerRoom>(spec_.memory_quota, host_blocks(spec_.device))),
        balance_(spec_.part_devices.size()),
        meeting_(spec_.part_devices.size()),
        links_(spec_.part_devices.size(), ShardOf{meeting_}),
        results_(spec_.part_devices.size()),
        crew_(spec_.part_devices.size()) {
    const SceneSpec of_shard = spec_of_shard();
    for (size_t k = 0; k < links_.size(); ++k)
      links_[k].take_answer = [this, k](FrameResult& result, Asks& asks) { take_answer(k, result, asks); };
    for (size_t k = 0; k < links_.size(); ++k)
      shards_.push_back(make_shard(of_shard, k + 1 < links_.size() ? features : std::move(features), k));
    forget_elements();
  }
  ~ShardedScene() override { room_->close(); }

  FrameResult detect(const FrameInput& frame) override {
    const DefaultFloatEnvironment environment;
    const Report report = checks_.check(spec_, frame).settings.report;
    if (frame.edit) checks_.forget();
    frame_ = &frame;
    meeting_.begin();
    for (size_t k = 0; k < links_.size(); ++k) links_[k].share = balance_.range(k);
    const std::vector<FrameInput> inputs = inputs_of_shards(frame);
    crew_.run([&](size_t k) { detect_shard(k, inputs[k]); });
    if (meeting_.has_failed()) {
      forget_answers();
      std::rethrow_exception(meeting_.error());
    }
    if (frame.edit) spec_ = spec_like(shards_.front()->spec());
    FrameResult result = merged(report);
    learn(result);
    forget_answers();
    return result;
  }

  void read_positions(const VertexSample& sample, std::span<std::byte> to) override {
    shards_.front()->read_positions(sample, to);
  }
  std::shared_ptr<FrameSlot> make_slot() override {
    std::vector<std::shared_ptr<FrameSlot>> slots;
    for (const auto& shard : shards_) slots.push_back(shard->make_slot());
    return std::make_shared<ShardedSlot>(std::move(slots));
  }
  std::vector<MemoryPart> memory() const override {
    std::vector<MemoryPart> all;
    for (size_t k = 0; k < shards_.size(); ++k) add_memory(all, k, shards_[k]->memory());
    if (room_->bytes() > 0) all.push_back({"answers", room_->bytes()});
    return all;
  }
  /// Of the shard that needs most.
  ListLengths list_lengths() const override {
    ListLengths lengths;
    for (const auto& shard : shards_) lengths.include(shard->list_lengths());
    return lengths;
  }
  const SceneSpec& spec() const override { return spec_; }
  const Topology& topology() const override { return shards_.front()->topology(); }
  DeviceInfo device() const override { return shards_.front()->device(); }

 private:
  /// Threads of the host are shared out.
  SceneSpec spec_of_shard() const {
    SceneSpec spec = spec_;
    spec.part_devices = {};
    spec.known = nullptr;                                        // which is of whole scenes
    spec.fields = spec.fields.without(ContactField::kFeatures);  // see tells_features()
    spec.reuse = Reuse::kOff;  // lists hold for the pairs that were a shard's own when they were made
    const int threads = static_cast<int>(CpuLoops(spec.threads).threads());
    spec.threads = std::max(1, threads / static_cast<int>(links_.size()));
    return spec;
  }
  /// As the scene's own, from that of its shards.
  SceneSpec spec_like(SceneSpec of_shard) const {
    of_shard.part_devices = spec_.part_devices;
    of_shard.reuse = spec_.reuse;
    of_shard.fields = spec_.fields;
    of_shard.threads = spec_.threads;
    of_shard.memory_quota = spec_.memory_quota;
    return of_shard;
  }
  std::unique_ptr<Detector> make_shard(const SceneSpec& spec, FeatureTables features, size_t k) {
    SceneSpec here = spec;
    here.device = spec_.part_devices[k];
    if (const auto* apart = dynamic_cast<const ShardedQuota*>(spec.memory_quota.get()))
      here.memory_quota = apart->of_shard(k);
    if (here.device.backend == Backend::kCpu)
      return make_cpu_detector(std::move(here), std::move(features), &links_[k]);
    return make_cuda_detector(std::move(here), std::move(features), &links_[k]);
  }
  void forget_elements() { spec_ = spec_like(shards_.front()->spec()); }

  std::vector<FrameInput> inputs_of_shards(const FrameInput& frame) {
    FrameInput input = frame;
    input.bytes_beside_contact = 0;  // which the merged contacts have
    std::vector<FrameInput> inputs(shards_.size(), input);
    const ShardedSlot* slot = dynamic_cast<const ShardedSlot*>(frame.slot.get());
    if (frame.slot != nullptr && slot == nullptr)
      throw InvalidInput("slot", "slot is of another scene than the frame, or of this one before an edit");
    for (size_t k = 0; k < shards_.size(); ++k) {
      if (slot != nullptr) inputs[k].slot = slot->of_shard(k);
      if (k > 0) inputs[k].progress = nullptr;
      inputs[k].cancelled = [this, k, asks = frame.cancelled] {
        return meeting_.has_failed() || (k == 0 && asks && asks());
      };
    }
    return inputs;
  }
  void detect_shard(size_t k, const FrameInput& input) {
    try {
      shards_[k]->detect(input);
    } catch (...) {
      meeting_.fail();
    }
  }
  /// Memory may be short, which refuses the frame; once all contacts have their places it counts.
  void take_answer(size_t k, FrameResult& result, Asks& asks) {
    results_[k] = std::move(result);
    meeting_.meet({}, asks);
    const WorkTime time(asks);
    if (k == 0)
      for (MergedContacts* merged : {&contacts_, &limits_}) merged->take(*room_, frame_->bytes_beside_contact);
    meeting_.meet({}, asks);
    for (const MergedContacts* merged : {&contacts_, &limits_}) merged->place(k);
    meeting_.meet({}, asks);
    if (k == 0) results_[0].stages.push_back({"merge", time.milliseconds()});
  }

  FrameResult merged(Report report) {
    FrameResult result = merged_facts(results_, report);
    for (size_t k = 0; k < shards_.size(); ++k)
      result.shards.push_back(
          {balance_.size(k), results_[k].step_milliseconds, results_[k].counts.pairs, count_contacts(results_[k])});
    result.held = contacts_.move_to(result);
    limits_.move_to(result.limits);
    if (report == Report::kEarliestOnly) keep_earliest(loops_, result);
    return result;
  }

  void forget_answers() {
    for (FrameResult& shard : results_) shard = {};
    contacts_.clear();
    limits_.clear();
  }

  /// From frames that were nothing but a step.
  void learn(const FrameResult& result) {
    std::vector<double> times;
    bool is_clean = result.allocations == 0 && result.replays == 0;
    for (const FrameResult& shard : results_) {
      times.push_back(shard.step_milliseconds);
      is_clean = is_clean && shard.broad_phase.reason != EngineReason::kTrial;
    }
    if (is_clean) balance_.observe(times);
  }

  SceneSpec spec_;
  FrameChecks checks_;
  const std::shared_ptr<AnswerRoom> room_;
  ShareBalance balance_;
  Meeting meeting_;
  std::vector<ShardOf> links_;
  std::vector<std::unique_ptr<Detector>> shards_;
  std::vector<FrameResult> results_;  ///< of each shard
  MergedContacts contacts_{results_, [](const FrameResult& shard) -> const PerKind<ContactSet>& { return shard; }};
  MergedContacts limits_{results_, [](const FrameResult& shard) -> const PerKind<ContactSet>& { return shard.limits; }};
  const FrameInput* frame_ = nullptr;  ///< in work
  CpuLoops loops_{1};
  Crew crew_;
};

}  // namespace

std::unique_ptr<Detector> make_sharded_scene(SceneSpec spec, FeatureTables features) {
  spec.device = device_of(spec);
  if (spec.device.backend == Backend::kCuda) link_cuda_devices(spec.part_devices);
  return std::make_unique<ShardedScene>(std::move(spec), std::move(features));
}

void add_memory(std::vector<MemoryPart>& all, size_t k, const std::vector<MemoryPart>& of_shard) {
  for (const MemoryPart& part : of_shard) all.push_back({"parts[" + text(k) + "]." + part.part, part.bytes});
}

}  // namespace collided
