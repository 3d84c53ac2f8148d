// A server without a network, for callers in its own process.
#include "server/in_process.hpp"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <stdexcept>

#include "gpu/detector.hpp"
#include "server/errors.hpp"
#include "server/usable_memory.hpp"

namespace collided::server {
namespace {

constexpr int kMaxThreads = 4096;   // as --threads has it
constexpr double kUnlimited = 1e9;  // frames a second, and seconds of a frame

void check_number(const char* field, int value, int max) {
  if (value < 0 || value > max)
    throw InvalidInput(field, fmt::format("{} is {}; it must be from 0 to {}", field, value, max));
}

void check(const InProcessOptions& options) {
  const std::string& backend = options.backend;
  if (backend != "auto" && backend != "cpu" && backend != "cuda")
    throw InvalidInput("engine.backend",
                       fmt::format("engine.backend is \"{}\"; it must be auto, cpu or cuda", backend));
  if (const std::string why = cuda_obstacle(); backend == "cuda" && !why.empty())
    throw FailedPrecondition("engine.backend", "engine.backend is cuda, but there is no usable CUDA device: " + why);
  check_number("engine.threads", options.threads, kMaxThreads);
  check_number("engine.concurrent_frames", options.concurrent_frames, kMaxThreads);
}

// There is one client, which has what others would share, and nobody who would have to wait for its frames.
Limits limits_of(const Config& config, uint64_t max_device_bytes) {
  Limits limits = underived_limits();
  // It bounds the first frame of a scene, too, though none is a message.
  limits.max_message_bytes = kMaxMessageMegabytes << 20;
  limits.max_device_bytes = max_device_bytes;
  derive_limits(limits, usable_memory(config));
  limits.max_scene_bytes = limits.client.max_device_bytes = limits.max_device_bytes;
  limits.client.max_scenes = limits.max_scenes;
  limits.client.max_streams = limits.max_streams;
  limits.client.max_frames_per_second = limits.client.max_frame_seconds = kUnlimited;
  return limits;
}

Config config_of(const InProcessOptions& options) {
  check(options);
  Config config;
  config.addresses.clear();
  config.backend = options.backend;
  if (cuda_available()) config.devices = {"cuda:0", "cpu:0"};  // other GPUs are the caller's
  config.threads = options.threads;
  config.concurrent_frames = options.concurrent_frames;
  config.gives_back_memory = false;
  config.limits = limits_of(config, options.max_device_bytes);
  return config;
}

}  // namespace

InProcessServer::InProcessServer(const InProcessOptions& options) : InProcessServer(config_of(options), nullptr) {}

InProcessServer::InProcessServer(const Config& config, std::nullptr_t) : core_(config, lifecycle_) {
  grpc::ServerBuilder builder;
  core_.add_to(builder);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot start the server");
  lifecycle_.serve();
}

InProcessServer::~InProcessServer() {
  core_.host.announce_stop(0);
  core_.host.end_streams();
  server_->Shutdown(std::chrono::system_clock::now());
  server_->Wait();
  core_.host.scenes().clear();
}

std::shared_ptr<grpc::Channel> InProcessServer::channel(const grpc::ChannelArguments& arguments) const {
  return server_->InProcessChannel(arguments);
}

std::shared_ptr<InProcessStream> InProcessServer::open(const pb::OpenStream& open) {
  return InProcessStream::open(open, {core_.host, core_.authenticator, core_.metrics});
}

}  // namespace collided::server
