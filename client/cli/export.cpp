// collidectl export: frames of a procedural scene as mesh files, all meshes in one, in the order of the scene's ids.

#include <cstdio>
#include <filesystem>
#include <memory>

#include "client/app/daemon/interrupt.hpp"
#include "client/app/options/scene_options.hpp"
#include "client/app/output/output.hpp"
#include "client/app/output/progress.hpp"
#include "client/cli/commands.hpp"
#include "client/scenes/mesh_files/mesh_file.hpp"

namespace collided::cli {

namespace {

struct ExportOptions {
  SceneOptions scene;
  std::string out;
  std::string format = "ply";
};

std::vector<std::array<uint32_t, 3>> all_triangles(const scenes::Scene& scene) {
  std::vector<std::array<uint32_t, 3>> out;
  uint32_t base = 0;
  for (const scenes::Mesh& mesh : scene.meshes()) {
    for (const auto& t : mesh.triangles) out.push_back({base + t[0], base + t[1], base + t[2]});
    base += mesh.vertex_count;
  }
  return out;
}

void run(const ExportOptions& options) {
  make_folder("--out", options.out);
  const auto scene = scenes::make_scene(options.scene.name, options.scene.scale);
  defer_interrupts();
  scenes::MeshFile mesh{{}, all_triangles(*scene), true};
  Progress progress;
  for (int frame = 0; frame < options.scene.frames; ++frame) {
    check_interrupt();
    mesh.positions = scene->positions(options.scene.time(frame));
    char number[16];
    std::snprintf(number, sizeof number, "_%04d.", frame);
    scenes::write_mesh(std::filesystem::path(options.out) / (options.scene.name + number + options.format), mesh);
    progress.show("files", frame + 1, options.scene.frames);
  }
  std::printf("%d files of %zu triangles in %s\n", options.scene.frames, mesh.triangles.size(), options.out.c_str());
}

}  // namespace

void add_export(CLI::App& app) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App& command = *app.add_subcommand("export", "Write frames of a procedural scene as mesh files");
  add_scene_options(command, options->scene);
  command.add_option("--out", options->out, "Folder; created if missing")->type_name("FOLDER")->required();
  command.add_option("--format", options->format, "ply (binary doubles) or obj")
      ->check(CLI::IsMember({"ply", "obj"}))
      ->capture_default_str();
  command.callback([options] { run(*options); });
}

}  // namespace collided::cli
