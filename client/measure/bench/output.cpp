// Output of 'collidectl bench'.

#include "client/measure/bench/output.hpp"

#include "client/app/output/output.hpp"

namespace collided::cli {

void BenchOutput::show(const std::string& lines) const {
  if (!json_) print_summary(out_, lines);
}

void BenchOutput::keep(const Json& object) {
  object_ = object;
  if (!out_.empty() && !is_standard_output(out_)) write_text(out_, json_lines(object_));
}

void BenchOutput::finish() const {
  if (!object_.is_null() && (json_ || is_standard_output(out_))) write_text("-", json_lines(object_));
}

}  // namespace collided::cli
