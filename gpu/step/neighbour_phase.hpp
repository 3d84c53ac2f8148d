#pragma once
// Frames that resemble the last (search/neighbours.hpp). A step that makes lists searches with the boxes of all that
// vertices will pass through, wider by the margin, and then goes on as steps that use the lists do: the boxes of this
// frame, a look at whether any vertex has left its track, and the tests of the neighbours.

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/search/searcher.hpp"
#include "gpu/step/buffers.hpp"
#include "gpu/step/sinks.hpp"

namespace collided {

template <Executor Exec, class Real>
class NeighbourPhase {
 public:
  /// Lists longer than this save nothing.
  static constexpr uint64_t kMaxPerTriangle = 512;

  NeighbourPhase(Exec& exec, Searcher<Exec>& searcher, const SceneCounts& counts, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), searcher_(searcher), counts_(counts), scene_(scene) {}

  /// `times`: of the next step; stays as it is until that is over.
  void reserve(const TrackTimes& times) {
    lists().times.allocate(1);
    exec_.upload(lists().times.data(), &times, sizeof(times));
    lists().tracks.allocate(counts_.vertices);
    lists().extrapolated.allocate(counts_.vertices);
    lists().counts.allocate(2);
    for (auto& tests : lists().tests)
      if (tests.capacity() == 0) tests.allocate(2 * counts_.triangles + first_length(counts_.triangles));
  }
  bool are_too_long(const StepState& need) const {
    return need.neighbours[0] + need.neighbours[1] > kMaxPerTriangle * counts_.triangles + first_length(~0u);
  }
  /// Makes room for what a search found; whether it has to run again.
  bool grow(const StepState& need) {
    bool short_of_room = false;
    for (int kind : {0, 1}) {
      auto& tests = lists().tests[kind];
      if (need.neighbours[kind] <= tests.capacity()) continue;
      short_of_room = true;
      tests.ensure(need.neighbours[kind]);
    }
    return short_of_room;
  }
  void release() { lists() = NeighbourBuffers<Exec, Real>(exec_); }

  /// Where vertices will be.
  const Vec3<Real>* extrapolate(double frames, bool is_ccd) {
    exec_.for_each(
        "extrapolate", counts_.vertices,
        Extrapolate<Real>{scene_.positions_at_start(is_ccd), scene_.end.data(), frames, lists().extrapolated.data()});
    return lists().extrapolated.data();
  }
  AppendList<uint64_t> list(int kind) const {
    return {lists().tests[kind].all(), &scene_.state.data()->neighbours[kind]};
  }
  /// After the search.
  void keep_counts() { exec_.copy(lists().counts.data(), scene_.state.data()->neighbours, 2 * sizeof(uint64_t)); }

  /// Boxes and records are those of the frame, here and below.
  template <class Tests>
  void begin_tracks(const Tests& tests) {
    exec_.for_each("begin_tracks", counts_.triangles, BeginTracks<Tests>{tests, lists().tracks.all()});
  }
  template <class Tests>
  void measure(const Tests& tests, double thickness, bool is_ccd) {
    StepState* state = scene_.state.data();
    exec_.reduce_into(
        "displacement", counts_.triangles,
        DisplacementOf<Tests>{tests, scene_.boxes.span(counts_.triangles), lists().tracks.all(), lists().times.data(),
                              scene_.topology.idle.has_any() ? scene_.topology.filter() : PairFilter{}},
        Displacement{empty_box(), std::numeric_limits<double>::infinity(), 0}, JoinDisplacements{},
        &state->displacement, PrepareDisplaced{{state, thickness, scene_.deviations(is_ccd)}});
  }
  template <class Sink>
  void test(const char* name, const Sink& sink) {
    searcher_.test(name,
                   {lists().tests[0].all(), lists().tests[1].all(), lists().counts.data(),
                    &scene_.state.data()->displacement.slack},
                   sink);
  }

 private:
  NeighbourBuffers<Exec, Real>& lists() const { return scene_.neighbours; }

  Exec& exec_;
  Searcher<Exec>& searcher_;
  const SceneCounts& counts_;
  SceneBuffers<Exec, Real>& scene_;
};

}  // namespace collided
