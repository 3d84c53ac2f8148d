#include "tests/support/verdicts/verdict_score_checks.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace collided::test {
namespace {

constexpr size_t kShown = 3;  // offences of a run that are printed in full

struct LevelRun {
  Accuracy accuracy;
  double delta;
};

std::vector<LevelRun> runs_on(const Judged& judged) {
  std::vector<LevelRun> runs{{Accuracy::kFast, 0}};
  const double extent = typical_extent(judged.queries);
  for (Accuracy accuracy : {Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    runs.push_back({accuracy, 0});
    if (judged.mode == Mode::kDcd) continue;  // delta is a tolerance of CCD
    for (double share : {1e-3, 1e-12})
      if (share * extent > 0) runs.push_back({accuracy, share * extent});  // else an underflow: the default again
  }
  return runs;
}

std::string describe(const Question& q, const Judged& judged, const LevelRun& run) {
  return q.source.family->name + ", " + name_of(q.source.kind) + ", " + name_of(q.source.scalar) + ", seed " +
         std::to_string(q.source.seed) + ", " + (q.mode == Mode::kCcd ? "CCD, " : "DCD, ") + name_of(run.accuracy) +
         ", delta " + ::testing::PrintToString(run.delta) + ", thickness " + ::testing::PrintToString(judged.thickness);
}

std::vector<Verdict> verdicts_of(const Question& q, const Judged& judged, const LevelRun& run, Backend backend) {
  BatchSettings settings;
  settings.backend = backend;
  settings.mode = q.mode;
  settings.scalar = q.source.scalar;
  settings.accuracy = run.accuracy;
  settings.delta = run.delta;
  settings.thickness = judged.thickness;
  return run_queries(judged.queries, settings);
}

void print_offences(const Judged& judged, const std::vector<Verdict>& verdicts, const std::vector<Offence>& offences) {
  for (size_t i = 0; i < std::min(offences.size(), kShown); ++i) {
    const size_t query = offences[i].query;
    ADD_FAILURE() << "query " << query << ": " << offences[i].what << "\n  verdict: " << text_of(verdicts[query])
                  << "\n  truth:   " << text_of(judged.truth[query]) << "\n  " << text_of(judged.queries[query]);
  }
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool same(const Verdict& a, const Verdict& b) {
  return a.hit == b.hit && same_bits(a.toi, b.toi) && same_bits(a.distance, b.distance) && a.flags == b.flags;
}

void expect_same(const Judged& judged, const std::vector<Verdict>& a, const std::vector<Verdict>& b) {
  size_t different = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (same(a[i], b[i]) || ++different > kShown) continue;
    ADD_FAILURE() << "query " << i << ": the backends differ\n  CPU:  " << text_of(a[i])
                  << "\n  CUDA: " << text_of(b[i]) << "\n  " << text_of(judged.queries[i]);
  }
  EXPECT_EQ(different, 0u);
}

// FAST promises nothing but well-formed answers.
void expect_promises_of(Accuracy accuracy, const Score& s) {
  EXPECT_EQ(s.malformed, 0u);
  if (accuracy == Accuracy::kFast) return;
  EXPECT_EQ(s.missed, 0u);
  EXPECT_EQ(s.late, 0u);
  EXPECT_EQ(s.wrongly_certified, 0u);
  EXPECT_EQ(s.wrong_initial, 0u);
  if (accuracy != Accuracy::kExact) return;
  EXPECT_EQ(s.false_hits, 0u);
  EXPECT_EQ(s.certified, s.hits);
}

}  // namespace

void expect_promises(const Question& question, ScoreTable* table) {
  const Judged truth = judged(question);
  for (const LevelRun& run : runs_on(truth)) {
    SCOPED_TRACE(describe(question, truth, run));
    const std::vector<Verdict> verdicts = verdicts_of(question, truth, run, kBackend);
    ASSERT_EQ(verdicts.size(), truth.queries.size());
    std::vector<Offence> offences;
    const Score scored = score(truth, verdicts, run.accuracy, &offences);
    expect_promises_of(run.accuracy, scored);
    if (run.accuracy != Accuracy::kFast) print_offences(truth, verdicts, offences);
    if (kBackend == Backend::kCuda) expect_same(truth, verdicts_of(question, truth, run, Backend::kCpu), verdicts);
    if (table && run.delta == 0) table->add(question.source.family->name, question.source.scalar, run.accuracy, scored);
  }
}

Score score_of(const Question& question, Accuracy accuracy) {
  const Judged truth = judged(question);
  return score(truth, verdicts_of(question, truth, {accuracy, 0}, kBackend), accuracy);
}

void ScoreFile::TearDown() {
  const char* path = std::getenv(variable_.c_str());
  if (!path) return;
  const char* commit = std::getenv("COLLIDED_COMMIT");
  std::ofstream out(path);
  table.write_json(out, kBackend == Backend::kCpu ? "CPU" : list_devices().back().name, commit ? commit : "");
  EXPECT_TRUE(out.flush()) << "cannot write " << path;
}

}  // namespace collided::test
