#pragma once
// From a step that is over to the frame's result on the host: download, exact decisions, what the report wants.

#include <algorithm>
#include <memory>
#include <vector>

#include "gpu/contacts/answer_room.hpp"
#include "gpu/contacts/columns_on_host.hpp"
#include "gpu/exact/closest_features.hpp"
#include "gpu/exact/poll.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/normal.hpp"
#include "gpu/state/buffers.hpp"
#include "gpu/state/level_needs.hpp"
#include "gpu/step/contact_sets.hpp"
#include "gpu/step/cover_phase.hpp"
#include "gpu/step/pair_states.hpp"
#include "gpu/step/placing.hpp"

namespace collided {

/// Of the work until there are contacts.
inline FrameCounts counts_of(const StepState& state, const LevelNeeds& needs) {
  FrameCounts c;
  const LeafTotals& leaves = state.leaves;
  c.cells = leaves[LeafSum::kCells], c.leaves = leaves[LeafSum::kLeaves];
  c.registrations = leaves[LeafSum::kRegistrations], c.tests = leaves[LeafSum::kTests];
  c.top_level = static_cast<uint32_t>(state.grid.grid.top);
  c.base_level = static_cast<uint32_t>(state.grid.grid.base);
  c.pairs = state.pairs;
  for_each_kind(
      [&](ContactKind kind, uint64_t& candidates, uint64_t& survivors) {
        if (!is_of_features(kind)) return;
        candidates = state.candidates[index_of(kind)];
        if (!needs.has_filter()) return;
        survivors = needs.advances ? state.filtered[index_of(kind)] : state.kept[index_of(kind)];
      },
      c.candidates, c.survivors);
  return c;
}

/// What is brought to the host.
struct HostNeeds {
  uint64_t bytes_beside_contact = 0;  ///< as in FrameInput
  uint64_t first = 0;                 ///< contacts of each kind that stay on the backend
};

template <Executor Exec, class Real>
class Results {
 public:
  Results(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene, Placing<Exec, Real>& placing)
      : exec_(exec),
        spec_(spec),
        scene_(scene),
        cover_(exec, scene),
        placing_(placing),
        room_(std::make_shared<AnswerRoom>(spec.memory_quota,
                                           [&exec](uint64_t bytes) { return exec.host_block(bytes); })) {}
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;
  ~Results() { room_->close(); }

  /// Bytes of the host that are held for answers.
  uint64_t answer_bytes() const { return room_->bytes(); }

  /// Brings `count` pairs that limit the ways, which lie in the scene's buffers in canonical order, to the host.
  PerKind<ContactSet> limits(const KindBegins& kinds, uint64_t count, uint64_t bytes_beside_contact) {
    const ColumnsOnHost host =
        bring(scene_.limits.columns.columns(kFieldsOfLimits), 0, count, count * bytes_beside_contact);
    exec_.wait();
    PerKind<ContactSet> limits;
    for_each_kind(
        [&](ContactKind kind, ContactSet& set) {
          set = host.contacts(kinds.at[index_of(kind)], end_of(kind, kinds, count), kFieldsOfLimits);
        },
        limits);
    return limits;
  }

  void collect(const StepState& step, const LevelNeeds& needs, const HostNeeds& host, FrameResult& result) {
    needs_ = needs;
    host_ = host;
    result_ = &result;
    is_settled_ = false;
    crossings_ = {};
    ties_.clear();
    if (needs_.is_any_hit() && (!needs_.settles() || step.shortcut.has_contact != 0)) {
      result.any_contact = step.shortcut.has_contact != 0;
      return;
    }
    const uint64_t found = needs_.is_earliest_only() ? step.earliest : step.contacts;
    if (needs_.places_contacts()) return collect_placed(step, found);
    exec_.stage("download", [&] { download(0, found, step.kinds); });
    if (needs_.is_exact()) settle_all(step);
    if (needs_.tests_crossings()) exec_.stage("exact", [&] { settle_crossings(); });
    if (needs_.tells_features) settle_covered(step);
    crossings_ = result.edge_triangle;
    if (!spec_.kinds.edge_triangle) result.edge_triangle = {};
    report();
  }
  /// Puts contacts that the host has decided where they are to stay.
  void place() {
    if (needs_.keeps_contacts() && !needs_.places_contacts()) exec_.stage("place", [&] { place_settled(); });
  }
  /// Returns `count` vertices in solids, which lie in these columns, on the host. Their memory is held by themselves.
  ContactSet bring_inside(const ContactColumns& columns, uint64_t count) {
    const ColumnsOnHost host = bring(columns, 0, count, count * host_.bytes_beside_contact);
    exec_.wait();
    return host.contacts(0, count, needs_.fields_of(ContactKind::kVertexSolid));
  }
  /// Returns the first contacts of a kind, as many as are to come to the host besides those that stay on the backend.
  uint64_t first_on_host() const { return host_.first; }
  /// Edges that go through triangles, in a frame that looks for them, whoever asks.
  const ContactSet& crossings() const { return crossings_; }
  /// Edges and triangles with a point in common whose relation is a tie, some crossings among them.
  const std::vector<EdgeAndTriangle>& ties() const { return ties_; }

