#pragma once
// Records a scene that others drive, as far as a watch shows it.
//
// A watch shows where each frame left the meshes, not what their sender asked for. A replay finds the same contacts for
// frames that follow their predecessor without a gap, begin where that one ended, and ask for what the scene's spec
// does; `differences` tells where the scene itself rules that out.

#include <string>
#include <vector>

#include "client/cli/recording/writer.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// Elements of the meshes of a scene, which a daemon does not send back: those of mesh files, together, one mesh after
/// the other. They may be in one file or in several.
class SceneElements {
 public:
  /// Throws std::runtime_error if the files have other numbers of vertices or elements than the scene.
  SceneElements(const v1::SceneSpec& spec, const std::vector<std::string>& files);
  SceneElements(const SceneElements&) = delete;
  SceneElements& operator=(const SceneElements&) = delete;
  const std::vector<client::MeshInput>& inputs() const { return inputs_; }

 private:
  std::vector<scenes::Mesh> meshes_;
  std::vector<client::MeshInput> inputs_;
};

class LiveRecorder {
 public:
  /// `scene` as a watch shows it. Throws std::runtime_error for positions that no watch has whole, and naming files.
  LiveRecorder(const std::string& file, const v1::Scene& scene, const std::vector<std::string>& mesh_files);
  /// What to watch.
  static client::WatchOptions watch_options(const v1::Scene& scene);

  /// False if an edit has changed the meshes: the recording ends before it.
  bool add(const client::WatchedFrame& frame);
  void finish() { writer_.finish(); }
  /// What became of it, in lines for people: how many frames there are, and what a replay finds otherwise.
  std::string summary() const;

 private:
  const std::string file_;
  const v1::Scene scene_;
  RecordingWriter writer_;
  uint64_t frames_ = 0, missed_ = 0, gaps_ = 0;
  bool was_edited_ = false;
};

}  // namespace collided::cli
