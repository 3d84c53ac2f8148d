#pragma once
// Contacts as CSV: vertex-triangle, edge-edge, triangle-triangle, then edge-triangle rows, each in the daemon's order.
// Flags and features are words, such as "certified|initial"; a field that was not computed is empty.

#include <string>

#include "client/app/output/contact_points.hpp"
#include "client/app/output/number_file.hpp"

namespace collided::cli {

/// A file of the contacts of several frames, which its first column tells apart, or of one frame, without that column.
class CsvFile {
 public:
  enum class Frames { kOne, kMany };
  /// Standard output if its name is "-". Throws std::runtime_error if the file cannot be written, as do all.
  CsvFile(const std::string& file, Frames frames);
  void add(const client::FrameOutput& output, const StepPositions& positions);
  void finish() { rows_.finish(); }

 private:
  NumberFile rows_;
  Frames frames_;
};

/// The names of a contact's columns, with a line break.
std::string csv_header();
/// The rows of one frame in memory, each beginning with `first`.
std::string csv_rows(const std::string& first, const client::FrameOutput& output, const StepPositions& positions);

/// Writes the contacts of one frame.
inline void write_csv(const std::string& file, const client::FrameOutput& output, const StepPositions& positions) {
  CsvFile csv(file, CsvFile::Frames::kOne);
  csv.add(output, positions);
  csv.finish();
}

}  // namespace collided::cli
