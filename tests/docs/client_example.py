#!/usr/bin/env python3
"""A program of the C++ of client/cpp/README.md and a main that calls it.

usage: client_example.py REPOSITORY OUTPUT
"""

import pathlib
import sys

from markdown import Page

TO_ANOTHER_HOST = 'Client::connect("gpu-host:50551", {.token = token, .tls_ca = "ca.pem"})'
SESSION_THERE = 'Session::open("gpu-host:50551", spec, meshes, {.connect = {.token = token, .tls_ca = "ca.pem"}})'
PROGRAM = """\
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <grpcpp/support/status_code_enum.h>

#include <collided/client.hpp>
#include <collided/local.hpp>

using namespace collided::client;
using namespace std::chrono_literals;
namespace v1 = collided::v1;

const std::string address = std::getenv("COLLIDED_SERVER");
const ConnectOptions options;
const size_t vertices = 6;
const std::vector<float> before = {0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, 1, 1.25, 1, 9, 1, 1.25, 9};
const std::vector<float> after = {0, 0, 0, 4, 0, 0, 0, 4, 0, 1, 1, -1, 1.25, 1, 7, 1, 1.25, 7};

void write_positions(std::span<std::byte> room) { std::memcpy(room.data(), after.data(), room.size()); }

void tell(const char* what, const FrameStream& stream, const FrameOutput& output) {
  std::printf("%s, %s: %zu vertex-triangle contacts\\n", what, stream.is_local() ? "shared memory" : "gRPC",
              output.vertex_triangle.count);
}

// Compiled but not run: other tests use a daemon with TLS.
FrameOutput over_tls(const v1::SceneSpec& spec, std::span<const MeshInput> meshes, const std::string& token,
                     const std::vector<float>& positions, uint64_t id) {
@first@
  return output;
}

void keep_session(const v1::SceneSpec& spec, std::span<const MeshInput> meshes, const std::vector<float>& positions) {
@session here@
  std::printf("session: frame %zu\\n", static_cast<size_t>(output.frame_id));
}

void respond(const FrameOutput& output) {
  std::printf("callback: frame %zu\\n", static_cast<size_t>(output.frame_id));
}

void call_back(const v1::SceneSpec& spec, std::span<const MeshInput> meshes, const std::vector<float>& positions) {
@here@
  const FrameUpdate update{.mesh = 0, .positions = std::as_bytes(std::span(positions))};
@callback@
  session.detect({&update, 1});  // after it
}

v1::Scene make(const v1::SceneSpec& spec, std::span<const MeshInput> meshes, const std::vector<float>& positions,
               uint64_t id) {
@first here@
  tell("first", stream, output);
  stream.finish();
  return scene;
}

void show_contours(Client& client, std::span<const MeshInput> meshes) {
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_DCD);
  spec.add_kinds(v1::CONTACT_KIND_EDGE_TRIANGLE);
  spec.add_fields(v1::CONTACT_FIELD_ELEMENTS);
  spec.add_fields(v1::CONTACT_FIELD_WEIGHTS);
  FrameStream stream = client.stream(client.create_scene(spec, meshes));
  const FrameUpdate update{.mesh = 0, .positions = std::as_bytes(std::span(after))};
  stream.send(1, {&update, 1});
  const FrameOutput output = stream.receive();
  std::vector<std::array<double, 3>> positions(vertices);
  for (size_t i = 0; i < after.size(); ++i) positions[i / 3][i % 3] = after[i];
@contours@
}

void step_together(Client& client, const v1::SceneSpec& spec, std::span<const MeshInput> meshes) {
  std::vector<float> positions;
  for (int world = 0; world < 1000; ++world) positions.insert(positions.end(), before.begin(), before.end());
  const std::span<const std::byte> bytes = std::as_bytes(std::span(positions));
  uint64_t responses = 0;
  const auto respond = [&](uint32_t, const auto&) { ++responses; };
@sets@
if (responses != output.vertex_triangle.elements.size()) throw std::runtime_error("contacts of no world");
}

void share(Client& client, const v1::Scene& scene, uint64_t id) {
@second@
  output.check();
  tell("shared", stream, output);
  stream.finish();
}

// The connection is lost once, after the frame was sent.
void step(FrameStream& stream, uint64_t id) {
  static bool was_lost = false;
  const FrameUpdate update{.mesh = 0, .positions = std::as_bytes(std::span(id % 2 ? before : after))};
  stream.send(id, {&update, 1});
  const FrameOutput output = stream.receive();
  output.check();
  tell(("frame " + std::to_string(id)).c_str(), stream, output);
  if (!std::exchange(was_lost, true)) throw Error(grpc::UNAVAILABLE, "the connection is lost");
}

void go_on(const v1::Scene& scene, uint64_t last) {
@third@
}

int main(int argc, char**) {
  const std::array<std::array<uint32_t, 3>, 2> triangles = {{{0, 1, 2}, {3, 4, 5}}};
  const MeshInput mesh{.name = "two triangles", .vertex_count = vertices, .triangles = triangles};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  if (argc > 1) over_tls(spec, {&mesh, 1}, "", before, 1);
  keep_session(spec, {&mesh, 1}, before);
  call_back(spec, {&mesh, 1}, before);
  const v1::Scene scene = make(spec, {&mesh, 1}, before, 1);
  Client client = Client::connect(address, options);
  show_contours(client, {&mesh, 1});
  step_together(client, spec, {&mesh, 1});
  share(client, scene, 2);
  go_on(scene, 5);
}
"""

repository, output = map(pathlib.Path, sys.argv[1:])
session, callback, first, contours, sets, second, here, third = Page(repository / "client" / "cpp" / "README.md").blocks("cpp")
for text, part in ((first, TO_ANOTHER_HOST), (session, SESSION_THERE)):
    if part not in text:
        sys.exit(f"the C++ of client/cpp/README.md lacks {part}")
program = PROGRAM
for name, text in (("callback", callback), ("here", here), ("first", first), ("contours", contours), ("sets", sets), ("second", second), ("third", third),
                   ("session here", session.replace(SESSION_THERE, "Session::open(address, spec, meshes)")),
                   ("first here", first.replace(TO_ANOTHER_HOST, "Client::connect(address, options)"))):
    program = program.replace(f"@{name}@", text)
output.write_text(program)
