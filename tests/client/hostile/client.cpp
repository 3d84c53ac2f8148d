// This program runs the C++ client against a daemon that misbehaves. It reads lines "BEHAVIOUR SCENARIO ADDRESS" and
// runs all of them at once. For each it prints the code of the error, or ok, then the seconds that it took and the
// message.

#include "client/cpp/client.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/batch/scene_set.hpp"
#include "client/cpp/session.hpp"

namespace {

using namespace collided;
using namespace collided::client;
using std::chrono::milliseconds;

constexpr std::array<std::array<uint32_t, 3>, 1> kOne{{{0, 1, 2}}};
constexpr std::array<float, 9> kFloor{0, 0, 0, 4, 0, 0, 0, 4, 0}, kTip{1, 1, 1, 1.25, 1, 9, 1, 1.25, 9};

std::vector<MeshInput> meshes() {
  return {{.name = "floor", .vertex_count = 3, .triangles = kOne},
          {.name = "tip", .vertex_count = 3, .triangles = kOne}};
}

v1::SceneSpec spec() {
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F32);
  return spec;
}

std::array<FrameUpdate, 2> updates() {
  return {{{.mesh = 0, .positions = std::as_bytes(std::span(kFloor))},
           {.mesh = 1, .positions = std::as_bytes(std::span(kTip))}}};
}

FrameOutput within(std::optional<FrameOutput> output) {
  if (!output) throw Error(grpc::DEADLINE_EXCEEDED, "no output came in time");
  output->check();
  return *std::move(output);
}

void run_stream(Client& client, milliseconds patience, Local local) {
  const uint32_t frames = local == Local::kOn ? 1 : 2;
  FrameStream stream =
      client.stream(client.create_scene(spec(), meshes()), {.window = frames, .local = {.use = local}});
  for (uint32_t id = 1; id <= frames; ++id) stream.send(id, updates());
  for (uint32_t id = 1; id <= frames; ++id) within(stream.receive_within(patience));
  stream.finish();
}

void run_limits(Client& client, milliseconds patience) {
  FrameStream stream =
      client.stream(client.create_scene(spec(), meshes()), {.window = 1, .local = {.use = Local::kOff}});
  stream.send(1, updates());
  within(stream.receive_within(patience));
  stream.send(2, updates(), {.advance = true, .limits = true});
  const auto limits = within(stream.receive_within(patience)).limits;
  if (limits.vertex_triangle.toi != std::vector{0.5} || limits.edge_edge.toi != std::vector{0.75})
    throw std::logic_error("not the limits that came");
  stream.finish();
}

/// The daemon takes none of it: positions for much more than a connection buffers.
void run_large(Client& client, milliseconds) {
  constexpr uint32_t kVertices = 3'000'000;
  MeshInput mesh{.name = "large", .vertex_count = kVertices, .triangles = kOne};
  FrameStream stream =
      client.stream(client.create_scene(spec(), {&mesh, 1}), {.window = 2, .local = {.use = Local::kOff}});
  const std::vector<float> positions(3 * kVertices);
  const FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
  stream.send(1, {&update, 1});
  stream.finish();
}

void run_session(const std::string& address, const ConnectOptions& connect) {
  Session session =
      Session::open(address, spec(), meshes(),
                    {.connect = connect, .stream = {.local = {.use = Local::kOff}}, .give_up = connect.deadline});
  auto answer = session.submit(updates());
  if (answer.wait_for(2 * connect.deadline) != std::future_status::ready) {
    session.close();
    throw Error(grpc::DEADLINE_EXCEEDED, "the frame was not answered in time");
  }
  answer.get();
  session.close();
}

void run_set(Client& client, milliseconds) {
  SceneSet set = SceneSet::create(client, spec(), meshes(), 2, {});
  std::vector<float> positions;
  for (int world = 0; world < 2; ++world) {
    positions.insert(positions.end(), kFloor.begin(), kFloor.end());
    positions.insert(positions.end(), kTip.begin(), kTip.end());
  }
  set.detect({.positions = std::as_bytes(std::span(positions))}).check();
}

void run_scenario(const std::string& scenario, const std::string& address, const ConnectOptions& connect) {
  if (scenario == "session") return run_session(address, connect);
  Client client = Client::connect(address, connect);
  if (scenario == "limits") run_limits(client, connect.deadline);
  if (scenario == "stream") run_stream(client, connect.deadline, Local::kOff);
  if (scenario == "local") run_stream(client, connect.deadline, Local::kOn);
  if (scenario == "large") run_large(client, connect.deadline);
  if (scenario == "set") run_set(client, connect.deadline);
  if (scenario == "list") client.list_scenes();
  if (scenario == "mesh") client.mesh_elements(client.create_scene(spec(), meshes()).scene_id(), 0);
  if (scenario == "watch") client.watch(client.create_scene(spec(), meshes()).scene_id(), {.meshes = {1}}).receive();
}

void play(const std::string& line, milliseconds limit) {
  std::istringstream words(line);
  std::string behaviour, scenario, address, code = "ok", message;
  words >> behaviour >> scenario >> address;
  const auto begun = std::chrono::steady_clock::now();
  try {
    run_scenario(scenario, address, {.patience = limit, .deadline = limit, .token = behaviour});
  } catch (const Error& e) {
    code = code_name(e.code());
    message = e.message().substr(0, 200);
  } catch (const std::exception& e) {
    code = "UNTYPED";
    message = e.what();
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  for (char& c : message) c = c == '\n' ? ' ' : c;
  std::printf("%s %s %s %.3f %s\n", behaviour.c_str(), scenario.c_str(), code.c_str(), took.count(), message.c_str());
}

}  // namespace

int main(int, char** arguments) {
  const auto limit = std::chrono::duration_cast<milliseconds>(std::chrono::duration<double>(std::atof(arguments[1])));
  std::vector<std::jthread> threads;
  for (std::string line; std::getline(std::cin, line);) threads.emplace_back([line, limit] { play(line, limit); });
}
