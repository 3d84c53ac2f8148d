// Runs a target on files, or on all files of folders: what makes each target a test under any compiler.

#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "tests/fuzz/targets/fuzz.hpp"

namespace {

namespace fs = std::filesystem;

// Names the file first: a finding ends the process.
void replay(const fs::path& file) {
  std::cout << file.filename().string() << std::endl;
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

size_t replay_all(const fs::path& path) {
  if (!fs::is_directory(path)) return replay(path), 1;
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(path)) files += replay_all(entry.path());
  return files;
}

}  // namespace

int main(int count, char** arguments) try {
  size_t files = 0;
  for (int i = 1; i < count; ++i) files += replay_all(arguments[i]);
  std::cout << files << " inputs\n";
  return files > 0 ? 0 : 1;
} catch (const std::exception& e) {
  std::cerr << "replay: " << e.what() << '\n';
  return 1;
}