 private:
  static constexpr size_t kSettledAtATime = 1u << 14;  ///< contacts, whose points take memory

  /// Contacts [begin, end) of the list.
  void download(uint64_t begin, uint64_t end, const KindBegins& kinds) {
    if (begin == end) return;
    const ColumnsOnHost host = bring(columns(), begin, end, (end - begin) * host_.bytes_beside_contact);
    exec_.wait();
    result_->held = host.memory();
    for_each_kind(
        [&](ContactKind kind, ContactSet& set) {
          set = host.contacts(std::clamp(kinds.at[index_of(kind)], begin, end),
                              std::clamp(end_of(kind, kinds, end), begin, end), needs_.fields_of(kind));
        },
        contacts());
  }
  /// Returns those of the step.
  ContactColumns columns() const { return scene_.columns.columns(needs_.columns()); }
  /// They are there after wait(). `beside`: as AnswerRoom has it.
  ColumnsOnHost bring(const ContactColumns& columns, uint64_t begin, uint64_t end, uint64_t beside) {
    ColumnsOnHost host(columns, begin, end);
    host.take(*room_, beside);
    host.for_each([&](std::byte* to, const void* from, uint64_t bytes) { exec_.download_async(to, from, bytes); });
    return host;
  }
  static uint64_t end_of(ContactKind kind, const KindBegins& kinds, uint64_t count) {
    const size_t next = static_cast<size_t>(index_of(kind)) + 1;
    return next < kContactKinds ? kinds.at[next] : count;
  }
  PerKind<ContactSet>& contacts() { return *result_; }

  /// The step has placed its contacts; those without room, and the first if they are wanted, are brought here.
  void collect_placed(const StepState& step, uint64_t found) {
    count(step.kinds, found);
    if (needs_.has_times()) result_->earliest_toi = step.earliest_toi;
    const uint64_t listed = placing_.most_listed(needs_, found);
    const ContactLayout layout = placing_.layout(needs_, step.kinds, listed);
    tell(layout);
    if (layout.count == listed && host_.first == 0) return;
    exec_.stage("download", [&] {
      download(layout.count, listed, step.kinds);
      if (host_.first > 0) download_first(step.kinds, listed);
    });
  }
  void count(const KindBegins& kinds, uint64_t found) {
    for_each_kind(
        [&](ContactKind kind, uint64_t& count) {
          if (!needs_.tests(kind)) return;
          count = end_of(kind, kinds, found) - kinds.at[index_of(kind)];
          result_->any_contact = result_->any_contact || count > 0;
        },
        result_->counts.contacts);
  }
  void download_first(const KindBegins& kinds, uint64_t listed) {
    for_each_kind(
        [&](ContactKind kind, ContactSet& set) {
          const uint64_t begin = std::min(kinds.at[index_of(kind)], listed),
                         all = std::min(end_of(kind, kinds, listed), listed) - begin,
                         end = begin + std::min(all, host_.first);
          if (begin < end) set = bring(columns(), begin, end, 0).contacts(begin, end, needs_.fields_of(kind));
        },
        result_->first);
    exec_.wait();
  }
  void tell(const ContactLayout& layout) {
    for_each_kind(
        [&](ContactKind kind, PlacedContacts& placed) {
          const KindLayout& of_kind = layout.kinds[index_of(kind)];
          const auto range = [&](int array) {
            return ArrayRange{of_kind.at[array], of_kind.count * needs_.widths.of[index_of(kind)][array]};
          };
          placed.count = of_kind.count;
          for_each_field([&](ContactField field, ArrayRange& array) { array = range(index_of(field)); }, placed);
          placed.stencils = range(kStencilArray);
        },
        result_->placed);
  }

