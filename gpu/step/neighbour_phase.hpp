#pragma once
// Frames that resemble the last (search/neighbours.hpp). A step that makes lists searches with the boxes of all that
// vertices will pass through, wider by the margin, and then goes on as steps that use the lists do: the boxes of this
// frame, a look at whether any vertex has left its track, and the tests of the neighbours.

#include "gpu/search/neighbours.hpp"
#include "gpu/state/context.hpp"

namespace collided {

/// Pairs of features that may touch in the next few frames.
template <Executor Exec, class Real>
struct NeighbourBuffers {
  explicit NeighbourBuffers(Exec& exec)
      : times(exec, "neighbours"),
        tracks(exec, "neighbours"),
        extrapolated(exec, "neighbours"),
        tests{{exec, "neighbours"}, {exec, "neighbours"}},
        counts(exec, "neighbours") {}

  Buffer<TrackTimes, Exec> times;
  Buffer<Track<Real>, Exec> tracks;       ///< of each vertex
  Buffer<Vec3<Real>, Exec> extrapolated;  ///< positions, while lists are made
  Buffer<uint64_t, Exec> tests[2];        ///< of each kind of features
  Buffer<uint64_t, Exec> counts;          ///< of both
};

template <Executor Exec, class Real>
class NeighbourPhase {
 public:
  /// Lists longer than this save nothing.
  static constexpr uint64_t kMaxPerTriangle = 512;

  explicit NeighbourPhase(const StepContext<Exec, Real>& context)
      : context_(context), exec_(context.exec), counts_(context.counts), scene_(context.scene), lists_(context.exec) {}

  /// `times`: of the next step; stays as it is until that is over.
  void reserve(const TrackTimes& times) {
    lists_.times.allocate(1);
    exec_.upload(lists_.times.data(), &times, sizeof(times));
    lists_.tracks.allocate(counts_.vertices);
    lists_.extrapolated.allocate(counts_.vertices);
    lists_.counts.allocate(2);
    for (auto& tests : lists_.tests)
      if (tests.capacity() == 0) tests.allocate(2 * counts_.triangles + first_length(counts_.triangles));
  }
  bool are_too_long(const StepState& need) const {
    return need.neighbours[0] + need.neighbours[1] > kMaxPerTriangle * counts_.triangles + first_length(~0u);
  }
  /// Makes room for what a search found; whether it has to run again.
  bool grow(const StepState& need) {
    bool short_of_room = false;
    for (int kind : {0, 1}) {
      auto& tests = lists_.tests[kind];
      if (need.neighbours[kind] <= tests.capacity()) continue;
      short_of_room = true;
      tests.ensure(need.neighbours[kind]);
    }
    return short_of_room;
  }
  bool holds_memory() const { return lists_.counts.capacity() > 0; }
  void release() { lists_ = NeighbourBuffers<Exec, Real>(exec_); }

  /// Where vertices will be.
  const Vec3<Real>* extrapolate(double frames, bool is_ccd) {
    exec_.for_each(
        "extrapolate", counts_.vertices,
        Extrapolate<Real>{scene_.positions_at_start(is_ccd), scene_.end.data(), frames, lists_.extrapolated.data()});
    return lists_.extrapolated.data();
  }
  AppendList<uint64_t> list(int kind) const { return {lists_.tests[kind].all(), &context_.state()->neighbours[kind]}; }
  /// After the search.
  void keep_counts() { exec_.copy(lists_.counts.data(), context_.state()->neighbours, 2 * sizeof(uint64_t)); }

  /// Boxes and records are those of the frame, here and below.
  template <class Tests>
  void begin_tracks(const Tests& tests) {
    exec_.for_each("begin_tracks", counts_.triangles, BeginTracks<Tests>{tests, lists_.tracks.all()});
  }
  template <class Tests>
  void measure(const Tests& tests, const LevelNeeds& needs) {
    StepState* state = context_.state();
    exec_.reduce_into(
        "displacement", counts_.triangles,
        DisplacementOf<Tests>{tests, scene_.boxes.span(counts_.triangles), lists_.tracks.all(), lists_.times.data(),
                              scene_.topology.idle.has_any() ? scene_.topology.filter() : PairFilter{}},
        Displacement{empty_box(), std::numeric_limits<double>::infinity(), 0}, JoinDisplacements{},
        &state->displacement, PrepareDisplaced{context_.prepare_narrow(needs)});
  }
  template <class Sink>
  void test(const char* name, const Sink& sink) {
    context_.searcher.test(
        name,
        {lists_.tests[0].all(), lists_.tests[1].all(), lists_.counts.data(), &context_.state()->displacement.slack},
        sink);
  }

 private:
  const StepContext<Exec, Real>& context_;
  Exec& exec_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
  NeighbourBuffers<Exec, Real> lists_;
};

}  // namespace collided
