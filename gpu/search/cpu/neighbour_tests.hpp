#pragma once
// On CPU cores: the boxes of neighbours, as they are in this step, and what of them goes to the sink's lists.

#include "gpu/contacts/kinds.hpp"
#include "gpu/search/cpu/list_writer.hpp"
#include "gpu/search/neighbours.hpp"

namespace collided {

/// What one thread does with neighbours; finish() after the last.
template <class Sink>
class NeighbourTester {
 public:
  explicit NeighbourTester(const Sink& sink) : sink_(sink), first_(sink.vertex_triangle), second_(sink.edge_edge) {}

  /// Neighbours that are tested soon.
  void prefetch(uint64_t packed) const {
    const PackedTest test = PackedTest::unpacked(packed);
    for (const uint32_t triangle : {test.a, test.b}) {
      const char* record = reinterpret_cast<const char*>(&sink_.tests.records[triangle]);
      for (size_t byte = 0; byte < sizeof(sink_.tests.records[triangle]); byte += 64) __builtin_prefetch(record + byte);
    }
  }
  void test_first(uint64_t packed) {
    const auto [a, b, test] = PackedTest::unpacked(packed);
    if (!sink_.overlap_first(a, b, test) || sink_.excludes_first(a, b, test)) return;
    ++counts_[0];
    const auto candidate = sink_.tests.vertex_triangle_points(a, b, test);
    if (sink_.filter(a, b)(VertexTriangle{}, candidate.points)) first_.push(candidate.key);
  }
  void test_second(uint64_t packed) {
    const auto [a, b, of_kind] = PackedTest::unpacked(packed);
    const int test = of_kind + Sink::kFirstOfSecondKind;
    if (!sink_.overlap_second(a, b, test) || sink_.excludes_second(a, b, test)) return;
    ++counts_[1];
    const auto candidate = sink_.tests.edge_edge_points(a, b, test);
    if (sink_.filter(a, b)(EdgeEdge{}, candidate.points))
      second_.push(candidate.key + (uint64_t{sink_.edge_rank} << 32));
  }
  void finish() {
    first_.flush();
    second_.flush();
    sink_.add(0, counts_[0], counts_[1]);
  }

 private:
  const Sink& sink_;
  ListWriter<uint64_t> first_, second_;
  uint64_t counts_[2] = {0, 0};
};

}  // namespace collided
