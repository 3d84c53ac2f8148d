#pragma once
// From candidates to contacts at the frame's accuracy level, one kind of features at a time (step 8 of Fig. 7):
// filter, narrow, order, download, exact. A level has those of the stages that it needs.

#include <limits>
#include <vector>

#include "gpu/contact_sets.hpp"
#include "gpu/frame_check.hpp"
#include "gpu/list_filler.hpp"
#include "gpu/narrow/certified_proximity.hpp"
#include "gpu/narrow/coplanarity_filter.hpp"
#include "gpu/narrow/fast_ccd.hpp"
#include "gpu/narrow/gather.hpp"
#include "gpu/narrow/proximity.hpp"
#include "gpu/narrow/triangle_pairs.hpp"
#include "gpu/narrow_kinds.hpp"
#include "gpu/scene_buffers.hpp"

namespace collided {

template <class Exec, class Real>
class NarrowPhase {
 public:
  NarrowPhase(Exec& exec, const SceneSpec& spec, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), spec_(spec), scene_(scene) {}

  /// Before the first kind of a frame. `extent` of the scene scales the filter.
  void begin(const FrameSettings& settings, float extent, FrameResult& result) {
    settings_ = settings;
    result_ = &result;
    const bool is_usual = extent > 0 && extent < std::numeric_limits<float>::max() / 8;
    scale_ = is_usual ? unit_scale(extent) : 1.0f;
    if (settings.report == Report::kAll) return;
    const Shortcut nothing_found{detail::bit_copy<uint64_t>(1.0), 0};
    scene_.shortcut.allocate(1);
    exec_.upload(scene_.shortcut.data(), &nothing_found, sizeof(nothing_found));
  }

  /// Whether the frame's answer is known before all kinds were looked at.
  bool is_over() const { return settings_.report == Report::kAnyHit && result_->any_contact; }

  template <class Kind>
  void detect(const Kind& kind, Span<uint64_t> candidates) {
    const KindTraits& names = traits_of(kind);
    if (settings_.accuracy == Accuracy::kCandidates) return take_candidates(names, candidates);
    Span<const uint64_t> left = candidates;
    if (has_filter()) exec_.stage(names.filter, [&] { left = filter(names, kind, candidates); });
    const auto find = [&](const ContactList<Real>& list) {
      spec_.mode == Mode::kDcd ? run_proximity(kind, left, list) : run_ccd(kind, left, list);
    };
    const auto decide = [&](const std::vector<uint64_t>& keys) { return decide_features(kind, keys); };
    find_and_take(names, find, decide);
  }

  void detect_triangles(Span<const TrianglePair> pairs) {
    const auto find = [&](const ContactList<Real>& list) {
      settings_.accuracy >= Accuracy::kCertified ? run_triangles<double>(pairs, list)
                                                 : run_triangles<float>(pairs, list);
    };
    const auto decide = [&](const std::vector<uint64_t>& keys) { return decide_triangles(keys); };
    find_and_take(kTrianglePairTraits, find, decide);
  }

  /// After the last kind of a frame.
  void finish() {
    FrameResult& r = *result_;
    if (settings_.report == Report::kEarliestOnly) keep_earliest(r);
    if (settings_.report == Report::kAnyHit) return;
    r.earliest_toi = std::min(earliest_toi(r.vertex_triangle), earliest_toi(r.edge_edge));
    const bool finds_features = settings_.accuracy != Accuracy::kCandidates;  // else they are but candidates
    r.any_contact =
        (finds_features && r.vertex_triangle.size() + r.edge_edge.size() > 0) || r.triangle_triangle.size() > 0;
  }

 private:
  bool is_exact() const { return settings_.accuracy == Accuracy::kExact; }
  bool has_filter() const {
    return settings_.accuracy >= (spec_.mode == Mode::kCcd ? Accuracy::kGuarded : Accuracy::kCertified);
  }
  const Vec3<Real>* start() const { return spec_.mode == Mode::kCcd ? scene_.start.data() : scene_.end.data(); }
  const Vec3<Real>* end() const { return scene_.end.data(); }
  ContactSink<Real> sink(const ContactList<Real>& list) const {
    return {list, {scene_.shortcut.data(), settings_.report, is_exact()}};
  }

