#pragma once
// The search for pairs on a GPU: pair_search.cuh and tree_walk.cuh find them, pair_queues.cuh takes them;
// neighbour_tests.cuh tests those that are known.

#include "gpu/exec/cuda/cuda_exec.cuh"
#include "gpu/search/cuda/neighbour_tests.cuh"
#include "gpu/search/cuda/pair_search.cuh"
#include "gpu/search/cuda/tree_walk.cuh"
#include "gpu/search/searcher.hpp"

namespace collided {

template <>
class Searcher<CudaExec> {
 public:
  explicit Searcher(CudaExec& exec) : exec_(exec) {}

  void release() {}

  template <class Source, class Sink>
  void search(const char* name, const Counted& items, uint64_t* next, const Source& source, const Sink& sink) {
    if (items.most == 0) return;
    const unsigned blocks = exec_.resident_blocks(name, pair_search_kernel<Source, Sink>, kSearchBlock);
    exec_.launch(name, pair_search_kernel<Source, Sink>, blocks, kSearchBlock, items, next, exec_.stop(), source, sink);
  }

  template <class Source, class Sink>
  void walk(const char* name, uint64_t items, uint64_t* next, const Source& source, const Sink& sink) {
    if (items == 0) return;
    const unsigned blocks = std::min(CudaExec::blocks_for(items, kSearchBlock / 32 * kFewestWalks),
                                     exec_.resident_blocks(name, tree_walk_kernel<Source, Sink>, kSearchBlock));
    exec_.launch(name, tree_walk_kernel<Source, Sink>, blocks, kSearchBlock, items, next, exec_.stop(), source, sink);
  }

  template <class Sink>
  void test(const char* name, const Neighbours& neighbours, const Sink& sink) {
    const unsigned blocks = exec_.resident_blocks(name, neighbour_test_kernel<Sink>, kSearchBlock);
    exec_.launch(name, neighbour_test_kernel<Sink>, blocks, kSearchBlock, neighbours, exec_.stop(), sink);
  }

 private:
  CudaExec& exec_;
};

}  // namespace collided
