// Frames to play, one after the other: of a procedural scene, or in mesh files.

#include "client/app/input/motion.hpp"

#include <filesystem>
#include <memory>
#include <utility>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/input/frame_files.hpp"
#include "client/app/input/mesh_input.hpp"
#include "client/app/output/progress.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

void grow_box(v1::SceneSpec& spec, const Motion& motion) {
  for (int frame = 0; frame < motion.frames && client::is_quantized(spec.position_format()); ++frame)
    grow_box(spec, motion.positions(frame));
}

Motion scene_motion(const SceneOptions& options) {
  const std::shared_ptr<const scenes::Scene> scene = scenes::make_scene(options.name, options.scale);
  return {.name = options.name,
          .meshes = scene->meshes(),
          .frames = options.frames,
          .files = {},
          .positions = [scene, options](int frame) { return scene->positions(options.time(frame)); }};
}

Motion file_motion(std::vector<std::string> files) {
  files = expand_folders(files);
  sort_naturally(files);
  const auto first = std::make_shared<const FileFrame>(read_frame(files[0]));
  bool is_double = first->is_double;
  const int frames = static_cast<int>(files.size());
  Progress progress;
  for (int i = 1; i < frames; ++i) {
    check_interrupt();
    is_double |= read_frame(files[static_cast<size_t>(i)], *first, files[0]).is_double;
    progress.show("reading", i + 1, frames);
  }
  return {.name = std::filesystem::path(files[0]).stem().string(),
          .meshes = {first->mesh},
          .frames = frames,
          .files = files,
          .is_double = is_double,
          .notes = first->notes,
          .positions = [first, files](int frame) {
            return read_frame(files[static_cast<size_t>(frame)], *first, files[0]).positions;
          }};
}

}  // namespace collided::cli
