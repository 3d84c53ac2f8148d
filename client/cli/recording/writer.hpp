#pragma once
// Writes a recording (recording/format.hpp).

#include <span>

#include "client/app/output/output.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

class RecordingWriter {
 public:
  /// `spec` without meshes, and the meshes, as Client::create_scene takes them. Throws std::runtime_error naming the
  /// file.
  RecordingWriter(const std::string& file, v1::SceneSpec spec, std::span<const client::MeshInput> meshes);
  void add(const v1::Frame& frame) { add("frame", frame); }
  /// Ends the recording; without it, it counts as cut off.
  void finish();

 private:
  void add(const std::string& what, const google::protobuf::MessageLite& message);

  std::string file_;
  OutputFile out_;
};

}  // namespace collided::cli
