#pragma once
// A scene on one backend: keeps positions resident, applies frames atomically, runs the pipeline.

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "gpu/detector.hpp"
#include "gpu/positions/sample.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/scene/rules.hpp"
#include "gpu/scene/topology.hpp"
#include "gpu/step/pipeline.hpp"

namespace collided {

template <Executor Exec, class Real>
class SceneDetector final : public Detector {
 public:
  template <class... ExecArgs>
  SceneDetector(SceneSpec spec, FeatureTables features, ExecArgs... args)
      : topology_(std::move(features.topology)),
        shape_(shape_of(std::move(spec), topology_)),
        exec_(args...),
        scene_(exec_),
        pipeline_(exec_, spec_, topology_, scene_) {
    make_resident(features);
  }

  FrameResult detect(const FrameInput& frame) override {
    const FrameSettings settings = settings_of(spec_, frame);
    check_settings(spec_, settings);
    exec_.asks().begin(frame.cancelled);
    return exec_.frame([&] { return detect(frame, settings); });
  }

  void read_positions(const VertexSample& sample, std::span<std::byte> to) override {
    if (!has_frame_) throw std::logic_error("positions are read before the first frame");
    exec_.asks().no_more();  // of a frame that was given up
    scene_.sample.ensure(sample.count);
    exec_.for_each("sample_positions", sample.count,
                   SamplePositions<Real>{good_positions() + sample.first, sample.stride, scene_.sample.data()});
    exec_.download(to.data(), scene_.sample.data(), to.size());
  }

  std::shared_ptr<FrameSlot> make_slot() override { return new_slot(); }

  std::vector<MemoryPart> memory() const override {
    std::vector<MemoryPart> parts = exec_.ledger().parts();
    if (pipeline_.answer_bytes() > 0) parts.push_back({"answers", pipeline_.answer_bytes()});
    return parts;
  }
  const Topology& topology() const override { return topology_; }
  DeviceInfo device() const override { return exec_.device(); }

 private:
  using Slot = SceneSlot<Exec, Real>;

  /// The scene-wide tables hold the triangles.
  static std::shared_ptr<const SceneShape> shape_of(SceneSpec spec, const Topology& topology) {
    for (MeshSpec& mesh : spec.meshes) mesh.triangles = {};
    return std::make_shared<const SceneShape>(SceneShape{std::move(spec), topology.vertex_offset});
  }
  std::shared_ptr<Slot> new_slot() const { return std::make_shared<Slot>(shape_, exec_); }

  void make_resident(const FeatureTables& features) {
    ResidentTopology<Exec>& resident = scene_.topology;
    send(resident.triangles, topology_.triangles);
    send(resident.owned, features.owned);
    if (spec_.kinds.edge_edge) send(resident.triangle_edges, features.triangle_edges);
    if (spec_.kinds.edge_edge && spec_.accuracy != Accuracy::kCandidates) require_edges();
    if (needs_filter()) {
      send(resident.mesh_of_triangle, features.mesh_of_triangle);
      send(resident.rules, rules());
    }
    scene_.boxes.allocate(topology_.triangles.size());
    scene_.records.allocate(topology_.triangles.size());
  }

  /// Not before the first frame, which brings all positions: a number of vertices alone holds no memory.
  void require_positions(const Slot& slot) {
    const bool is_ccd = spec_.mode == Mode::kCcd;
    scene_.end.allocate(topology_.vertex_count);
    if (is_ccd) scene_.start.allocate(topology_.vertex_count);
    if (!is_ccd || slot.brings_starts()) scene_.last_good.allocate(topology_.vertex_count);
  }

  /// A frame may ask for more accuracy than the scene.
  void require_edges() {
    if (scene_.topology.edges.capacity() == 0) send(scene_.topology.edges, topology_.edges);
  }

  template <class T, class U>
  void send(Buffer<T, Exec>& to, const std::vector<U>& from) {
    static_assert(sizeof(T) == sizeof(U));
    to.allocate(from.size());
    exec_.upload(to.data(), from.data(), from.size() * sizeof(T));
  }

  std::vector<MeshRule> rules() const {
    std::vector<MeshRule> out;
    for (const MeshSpec& m : spec_.meshes)
      out.push_back({m.groups, m.collide_mask, m.is_static ? 1u : 0u, m.self_contacts ? 1u : 0u});
    return out;
  }
  /// Whether some pair of meshes may not touch.
  bool needs_filter() const {
    const auto free = [](const MeshSpec& m) {
      return m.groups == 1 && m.collide_mask == ~0u && m.self_contacts && !m.is_static;
    };
    return !std::all_of(spec_.meshes.begin(), spec_.meshes.end(), free);
  }

