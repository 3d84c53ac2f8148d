// The steps of a data set: where they come from.

#include "client/cli/dataset/dataset.hpp"

#include <glob.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cctype>
#include <cstdio>
#include <stdexcept>

#include "client/app/input/frame_files.hpp"
#include "client/cli/dataset/csv_text.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::cli {

namespace fs = std::filesystem;
using scenes::fail;

namespace {

bool is_mesh(const fs::path& file) { return scenes::is_mesh_file(file); }

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with("."); }

[[noreturn]] void fail_to_read(const fs::path& path, const std::error_code& error) {
  fail(path.string(), "cannot be read: " + error.message());
}

bool is_folder(const fs::directory_entry& entry) {
  std::error_code error;
  const fs::file_status status = entry.status(error);
  if (!fs::status_known(status)) fail_to_read(entry.path(), error);
  return fs::is_directory(status);
}

/// Adds the mesh files of a folder and those below it, relative to `root` if there is one. Hidden ones are not meant,
/// such as "._1.ply".
void add_meshes(const fs::path& folder, const fs::path& root, std::vector<std::string>& names) {
  std::error_code error;
  fs::path last = folder;  // which may be a folder to go on in
  auto at = fs::recursive_directory_iterator(folder, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    last = at->path();
    if (is_hidden(last)) {
      if (is_folder(*at)) at.disable_recursion_pending();
    } else if (is_mesh(last) && !is_folder(*at)) {
      names.push_back(root.empty() ? last.string() : last.lexically_relative(root).string());
    }
  }
  if (error) fail_to_read(last, error);
}

std::vector<std::string> matches(const std::string& pattern) {
  glob_t found{};
  const int failed = glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<std::string> out(found.gl_pathv, found.gl_pathv + (failed == 0 ? found.gl_pathc : 0));
  globfree(&found);
  if (failed != 0 && failed != GLOB_NOMATCH) fail(pattern, "cannot be searched");
  return out;
}

std::vector<FrameNames> as_steps(std::vector<std::string> names, size_t frames, std::vector<std::string>& notes) {
  sort_naturally(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  if (frames == 2) return paired(names, notes);
  std::vector<FrameNames> steps;
  for (std::string& name : names) steps.push_back({std::move(name)});
  return steps;
}

Dataset find_pairs(const std::string& name, size_t frames) {
  Dataset out;
  std::vector<std::string> names;
  if (fs::is_directory(name)) {
    out.root = name;
    add_meshes(out.root, out.root, names);
  } else {
    for (const std::string& match : matches(name)) {
      if (fs::is_directory(match))
        add_meshes(match, "", names);
      else if (is_mesh(match))
        names.push_back(match);
    }
  }
  if (names.empty()) fail(name, std::string("has no mesh files (") + scenes::kMeshExtensions + ")");
  out.pairs = as_steps(std::move(names), frames, out.notes);
  return out;
}

Dataset read_list(const std::string& name, size_t frames) {
  if (is_mesh(name)) fail(name, "is one mesh file; a data set is a folder, a glob in quotes, or a list of pairs");
  return {
      .root = fs::path(name).parent_path(), .pairs = listed_pairs(scenes::read_file(name), name, frames), .notes = {}};
}

}  // namespace

std::string Dataset::digest() const {
  boost::crc_32_type crc;
  for (const FrameNames& names : pairs)
    for (const std::string& name : names) crc.process_bytes(name.c_str(), name.size() + 1);
  char text[9];
  std::snprintf(text, sizeof text, "%08x", crc.checksum());
  return text;
}

Dataset read_dataset(const std::string& name, size_t frames) {
  const bool is_there = fs::exists(name);
  if (!is_there && name.find_first_of("*?[") == std::string::npos) fail(name, "does not exist");
  Dataset out = is_there && !fs::is_directory(name) ? read_list(name, frames) : find_pairs(name, frames);
  if (out.pairs.empty())
    fail(name, frames == 2 ? "has no pairs of frames: files whose names differ in their last number alone, as "
                             "cloth92.ply and cloth93.ply"
                           : "has no frames");
  return out;
}

std::string list_text(const Dataset& dataset) {
  std::string text = dataset.pairs.front().size() == 2 ? "frame0,frame1\n" : "frame0\n";
  for (const FrameNames& names : dataset.pairs) {
    for (size_t i = 0; i < names.size(); ++i) text += (i > 0 ? "," : "") + csv_cell(dataset.path_of(names[i]));
    text += "\n";
  }
  return text;
}

}  // namespace collided::cli