  // What the level leaves to its narrow phase.
  template <class Kind>
  Span<const uint64_t> filter(const KindTraits& names, const Kind& kind, Span<const uint64_t> candidates) {
    const uint64_t count =
        fill_list(exec_, scene_.survivors, scene_.list_count, result_->replays, [&](const AppendList<uint64_t>& list) {
          if (spec_.mode == Mode::kDcd)
            exec_.for_each("filter_proximity", candidates.size(),
                           FilterProximity<Real, Kind>{end(), spec_.thickness, kind, candidates, list});
          else
            exec_.for_each("filter_coplanarity", candidates.size(),
                           FilterCoplanarity<Real, Kind>{start(),
                                                         end(),
                                                         static_cast<Real>(scale_),
                                                         {scaled_thickness<float>(spec_.thickness, scale_)},
                                                         kind,
                                                         candidates,
                                                         list});
        });
    result_->counts.*names.survivors = count;
    return scene_.survivors.span(count);
  }

  // The narrow phase of each level.
  template <class Kind>
  void run_ccd(const Kind& kind, Span<const uint64_t> candidates, const ContactList<Real>& list) {
    if (settings_.accuracy == Accuracy::kFast)
      exec_.for_each(
          "solve_cubic_ccd", candidates.size(),
          SolveCubicCcd<Real, Kind>{start(), end(), static_cast<Real>(spec_.thickness), kind, candidates, sink(list)});
    else if (settings_.accuracy == Accuracy::kGuarded)
      advance_ccd<float>(kind, candidates, list);
    else
      advance_ccd<double>(kind, candidates, list);
  }
  template <class Work, class Kind>
  void advance_ccd(const Kind& kind, Span<const uint64_t> candidates, const ContactList<Real>& list) {
    exec_.for_each(
        "advance_ccd", candidates.size(),
        AdvanceCcd<Work, Real, Kind>{start(), end(), spec_.thickness, settings_.delta, kind, candidates, sink(list)});
  }
  template <class Kind>
  void run_proximity(const Kind& kind, Span<const uint64_t> candidates, const ContactList<Real>& list) {
    if (settings_.accuracy == Accuracy::kFast)
      exec_.for_each(
          "test_proximity", candidates.size(),
          TestProximity<Real, Kind>{end(), static_cast<Real>(spec_.thickness), kind, candidates, sink(list)});
    else if (settings_.accuracy == Accuracy::kGuarded)
      certify_proximity<float>(kind, candidates, list);
    else
      certify_proximity<double>(kind, candidates, list);
  }
  template <class Work, class Kind>
  void certify_proximity(const Kind& kind, Span<const uint64_t> candidates, const ContactList<Real>& list) {
    exec_.for_each("certify_proximity", candidates.size(),
                   CertifyProximity<Work, Real, Kind>{end(), spec_.thickness, kind, candidates, sink(list)});
  }
  template <class Work>
  void run_triangles(Span<const TrianglePair> pairs, const ContactList<Real>& list) {
    exec_.for_each("test_triangles", pairs.size(),
                   TestTriangles<Work, Real, TrianglePair>{end(), scene_.topology.triangles.all(), pairs, sink(list)});
  }

  /// Runs the narrow phase of a kind and takes what the report wants of it.
  template <class Find, class Decide>
  void find_and_take(const KindTraits& names, const Find& find, const Decide& decide) {
    uint64_t found = 0;
    const bool earliest_only = settings_.report == Report::kEarliestOnly;
    exec_.stage(names.narrow, [&] {
      found = fill_contacts(scene_.contacts, find);
      if (earliest_only) found = keep_early_ones(found);
    });
    if (settings_.report == Report::kAnyHit && is_any_known(found)) return;
    ContactBuffers<Exec, Real>& contacts = earliest_only ? scene_.earliest : scene_.contacts;
    ContactSet& out = result_->*names.contacts;
    exec_.stage(names.order, [&] { order(contacts, found); });
    exec_.stage(names.download, [&] { download(out, contacts, found); });
    if (is_exact()) exec_.stage(names.exact, [&] { settle(out, decide); });
    result_->counts.*names.found = out.size();
    if (settings_.report != Report::kAnyHit) return;
    result_->any_contact = out.size() > 0;
    out = {};
  }

  /// ANY_HIT: whether what was found answers for this kind; at EXACT only a certain contact does.
  bool is_any_known(uint64_t found) {
    result_->any_contact = exec_.read(scene_.shortcut.data()).has_contact != 0;
    return result_->any_contact || found == 0;
  }

