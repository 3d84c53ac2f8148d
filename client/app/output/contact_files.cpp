// Contacts of the frames of a stream in files: CSV, and points for ParaView.

#include "client/app/output/contact_files.hpp"

#include <algorithm>
#include <filesystem>

#include "client/app/options/usage_error.hpp"
#include "client/app/output/numbered.hpp"

namespace collided::cli {

void check_points(const DetectionOptions& detection, const char* option, const std::string& file) {
  if (file.empty()) return;
  if (is_standard_output(file)) throw UsageError(std::string(option) + " is a file here; standard output (-) is none");
  const auto has = [&](const char* kind) {
    return std::count(detection.kinds.begin(), detection.kinds.end(), kind) > 0;
  };
  if (detection.accuracy == "candidates" || has("tt"))
    throw UsageError(std::string(option) +
                     " needs contact points, which --accuracy candidates and --kinds tt do not have");
}

void check_files(const DetectionOptions& detection, const ContactFileNames& names) {
  const auto check_one_each = [&](const char* option, const std::string& file) {
    check_points(detection, option, file);
    if (!file.empty() && !is_numbered(file))
      throw UsageError(std::string(option) + " " + file +
                       ": a file for each frame needs {frame} in its name, such as " + "contacts_{frame}." +
                       (option + 2));
    if (is_numbered(std::filesystem::path(file).parent_path().string()))
      throw UsageError(std::string(option) + " " + file + ": {frame} is for the name of the file, not of its folder");
    check_writable(option, numbered(file, 1));
  };
  check_one_each("--vtp", names.vtp);
  check_one_each("--ply", names.ply);
  check_writable("--out", numbered(names.csv, 1));
}

std::string series_name(const std::string& pattern) {
  const std::filesystem::path path(pattern);
  std::string stem = path.stem().string();
  for (size_t at; (at = stem.find(kFrameField)) != std::string::npos;) {
    const bool has_separator = at > 0 && std::string_view("_-.").find(stem[at - 1]) != std::string_view::npos;
    stem.erase(at - has_separator, kFrameField.size() + has_separator);
  }
  return (path.parent_path() / ((stem.empty() ? "contacts" : stem) + ".pvd")).string();
}

ContactFiles::ContactFiles(const ContactFileNames& names) : names_(names) {
  if (!names.csv.empty() && !is_numbered(names.csv)) csv_.emplace(names.csv, CsvFile::Frames::kMany);
}

void ContactFiles::add(const client::FrameOutput& output, const StepPositions& positions) {
  const uint64_t frame = output.frame_id;
  if (csv_) csv_->add(output, positions);
  if (is_numbered(names_.csv)) write_csv(numbered(names_.csv, frame), output, positions);
  if (!names_.ply.empty()) write_ply(numbered(names_.ply, frame), output, positions);
  if (names_.vtp.empty()) return;
  const std::string vtp = numbered(names_.vtp, frame);
  write_vtp(vtp, output, positions);
  series_.push_back({static_cast<double>(frame), std::filesystem::path(vtp).filename().string()});
}

void ContactFiles::finish() {
  if (csv_) csv_->finish();
  if (!names_.vtp.empty()) write_pvd(series_name(names_.vtp), series_);
}

}  // namespace collided::cli
