#!/usr/bin/env python3
"""A program of the C++ of README.md and client/EXAMPLES.md, and a main that calls it.

usage: cpp_example.py REPOSITORY OUTPUT
"""

import pathlib
import sys

from markdown import Page
from run_page import README_SOCKET

PROGRAM = """\
#include <string>
std::string address();

{first}
// Compiled but not run: the same in few lines.
void first_frame(const v1::SceneSpec& spec, const MeshInput& mesh, const FrameUpdate& update, uint64_t id) {{
{few}
}}

void go_on(Client& client, const v1::Scene& scene, const Points& moved, const std::vector<uint32_t>& indices) {{
{second}
  again.send(again.scene().last_frame_id() + 1, {{&sparse, 1}});
  std::printf("after a resume: %zu vertex-triangle contacts\\n", again.receive().vertex_triangle.count);
  again.finish();
}}

{third}

{main}
"""
MAIN = """
#include <cstdlib>

std::string address() { return std::getenv("COLLIDED_SERVER"); }

int main() {
  const std::array<std::array<uint32_t, 3>, 2> triangles = {{{0, 1, 2}, {3, 4, 5}}};
  const MeshInput mesh{.name = "two triangles", .vertex_count = 6, .triangles = triangles};
  const Points before = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 1}, {1.25, 1, 9}, {1, 1.25, 9}};
  Points after = before;
  for (size_t v = 3; v < 6; ++v) after[v][2] -= 2;
  find_contacts(mesh, {before, after});

  Client client = Client::connect(address());
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  const v1::Scene scene = client.create_scene(spec, {&mesh, 1});
  {
    FrameStream stream = client.stream(scene);
    const FrameUpdate whole{.mesh = 0, .positions = std::as_bytes(std::span(before))};
    stream.send(1, {&whole, 1});
    stream.receive().check();
  }
  go_on(client, scene, {after[3]}, {3});

  std::vector<std::array<uint32_t, 3>> cells;
  Points flat, folded;
  for (uint32_t v = 0; v < 25; ++v) {
    const double x = 0.01 * (v % 5), y = 0.01 * (v / 5);
    flat.push_back({x, y, 0});
    folded.push_back(x < 0.025 ? flat.back() : std::array<double, 3>{0.05 - x, y, 0.005});
    if (v % 5 < 4 && v < 20) cells.insert(cells.end(), {{v, v + 1, v + 5}, {v + 5, v + 1, v + 6}});
  }
  const MeshInput cloth{.name = "cloth", .vertex_count = 25, .triangles = cells};
  std::printf("flat: %zu contacts\\n", static_cast<size_t>(count_contacts(client, cloth, flat, flat)));
  std::printf("folded: %s\\n", count_contacts(client, cloth, flat, folded) > 20 ? "many" : "few");
}
"""

repository, output = map(pathlib.Path, sys.argv[1:])
(few,) = Page(repository / "README.md").blocks("cpp")
first, second, third = Page(repository / "client" / "EXAMPLES.md").blocks("cpp")
for page, code in (("README.md", few), ("client/EXAMPLES.md", first)):
    if f'"{README_SOCKET}"' not in code:
        sys.exit(f"the C++ of {page} does not connect to {README_SOCKET}")
few, first = (code.replace(f'"{README_SOCKET}"', "address()") for code in (few, first))
output.write_text(PROGRAM.format(few=few, first=first, second=second, third=third, main=MAIN))
