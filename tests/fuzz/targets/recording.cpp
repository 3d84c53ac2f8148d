// Recordings: a scene and its frames, or a refusal.

#include <google/protobuf/stubs/logging.h>

#include "client/cli/recording/meshes.hpp"
#include "client/cli/recording/reader.hpp"
#include "tests/fuzz/targets/memory_file.hpp"

namespace collided::fuzz {
namespace {

void read(const std::string& bytes) {
  static const MemoryFile file;
  file.write(bytes);
  int counted = 0, read = 0;
  try {
    cli::RecordingReader reader(file.path());
    const cli::RecordedMeshes meshes(reader.spec());
    require(meshes.inputs().size() == static_cast<size_t>(reader.spec().meshes_size()), "every mesh is read");
    counted = reader.count_frames();
    for (; reader.next_frame(); ++read) require(read < counted, "no more frames are read than were counted");
    require(read == counted, "a whole recording has the frames that were counted");
  } catch (const std::runtime_error& e) {
    require(!std::string(e.what()).empty(), "a refusal says why");
  }
}

}  // namespace

void run(Input input) {
  static const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  read(input.rest());
}

}  // namespace collided::fuzz