  template <class Find>
  uint64_t fill_contacts(ContactBuffers<Exec, Real>& contacts, const Find& find) {
    return fill_list(exec_, contacts.keys, scene_.list_count, result_->replays, [&](const AppendList<uint64_t>& keys) {
      contacts.data.allocate(keys.items.size());
      find(ContactList<Real>{keys, contacts.data.all()});
    });
  }

  uint64_t keep_early_ones(uint64_t found) {
    return fill_contacts(scene_.earliest, [&](const ContactList<Real>& list) {
      exec_.for_each("keep_earliest", found,
                     KeepEarliest<Real>{scene_.contacts.keys.span(found), scene_.contacts.data.span(found),
                                        scene_.shortcut.data(), list});
    });
  }

  void order(ContactBuffers<Exec, Real>& contacts, uint64_t count) {
    contacts.order.ensure(count);
    contacts.sorted.ensure(count);
    exec_.sort_with_order("sort_contacts", contacts.keys.span(count), contacts.order.span(count));
    exec_.for_each(
        "gather_contacts", count,
        GatherContacts<Real>{contacts.order.span(count), contacts.data.span(count), contacts.sorted.span(count)});
  }

  void take_candidates(const KindTraits& names, Span<uint64_t> candidates) {
    exec_.stage(names.order, [&] { exec_.sort("sort_candidates", candidates); });
    exec_.stage(names.download, [&] { download_elements(result_->*names.contacts, candidates); });
  }

  void download_elements(ContactSet& out, Span<const uint64_t> keys) {
    std::vector<uint64_t> host(keys.size());
    exec_.download(host.data(), keys.data, keys.size() * sizeof(uint64_t));
    out.elements.reserve(host.size());
    for (const uint64_t key : host) out.elements.push_back({first_id(key), second_id(key)});
  }
  void download(ContactSet& out, ContactBuffers<Exec, Real>& contacts, uint64_t count) {
    download_elements(out, contacts.keys.span(count));
    std::vector<ContactData<Real>> host(count);
    exec_.download(host.data(), contacts.sorted.data(), count * sizeof(ContactData<Real>));
    const bool is_triangles = &out == &result_->triangle_triangle;
    for (const ContactData<Real>& contact : host) {
      out.flags.push_back(contact.flags);
      if (is_triangles) continue;
      if (spec_.mode == Mode::kCcd) out.toi.push_back(contact.toi);
      out.distance.push_back(contact.distance);
      if (spec_.weights) out.weights.push_back({contact.w0, contact.w1});
    }
  }

  // EXACT: what is left open goes to the host's exact arithmetic.
  template <class Decide>
  void settle(ContactSet& set, const Decide& decide) {
    const std::vector<size_t> places = undecided(set);
    result_->counts.exact_decisions += places.size();
    if (places.empty()) return;
    std::vector<uint64_t> keys;
    for (const size_t i : places) keys.push_back(pack_ids(set.elements[i][0], set.elements[i][1]));
    apply(set, places, decide(keys));
  }

  template <class Kind>
  std::vector<ExactAnswer> decide_features(const Kind& kind, const std::vector<uint64_t>& keys) {
    const auto points = gather<8>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each("gather_points", keys.size(), GatherPoints<Real, Kind>{start(), end(), kind, resident, out});
    });
    return decide_exactly(question(std::is_same_v<Kind, VertexTriangle>), points);
  }
  std::vector<ExactAnswer> decide_triangles(const std::vector<uint64_t>& keys) {
    const auto corners = gather<6>(keys, [&](Span<const uint64_t> resident, Span<Vec3<Real>> out) {
      exec_.for_each("gather_corners", keys.size(),
                     GatherCorners<Real>{end(), scene_.topology.triangles.all(), resident, out});
    });
    return decide_triangles_exactly(question(false), corners);
  }
  ExactQuestion question(bool vertex_triangle) const {
    return {vertex_triangle, spec_.mode == Mode::kCcd, spec_.thickness, spec_.threads, exec_.cancelled};
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

  Exec& exec_;
  const SceneSpec& spec_;
  SceneBuffers<Exec, Real>& scene_;
  FrameSettings settings_{};
  FrameResult* result_ = nullptr;
  float scale_ = 1;
};

}  // namespace collided
