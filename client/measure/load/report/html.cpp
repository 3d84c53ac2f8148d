#include "client/measure/load/report/html.hpp"
namespace collided::cli::load {
std::string outcome_html(const Json& outcome) { return outcome.dump(); }
}  // namespace collided::cli::load