  /// What was decided on the host goes back to where the step left it. Returns where the kinds begin, and how many
  /// contacts there are.
  std::pair<KindBegins, uint64_t> send_back() {
    KindBegins kinds = {};
    uint64_t count = 0;
    for_each_kind(
        [&](ContactKind kind, const ContactSet& set) {
          kinds.at[index_of(kind)] = count;
          send(set, count);
          count += set.size();
        },
        contacts());  // vertices in solids are not among them yet
    StepState* state = scene_.state.data();
    exec_.upload(&state->kinds, &kinds, sizeof(kinds));
    exec_.upload(needs_.is_earliest_only() ? &state->earliest : &state->contacts, &count, sizeof(count));
    exec_.wait();
    return {kinds, count};
  }
  /// The same, and on to its room from there.
  void place_settled() {
    const auto [kinds, count] = send_back();
    placing_.place(needs_);
    exec_.wait();
    const ContactLayout layout = placing_.layout(needs_, kinds, count);
    tell(layout);
    for_each_kind(
        [&](ContactKind kind, ContactSet& set, ContactSet& first) {
          first = set;
          for_each_field([&](ContactField, auto& column) { column.truncate(host_.first); }, first);
          const uint64_t placed = layout.kinds[index_of(kind)].count;
          for_each_field([&](ContactField, auto& column) { column.skip(std::min(placed, column.size())); }, set);
        },
        contacts(), result_->first);
  }
  /// To place `begin` of the columns and after.
  void send(const ContactSet& set, uint64_t begin) {
    for_each_field(
        [&](ContactField, const auto& column, auto& resident) {
          if (!column.empty())
            exec_.upload(resident.data() + begin, column.data(), column.size() * sizeof(*column.data()));
        },
        set, scene_.columns);
  }

