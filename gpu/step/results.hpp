#pragma once
// From a step that is over to the frame's result on the host: download, exact decisions, what the report wants.

#include <algorithm>
#include <memory>
#include <vector>

#include "gpu/exact/poll.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/normal.hpp"
#include "gpu/step/answer_room.hpp"
#include "gpu/step/buffers.hpp"
#include "gpu/step/columns_on_host.hpp"
#include "gpu/step/contact_sets.hpp"
#include "gpu/step/level_needs.hpp"

namespace collided {

template <Executor Exec, class Real>
class Results {
 public:
  Results(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene)
      : exec_(exec),
        spec_(spec),
        scene_(scene),
        room_(std::make_shared<AnswerRoom>(spec.memory_quota, &Exec::host_block)) {}
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;
  ~Results() { room_->close(); }

  /// Bytes of the host that are held for answers.
  uint64_t answer_bytes() const { return room_->bytes(); }

  /// `bytes_beside_contact`: as in FrameInput.
  void collect(const StepState& step, const LevelNeeds& needs, uint64_t bytes_beside_contact, FrameResult& result) {
    needs_ = needs;
    bytes_beside_contact_ = bytes_beside_contact;
    result_ = &result;
    if (needs_.is_any_hit() && (!needs_.is_exact() || step.shortcut.has_contact != 0)) {
      result.any_contact = step.shortcut.has_contact != 0;
      return;
    }
    exec_.stage("download", [&] { download(needs_.is_earliest_only() ? step.earliest : step.contacts, step.kinds); });
    if (needs_.is_exact()) exec_.stage("exact", [&] { settle_all(); });
    report();
  }

 private:
  static constexpr size_t kSettledAtATime = 1u << 14;  ///< contacts, whose points take memory

  void download(uint64_t count, const KindBegins& kinds) {
    const ContactColumns columns = scene_.columns.columns(needs_.columns());
    if (count == 0) return;
    ColumnsOnHost host(columns, count);
    host.take(*room_, count * bytes_beside_contact_);
    host.for_each([&](std::byte* to, const void* from, uint64_t bytes) { exec_.download_async(to, from, bytes); });
    exec_.wait();
    result_->held = host.memory();
    for_each_kind(
        [&](ContactKind kind, ContactSet& set) {
          const int k = index_of(kind);
          const uint64_t end = k + 1 < static_cast<int>(kContactKinds) ? kinds.at[k + 1] : count;
          set = host.contacts(kinds.at[k], end, needs_.fields_of(kind));
        },
        contacts());
  }
  PerKind<ContactSet>& contacts() { return *result_; }

  // EXACT: what is left open goes to the host's exact arithmetic.
  void settle_all() {
    FeatureKinds::of(scene_.topology).for_each([&]<class Kind>(const Kind& kind) {
      settle(value_of(contacts(), Kind::kKind), [&](const auto& keys, ExactAnswer* answers, Normal* normals) {
        decide_features(kind, keys, answers, normals);
      });
    });
    settle(result_->triangle_triangle,
           [&](const auto& keys, ExactAnswer* answers, Normal*) { decide_triangles(keys, answers); });
  }
  static uint64_t settling_bytes(size_t count) {
    constexpr size_t kPoints = 8 * (sizeof(Vec3<Real>) + sizeof(Vec3<double>)) + sizeof(uint64_t);
    return count * (sizeof(size_t) + sizeof(ExactAnswer) + sizeof(Normal)) + std::min(count, kSettledAtATime) * kPoints;
  }
  template <class Decide>
  void settle(ContactSet& set, const Decide& decide) {
    if (needs_.is_any_hit() && result_->any_contact) return;
    CpuLoops& loops = exec_.host_loops();
    MemoryHold held(spec_.memory_quota);
    const size_t count = count_undecided(loops, set);
    held.resize(settling_bytes(count));
    const std::vector<size_t> places = undecided(loops, set, count);
    result_->counts.exact_decisions += count;
    std::vector<ExactAnswer> answers(places.size());
    std::vector<Normal> normals(set.normals.empty() ? 0 : places.size());
    std::vector<uint64_t> keys;
    for (size_t first = 0; first < places.size(); first += kSettledAtATime) {
      keys.clear();
      for (size_t k = first; k < std::min(places.size(), first + kSettledAtATime); ++k)
        keys.push_back(pack_ids(set.elements[places[k]][0], set.elements[places[k]][1]));
      decide(keys, answers.data() + first, normals.empty() ? nullptr : normals.data() + first);
    }
    if (!places.empty()) apply(loops, set, places, answers, normals);
    result_->any_contact = result_->any_contact || set.size() > 0;
  }

