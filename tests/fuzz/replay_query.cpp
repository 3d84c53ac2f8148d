// Prints the verdicts of the judge and of every level on queries that a failed test has printed.

#include <cstdlib>
#include <iostream>
#include <string_view>

#include "tests/support/families/query_families.hpp"
#include "tests/support/verdicts/verdict_score.hpp"

namespace collided::test {
namespace {

constexpr const char* kUsage =
    "usage: replay_query [--dcd] [--f32] [--delta D] [--thickness H] [--cuda] < QUERIES\n"
    "QUERIES: one a line, as failed tests print them: VT or EE and 24 coordinates.\n";

bool read_options(int count, char** arguments, BatchSettings& settings) {
  for (int i = 1; i < count; ++i) {
    const std::string_view option = arguments[i];
    if (option == "--dcd")
      settings.mode = Mode::kDcd;
    else if (option == "--f32")
      settings.scalar = Scalar::kF32;
    else if (option == "--cuda")
      settings.backend = Backend::kCuda;
    else if (option == "--delta" && i + 1 < count)
      settings.delta = std::strtod(arguments[++i], nullptr);
    else if (option == "--thickness" && i + 1 < count)
      settings.thickness = std::strtod(arguments[++i], nullptr);
    else
      return false;
  }
  return true;
}

void replay(const Query& query, BatchSettings settings) {
  const Judged truth = judge({rounded(query, settings.scalar)}, settings.mode, settings.thickness);
  std::cout << text_of(truth.queries[0]) << "\n  truth: " << text_of(truth.truth[0]) << '\n';
  for (Accuracy accuracy : {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact}) {
    settings.accuracy = accuracy;
    std::cout << "  " << name_of(accuracy) << ": " << text_of(run_queries(truth.queries, settings)[0]) << '\n';
  }
}

int run(int count, char** arguments) {
  BatchSettings settings;
  if (!read_options(count, arguments, settings)) {
    std::cerr << kUsage;
    return 2;
  }
  for (std::string line; std::getline(std::cin, line);)
    if (line.find_first_not_of(' ') != std::string::npos) replay(query_from(line), settings);
  return 0;
}

}  // namespace
}  // namespace collided::test

int main(int count, char** arguments) try {
  return collided::test::run(count, arguments);
} catch (const std::exception& e) {
  std::cerr << "replay_query: " << e.what() << '\n';
  return 1;
}
