#include "tests/support/verdicts/query_batch.hpp"

#include "gpu/exec/cpu/cpu_exec.hpp"
#include "tests/support/verdicts/query_batch_run.hpp"

namespace collided::test {

std::vector<Verdict> run_queries_cpu(std::span<const Query> queries, const BatchSettings& settings) {
  CpuExec exec(0, 0);
  return run_queries_on(exec, queries, settings);
}

#ifndef COLLIDED_TEST_HAVE_CUDA
std::vector<Verdict> run_queries_cuda(std::span<const Query>, const BatchSettings&) {
  throw DeviceError("this build has no CUDA");
}
#endif

std::vector<Verdict> run_queries(std::span<const Query> queries, const BatchSettings& settings) {
  return settings.backend == Backend::kCuda ? run_queries_cuda(queries, settings) : run_queries_cpu(queries, settings);
}

}  // namespace collided::test