  template <class Kind>
  void decide_features(const Kind& kind, const std::vector<uint64_t>& keys, ExactAnswer* answers, Normal* normals) {
    const auto points = gather<8>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each(
          "gather_points", keys.size(),
          GatherPoints<Real, Kind>{scene_.positions_at_start(needs_.is_ccd()), scene_.end.data(), kind, resident, out});
    });
    const ExactQuestion question{Kind::kKind, needs_.is_ccd(), needs_.settings.thickness};
    decide_all(keys.size(), [&](uint64_t i) {
      answers[i] = decide_exactly(question, points[i]);
      if (normals != nullptr) normals[i] = normal_at<Kind>(points[i], answers[i].toi);
    });
  }
  template <class Kind>
  static Normal normal_at(const ExactPoints& p, double toi) {
    return contact_normal<Kind>(FeaturePoints<double>{{p[0], p[1], p[2], p[3]}, {p[4], p[5], p[6], p[7]}}, toi, kClear);
  }
  void decide_triangles(const std::vector<uint64_t>& keys, ExactAnswer* answers) {
    const auto corners = gather<6>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each("gather_corners", keys.size(),
                     GatherCorners<Real>{scene_.end.data(), scene_.topology.triangles.all(), resident, out});
    });
    decide_all(keys.size(), [&](uint64_t i) { answers[i] = decide_triangles_exactly(corners[i]); });
  }
  /// decide(i) for i in [0, count): each takes microseconds, or much longer where exponents lie far apart.
  template <class Decide>
  void decide_all(uint64_t count, const Decide& decide) {
    exec_.host_loops().share(count, 1, [&](LoopTurn& turn) {
      const exact::PollScope poll([&] { turn.look_up(); });
      try {
        while (ItemRange* left = turn.next()) {
          decide(left->first);
          ++left->first;
        }
      } catch (const LeftUndone&) {
      }
    });
  }

  /// Brings the points of some pairs, n each, to the host.
  template <size_t n, class Run>
  std::vector<std::array<Vec3<double>, n>> gather(const std::vector<uint64_t>& keys, const Run& run) {
    scene_.exact_keys.ensure(keys.size());
    scene_.exact_points.ensure(n * keys.size());
    exec_.upload(scene_.exact_keys.data(), keys.data(), keys.size() * sizeof(uint64_t));
    run(scene_.exact_keys.span(keys.size()), scene_.exact_points.span(n * keys.size()));
    std::vector<Vec3<Real>> host(n * keys.size());
    exec_.download(host.data(), scene_.exact_points.data(), host.size() * sizeof(Vec3<Real>));
    std::vector<std::array<Vec3<double>, n>> out(keys.size());
    for (size_t i = 0; i < host.size(); ++i) out[i / n][i % n] = convert<double>(host[i]);
    return out;
  }

  void report() {
    FrameResult& r = *result_;
    for_each_kind(
        [&](ContactKind kind, const ContactSet& set, uint64_t& count) {
          if (needs_.tests(kind)) count = set.size();
          r.any_contact = r.any_contact || count > 0;
        },
        contacts(), r.counts.contacts);
    if (needs_.is_earliest_only()) keep_earliest(exec_.host_loops(), contacts());
    if (needs_.is_any_hit()) {
      contacts() = {};
      r.held = nullptr;
      return;
    }
    r.earliest_toi = earliest_toi(exec_.host_loops(), contacts(), needs_.settings.ignore_separating);
  }

  Exec& exec_;
  const SceneSpec& spec_;
  SceneBuffers<Exec, Real>& scene_;
  const std::shared_ptr<AnswerRoom> room_;
  LevelNeeds needs_;
  uint64_t bytes_beside_contact_ = 0;
  FrameResult* result_ = nullptr;
};

}  // namespace collided
