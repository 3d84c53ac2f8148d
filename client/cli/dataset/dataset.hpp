#pragma once
// The steps of a data set: pairs of frames (CCD), or frames (DCD), in mesh files.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace collided::cli {

/// Names of a step's files, one or two, as the data set tells them.
using FrameNames = std::vector<std::string>;

struct Dataset {
  std::filesystem::path root;      ///< that names are relative to
  std::vector<FrameNames> pairs;   ///< in an order that depends on their names alone
  std::vector<std::string> notes;  ///< for people: what is in no pair

  std::string path_of(const std::string& name) const { return (root / name).string(); }
  /// Depends on the names of all pairs and their order, not on where the data set is.
  std::string digest() const;
};

/// Of a folder, a glob of folders and mesh files, or a list of pairs, a line each. `frames`: of each step, 1 or 2.
/// Throws std::runtime_error naming the place and what is wrong there, also if there are no pairs.
Dataset read_dataset(const std::string& name, size_t frames);

/// The list of these pairs, which read_dataset() takes from the current folder.
std::string list_text(const Dataset& dataset);

/// The steps in a list's text. Blank lines and lines that begin with # are none; `file` is for errors.
std::vector<FrameNames> listed_pairs(const std::string& text, const std::string& file, size_t frames);

/// The steps between mesh files, whose names are in natural order. Files whose names differ only in their last number
/// are a sequence; a pair are two frames as far apart as the closest two of their sequence, so that there is none
/// across a gap. `notes` gets what is left out.
std::vector<FrameNames> paired(const std::vector<std::string>& names, std::vector<std::string>& notes);

}  // namespace collided::cli
