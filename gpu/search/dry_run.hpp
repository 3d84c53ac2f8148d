#pragma once
// The search for pairs where nothing is computed (exec/dry_run.hpp): the memory that it takes on CPU cores.

#include "gpu/exec/dry_run.hpp"
#include "gpu/search/cpu/feature_tests.hpp"
#include "gpu/search/neighbours.hpp"
#include "gpu/search/searcher.hpp"

namespace collided {

template <Backend backend>
class Searcher<DryRun<backend>> {
 public:
  explicit Searcher(DryRun<backend>& exec) : exec_(exec) {}

  void release() { features_ = {exec_, "features"}; }

  template <class Source, class Sink>
  void search(const char*, const Counted&, uint64_t*, const Source& source, const Sink&) {
    reserve<Sink>(source.boxes.size());
  }
  template <class Source, class Sink>
  void walk(const char*, uint64_t triangles, uint64_t*, const Source&, const Sink&) {
    reserve<Sink>(triangles);
  }
  template <class Sink>
  void test(const char*, const Neighbours&, const Sink&) {}

 private:
  template <class Sink>
  void reserve(uint64_t triangles) {
    if constexpr (backend == Backend::kCpu && !Sink::kTakesPairs) features_.ensure(triangles * sizeof(FeatureBoxes));
  }

  DryRun<backend>& exec_;
  Buffer<std::byte, DryRun<backend>> features_{exec_, "features"};
};

}  // namespace collided
