#pragma once
// Contacts of the frames of a stream in files: CSV, and points for ParaView.

#include <optional>
#include <string>
#include <vector>

#include "client/app/options/values.hpp"
#include "client/app/output/csv.hpp"
#include "client/app/output/paraview.hpp"

namespace collided::cli {

/// Files to write; an empty name is none. In the name of one for each frame "{frame}" stands for its number.
struct ContactFileNames {
  std::string csv, vtp, ply;
  bool is_empty() const { return csv.empty() && vtp.empty() && ply.empty(); }
};

/// Throws UsageError for a form that needs points which these options do not compute.
void check_points(const DetectionOptions& detection, const char* option, const std::string& file);

/// Throws UsageError for names that do not fit more than one frame, and std::runtime_error for files that cannot be
/// written.
void check_files(const DetectionOptions& detection, const ContactFileNames& names);

/// The series that ParaView opens, beside the files of the frames: contacts.pvd of contacts_{frame}.vtp.
std::string series_name(const std::string& pattern);

class ContactFiles {
 public:
  explicit ContactFiles(const ContactFileNames& names);
  /// Throws std::runtime_error naming the file.
  void add(const client::FrameOutput& output, const StepPositions& positions);
  /// Also after a stream that ended early: what was added is whole from then on.
  void finish();

 private:
  const ContactFileNames names_;
  std::optional<CsvFile> csv_;  ///< if all frames are in one
  std::vector<TimedFile> series_;
};

}  // namespace collided::cli
