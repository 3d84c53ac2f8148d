#include "gpu/exec/cuda/cuda_exec.cuh"
#include "tests/support/verdicts/query_batch_run.hpp"

namespace collided::test {

std::vector<Verdict> run_queries_cuda(std::span<const Query> queries, const BatchSettings& settings) {
  CudaExec exec(0, 0, 0);
  return run_queries_on(exec, queries, settings);
}

}  // namespace collided::test