  FrameResult detect(const FrameInput& frame, const FrameSettings& settings) {
    if (spec_.kinds.edge_edge && settings.accuracy != Accuracy::kCandidates) require_edges();
    const bool boxes_static = good_ != Good::kEnd || !has_frame_;
    Slot* slot = nullptr;
    exec_.stage("upload", [&] {
      slot = &sent_slot(frame);
      slot->arrive(!has_frame_);
      require_positions(*slot);
      place(*slot);
    });
    FrameResult result = pipeline_.detect_contacts(boxes_static, settings, frame.bytes_beside_contact);
    exec_.asks().ask();
    commit(*slot);
    return result;
  }

  /// The frame's slot, or the scene's own with the frame's positions.
  Slot& sent_slot(const FrameInput& frame) {
    if (frame.slot == nullptr) {
      if (own_slot_ == nullptr) own_slot_ = new_slot();
      own_slot_->send(frame.updates);
      return *own_slot_;
    }
    if (!frame.updates.empty())
      throw InvalidInput("updates", "updates has " + std::to_string(frame.updates.size()) +
                                        " meshes; it must be empty where a slot brings the positions");
    Slot* slot = dynamic_cast<Slot*>(frame.slot.get());
    if (slot == nullptr || !slot->is_of(shape_)) throw InvalidInput("slot", "slot is of another scene than the frame");
    return *slot;
  }

  /// From here until commit() the frame's positions are in `end`, and those of the last good frame elsewhere. A throw
  /// at any point of it leaves them where good_ says.
  void place(Slot& slot) {
    if (has_frame_) {
      restore();
      if (spec_.mode == Mode::kCcd) begin_at_end(slot.brings_starts());
      if (spec_.mode == Mode::kDcd) good_ = Good::kSaved;
    }
    slot.place(exec_, scene_.start.data(), scene_.end.data(), !has_frame_);
  }
  void restore() {
    if (good_ != Good::kEnd) copy(scene_.end, good_positions());
    good_ = Good::kEnd;
  }
  /// Of the last good frame.
  const Vec3<Real>* good_positions() const {
    if (good_ == Good::kEnd) return scene_.end.data();
    return good_ == Good::kStart ? scene_.start.data() : scene_.last_good.data();
  }
  /// CCD: a step begins where the last one ended, unless the frame `brings_starts`, which must not overwrite the only
  /// copy of the last good frame.
  void begin_at_end(bool brings_starts) {
    if (brings_starts) copy(scene_.last_good, scene_.end.data());
    copy(scene_.start, scene_.end.data());
    good_ = brings_starts ? Good::kSaved : Good::kStart;
  }
  void copy(Buffer<Vec3<Real>, Exec>& to, const Vec3<Real>* from) {
    exec_.copy(to.data(), from, uint64_t{topology_.vertex_count} * sizeof(Vec3<Real>));
  }

  /// The frame counts from here on; its positions are what a later failure falls back to.
  void commit(Slot& slot) {
    exec_.asks().no_more();
    if (spec_.mode == Mode::kDcd) slot.place(exec_, nullptr, scene_.last_good.data(), false);
    has_frame_ = true;
    good_ = Good::kEnd;
  }

  Topology topology_;
  std::shared_ptr<const SceneShape> shape_;
  const SceneSpec& spec_ = shape_->spec;
  Exec exec_;
  SceneBuffers<Exec, Real> scene_;
  Pipeline<Exec, Real> pipeline_;
  std::shared_ptr<Slot> own_slot_;
  bool has_frame_ = false;
  enum class Good { kEnd, kStart, kSaved };
  Good good_ = Good::kEnd;  ///< which buffer has the last good frame's positions: `end`, `start` or `last_good`
};

template <Executor Exec, class... ExecArgs>
std::unique_ptr<Detector> make_scene_detector(SceneSpec spec, FeatureTables features, ExecArgs... args) {
  return with_real(spec.scalar, [&]<class Real>(Real) -> std::unique_ptr<Detector> {
    return std::make_unique<SceneDetector<Exec, Real>>(std::move(spec), std::move(features), args...);
  });
}

}  // namespace collided