  // Features, and contacts that others cover.
  /// The step has told them, but for what only the host can decide: that may be what covers a contact.
  void settle_covered(const StepState& step) {
    if (is_settled_ || step.open_features > 0) exec_.stage("cover", [&] { cover_anew(step.open_features > 0); });
  }
  void cover_anew(bool has_open) {
    if (has_open)
      FeatureKinds::of(scene_.topology).for_each([&]<class Kind>(const Kind& kind) {
        tell_features(kind, value_of(contacts(), Kind::kKind));
      });
    const KindBegins kinds = send_back().first;
    cover_.run(needs_, true);
    for_each_kind(
        [&](ContactKind kind, ContactSet& set) {
          const auto bring = [&](auto& column, const auto& resident) {
            if (!column.empty())
              exec_.download_async(column.data(), resident.data() + kinds.at[index_of(kind)],
                                   column.size() * sizeof(*column.data()));
          };
          bring(set.features, scene_.columns.features);
          bring(set.flags, scene_.columns.flags);
          bring(set.weights, scene_.columns.weights);
        },
        contacts());
    exec_.wait();
  }
  /// Those that double precision has left open.
  template <class Kind>
  void tell_features(const Kind& kind, ContactSet& set) {
    std::vector<size_t> places;
    for (size_t i = 0; i < set.features.size(); ++i)
      if ((set.features[i] & kFeaturesOpen) != 0) places.push_back(i);
    MemoryHold held(spec_.memory_quota);
    held.resize(settling_bytes(places.size()));
    result_->counts.exact_decisions += places.size();
    for_each_keys(set, places, places.size(), [&](const std::vector<uint64_t>& keys, size_t first) {
      std::vector<uint32_t> ids(4 * keys.size());
      const auto points = gather<8>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
        const Vec3<Real>* positions = scene_.end.data();
        scene_.exact_ids.ensure(ids.size());
        exec_.for_each("gather_points", keys.size(),
                       GatherPoints<Real, Kind>{positions, positions, kind, resident, out});
        exec_.for_each("gather_stencils", keys.size(), GatherStencils<Kind>{kind, resident, scene_.exact_ids.all()});
        exec_.download(ids.data(), scene_.exact_ids.data(), ids.size() * sizeof(uint32_t));
      });
      decide_all(keys.size(), [&](uint64_t k) {
        const auto& p = points[k];
        const uint32_t* of = ids.data() + 4 * k;
        set.features[places[first + k]] =
            exact_closest_features(Kind::kKind, {p[0], p[1], p[2], p[3]}, {of[0], of[1], of[2], of[3]});
      });
    });
  }

  // EXACT: what is left open goes to the host's exact arithmetic, but for contacts on arcs.
  void settle_all(const StepState& step) {
    result_->counts.exact_decisions = step.exact_decisions;
    const bool features = !needs_.decides_in_step() || step.undecided > 0;
    if (features || needs_.tests_triangles())
      exec_.stage("exact", [&] {
        if (features) settle_features();
        settle_triangles();
      });
    if (scene_.deviations(needs_.is_ccd()).is_needed())
      for_each_kind([&](ContactKind, ContactSet& set) { take_marks(exec_.host_loops(), set); }, contacts());
  }
  void settle_features() {
    FeatureKinds::of(scene_.topology).for_each([&]<class Kind>(const Kind& kind) {
      const size_t count =
          settle(value_of(contacts(), Kind::kKind), [&](const auto& keys, ExactAnswer* answers, Normal* normals) {
            decide_features(kind, keys, answers, normals);
          });
      if (!needs_.decides_in_step()) result_->counts.exact_decisions += count;
    });
  }
  void settle_triangles() {
    result_->counts.exact_decisions +=
        settle(result_->triangle_triangle,
               [&](const auto& keys, ExactAnswer* answers, Normal*) { decide_triangles(keys, answers); });
  }
  uint64_t settling_bytes(size_t count) const {
    constexpr size_t kAnswer = std::max(sizeof(ExactAnswer) + sizeof(Normal), sizeof(EdgeTriangleVerdict));
    const size_t halves = needs_.settings.differs_by_pair() ? sizeof(PairHalves) : 0,
                 points = 8 * (sizeof(Vec3<Real>) + sizeof(Vec3<double>)) + sizeof(uint64_t) + halves;
    return count * (sizeof(size_t) + kAnswer) + std::min(count, kSettledAtATime) * points;
  }
  /// Returns how many were decided.
  template <class Decide>
  size_t settle(ContactSet& set, const Decide& decide) {
    std::vector<ExactAnswer> answers;
    std::vector<Normal> normals;
    return settle(
        set,
        [&](size_t count) {
          answers.resize(count);
          if (needs_.is_ccd()) normals.resize(set.normals.empty() ? 0 : count);  // those of DCD stay
        },
        [&](const auto& keys, size_t first) {
          decide(keys, answers.data() + first, normals.empty() ? nullptr : normals.data() + first);
        },
        [&](const auto& places) { apply(exec_.host_loops(), set, places, answers, normals); });
  }
  /// Those in doubt, ties among them. A tie in which they meet is a contact, even if it is told as no crossing.
  void settle_crossings() {
    ContactSet& set = result_->edge_triangle;
    const bool had_contact = result_->any_contact;
    std::vector<EdgeTriangleVerdict> verdicts;
    result_->counts.exact_decisions += settle(
        set, [&](size_t count) { verdicts.resize(count); },
        [&](const auto& keys, size_t first) { decide_crossings(keys, verdicts.data() + first); },
        [&](const auto& places) {
          if (needs_.looks_into_solids) list_ties(set, places, verdicts);
          apply(exec_.host_loops(), set, places, verdicts);
        });
    for (const EdgeTriangleVerdict& verdict : verdicts) result_->any_contact = result_->any_contact || verdict.meets;
    if (!spec_.kinds.edge_triangle) result_->any_contact = had_contact;  // nobody asks
  }
  void list_ties(const ContactSet& set, const std::vector<size_t>& places,
                 const std::vector<EdgeTriangleVerdict>& verdicts) {
    for (size_t k = 0; k < places.size(); ++k)
      if (verdicts[k].meets) ties_.push_back(set.elements[places[k]]);
  }
  /// begin(count of what is undecided), then decide(keys, index of the first), then apply(places).
  template <class Begin, class Decide, class Apply>
  size_t settle(ContactSet& set, const Begin& begin, const Decide& decide, const Apply& apply) {
    if (needs_.is_any_hit() && result_->any_contact) return 0;
    CpuLoops& loops = exec_.host_loops();
    MemoryHold held(spec_.memory_quota);
    const size_t count = count_undecided(loops, set);
    is_settled_ = is_settled_ || count > 0;
    held.resize(settling_bytes(count));
    const std::vector<size_t> places = undecided(loops, set, count);
    begin(places.size());
    for_each_keys(set, places, count_open(set, places), decide);
    if (!places.empty()) apply(places);
    result_->any_contact = result_->any_contact || set.size() > 0;
    return count;
  }

  /// use(keys, index of the first) for the contacts at the first `count` places, a bounded number at a time.
  template <class Use>
  static void for_each_keys(const ContactSet& set, const std::vector<size_t>& places, size_t count, const Use& use) {
    std::vector<uint64_t> keys;
    for (size_t first = 0; first < count; first += kSettledAtATime) {
      keys.clear();
      for (size_t k = first; k < std::min(count, first + kSettledAtATime); ++k)
        keys.push_back(pack_ids(set.elements[places[k]][0], set.elements[places[k]][1]));
      use(keys, first);
    }
  }

  template <class Kind>
  void decide_features(const Kind& kind, const std::vector<uint64_t>& keys, ExactAnswer* answers, Normal* normals) {
    const auto points = gather<8>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each(
          "gather_points", keys.size(),
          GatherPoints<Real, Kind>{scene_.positions_at_start(needs_.is_ccd()), scene_.end.data(), kind, resident, out});
    });
    const std::vector<PairHalves> halves = gather_halves(kind, keys.size());
    decide_all(keys.size(), [&](uint64_t i) {
      ExactQuestion question{Kind::kKind, needs_.is_ccd(), needs_.settings.thickness};
      if (!halves.empty()) question.limit = {needs_.settings.thickness, halves[i].first, halves[i].second};
      answers[i] = decide_exactly(question, points[i]);
      if (normals != nullptr) normals[i] = normal_at<Kind>(points[i], answers[i].toi);
    });
  }
  /// Returns those of the pairs whose points were gathered last; none where all pairs have one distance.
  template <class Kind>
  std::vector<PairHalves> gather_halves(const Kind& kind, size_t count) {
    const HalfThicknesses halves = scene_.halves(needs_.settings);
    if (!halves.is_needed()) return {};
    scene_.exact_halves.ensure(count);
    exec_.for_each("gather_halves", count,
                   GatherHalves<Kind>{halves, kind, scene_.exact_keys.span(count), scene_.exact_halves.span(count)});
    std::vector<PairHalves> host(count);
    exec_.download(host.data(), scene_.exact_halves.data(), count * sizeof(PairHalves));
    return host;
  }
  template <class Kind>
  static Normal normal_at(const ExactPoints& p, double toi) {
    return contact_normal<Kind>(FeaturePoints<double>{{p[0], p[1], p[2], p[3]}, {p[4], p[5], p[6], p[7]}}, toi, kClear);
  }
  void decide_triangles(const std::vector<uint64_t>& keys, ExactAnswer* answers) {
    std::vector<uint32_t> common(keys.size());
    const auto corners = gather<6>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      scene_.exact_ids.ensure(common.size());
      exec_.for_each(
          "gather_corners", keys.size(),
          GatherCorners<Real>{scene_.end.data(), scene_.topology.corners(), resident, out, scene_.exact_ids.all()});
      exec_.download(common.data(), scene_.exact_ids.data(), common.size() * sizeof(uint32_t));
    });
    decide_all(keys.size(), [&](uint64_t i) { answers[i] = decide_triangles_exactly(corners[i], common[i] != 0); });
  }
  void decide_crossings(const std::vector<uint64_t>& keys, EdgeTriangleVerdict* verdicts) {
    std::vector<uint32_t> ids(5 * keys.size());
    const auto points = gather<5>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      scene_.exact_ids.ensure(ids.size());
      exec_.for_each("gather_edge_triangles", keys.size(),
                     GatherEdgeTriangles<Real>{scene_.end.data(), scene_.topology.edge_ends(),
                                               scene_.topology.corners(), resident, out, scene_.exact_ids.all()});
      exec_.download(ids.data(), scene_.exact_ids.data(), ids.size() * sizeof(uint32_t));
    });
    decide_all(keys.size(), [&](uint64_t i) {
      const auto& p = points[i];
      const Vec3<double> of_pair[5] = {p[0], p[1], p[2], p[3], p[4]};
      const uint32_t* of = ids.data() + 5 * i;
      verdicts[i] = exact_edge_triangle(of_pair, {of[0], of[1], of[2], of[3], of[4]});
    });
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
  CoverPhase<Exec, Real> cover_;
  Placing<Exec, Real>& placing_;
  const std::shared_ptr<AnswerRoom> room_;
  LevelNeeds needs_;
  HostNeeds host_;
  FrameResult* result_ = nullptr;
  bool is_settled_ = false;  ///< the host has decided of some contacts
  ContactSet crossings_;
  std::vector<EdgeAndTriangle> ties_;
};

}  // namespace collided
