// Benchmarks of the first and last stages of a frame: its positions, and the order of its results.

#include "gpu/contacts/scene_counts.hpp"
#include "gpu/positions/slot.hpp"
#include "tests/bench/stages/stage_bench.hpp"
#include "tests/bench/stages/stage_bench_functors.hpp"

namespace collided::test {
namespace {

/// Positions are copied and checked; an item is a coordinate.
void bench_send(const StageScene& s, benchmark::State& state) {
  const FrameInput input = s.frame.input();
  uint64_t bytes = 0;
  for (const MeshPositions& update : input.updates) bytes += update.start.size() + update.end.size();
  SceneSlot<CpuExec, float> slot(
      std::make_shared<const SceneShape>(SceneShape{s.spec, s.features.topology.vertex_offset}), s.exec);
  measure(state, bytes / sizeof(float), kNoPreparation, [&] { slot.send(input.updates); });
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(bytes));
}

/// Puts a list in order; an item is an entry. `data` may be empty.
void bench_order(StageScene& s, Span<const uint64_t> keys, Span<const ContactData<float>> data,
                 benchmark::State& state) {
  const uint64_t first_ids = s.features.topology.vertex_count + s.features.topology.edges.size(), count = keys.size();
  OrderBuffers<CpuExec> buffers(s.exec);
  const IdCounts ids{first_ids, first_ids};
  reserve_order<CpuExec>(buffers, {}, ids, count, !data.empty());
  FieldSet wanted = {ContactField::kElements};
  if (!data.empty()) wanted = wanted | FieldSet{ContactField::kToi, ContactField::kDistance, ContactField::kFlags};
  ColumnBuffers<CpuExec> columns(s.exec);
  columns.reserve(count, wanted);
  const FeatureRanks ranks = ranks_of({.vertex_triangle = true, .edge_edge = true}, SceneCounts(s.features.topology));
  KindBegins kinds{};
  const Unordered<WriteContact<float>> list{
      {&count, count}, keys, ranks, &kinds, {data, {}, ranks, columns.columns(wanted)}};
  measure(state, count, kNoPreparation, [&] { put_in_order(s.exec, buffers, list, {}, ids, nullptr); });
  state.counters["first_ids"] = static_cast<double>(first_ids);
}

void bench_order_of_contacts(StageScene& s, benchmark::State& state) {
  const ContactBuffers<CpuExec, float>& contacts = s.buffers.contacts;
  bench_order(s, contacts.keys.span(s.step.contacts), contacts.data.span(s.step.contacts), state);
}

/// The list of level CANDIDATES.
void bench_order_of_candidates(StageScene& s, benchmark::State& state) {
  std::vector<uint64_t> keys = s.lists<VertexTriangle>().candidates;
  for (const uint64_t key : s.lists<EdgeEdge>().candidates)
    keys.push_back(key + (uint64_t{s.features.topology.vertex_count} << 32));
  bench_order(s, span_of(keys), {}, state);
}

}  // namespace

void register_frame(StageScene& scene) {
  StageScene* s = &scene;
  add("frame/send", [s](auto& state) { bench_send(*s, state); });
  add("order/contacts", [s](auto& state) { bench_order_of_contacts(*s, state); });
  add("order/candidates", [s](auto& state) { bench_order_of_candidates(*s, state); });
}

}  // namespace collided::test
