#pragma once
// Where 'collidectl bench' tells what it finds: a table run by run, and one JSON object in a file, which always holds
// the runs so far, or on standard output at the end.

#include <string>

#include "client/cli/report/json.hpp"

namespace collided::cli {

class BenchOutput {
 public:
  /// `json`: the object goes to standard output, instead of the table. `out`: also to that file, if it is not empty.
  BenchOutput(std::string out, bool json) : out_(std::move(out)), json_(json) {}
  /// Lines of the table.
  void show(const std::string& lines) const;
  /// The object of all runs so far.
  void keep(const Json& object);
  /// Prints the object, if it is to go to standard output and there is one.
  void finish() const;

 private:
  std::string out_;
  bool json_;
  Json object_;
};

}  // namespace collided::cli
