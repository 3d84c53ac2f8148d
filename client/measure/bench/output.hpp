#pragma once
// Output of 'collidectl bench': a table, printed run by run, and one JSON object, in a file that always holds the runs
// so far or on standard output at the end.

#include <string>

#include "client/app/report/json.hpp"

namespace collided::cli {

class BenchOutput {
 public:
  /// `json`: print the object instead of the table. `out`: a file for the object; empty: none.
  BenchOutput(std::string out, bool json) : out_(std::move(out)), json_(json) {}
  /// Prints lines of the table.
  void show(const std::string& lines) const;
  /// Takes the object of all runs so far, and writes it to the file.
  void keep(const Json& object);
  /// Prints the object, if there is one and it goes to standard output.
  void finish() const;

 private:
  std::string out_;
  bool json_;
  Json object_;
};

}  // namespace collided::cli
