// Options that several subcommands share.

#include "client/cli/options.hpp"

#include "client/cli/finite.hpp"

namespace collided::cli {

void add_server_options(CLI::App& command, ServerOptions& options) {
  auto* server = command.add_option("--server", options.server, "Address of a running daemon; default: start one");
  command.add_option("--backend", options.backend, "Where the scene lives: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command.add_option("--threads", options.threads, "CPU threads of the own daemon; 0: all cores")
      ->check(CLI::Range(0, 4096))
      ->excludes(server);
}

void add_detection_options(CLI::App& command, DetectionOptions& options) {
  command.add_option("--mode", options.mode, "ccd: between two frames; dcd: in one frame")
      ->check(CLI::IsMember({"ccd", "dcd"}))
      ->capture_default_str();
  command.add_option("--accuracy", options.accuracy, "candidates: overlapping boxes; fast: contacts")
      ->check(CLI::IsMember({"candidates", "fast"}))
      ->capture_default_str();
  command.add_option("--thickness", options.thickness, "Contact distance, in the unit of the positions")
      ->check(finite())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

v1::SceneSpec scene_spec(const ServerOptions& server, const DetectionOptions& detection, v1::PositionFormat format) {
  v1::SceneSpec spec;
  spec.set_backend(server.backend == "cpu"    ? v1::BACKEND_CPU
                   : server.backend == "cuda" ? v1::BACKEND_CUDA
                                              : v1::BACKEND_AUTO);
  spec.set_mode(detection.mode == "dcd" ? v1::DETECTION_MODE_DCD : v1::DETECTION_MODE_CCD);
  spec.set_accuracy(detection.accuracy == "fast" ? v1::ACCURACY_FAST : v1::ACCURACY_CANDIDATES);
  spec.set_thickness(detection.thickness);
  spec.set_position_format(format);
  return spec;
}

std::string name_of(v1::Backend backend) {
  switch (backend) {
    case v1::BACKEND_CPU:
      return "cpu";
    case v1::BACKEND_CUDA:
      return "cuda";
    default:
      return "auto";
  }
}

std::string name_of(v1::PositionFormat format) { return format == v1::POSITION_FORMAT_F64 ? "f64" : "f32"; }

}  // namespace collided::cli
