// Reads how far a frame with `advance` went.

#include "client/cpp/frame_advance.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr int kDataLoss = 15;

[[noreturn]] void throw_lost(const std::string& what) { throw Error(kDataLoss, "shortened." + what); }

template <class T>
void append_bytes(std::vector<T>& out, const std::string& bytes, size_t count) {
  out.resize(out.size() + count);
  std::memcpy(out.data() + out.size() - count, bytes.data(), bytes.size());
}

void check_id(const std::vector<uint32_t>& ids, size_t i, uint64_t id_count) {
  if (ids[i] >= id_count)
    throw_lost("ids names " + std::to_string(ids[i]) + "; it must be below " + std::to_string(id_count));
  if (i > 0 && ids[i] <= ids[i - 1])
    throw_lost("ids names " + std::to_string(ids[i]) + " after " + std::to_string(ids[i - 1]) + "; it must ascend");
}

}  // namespace

double FrameAdvance::of_body(uint32_t mesh, uint32_t first_vertex, uint32_t vertex_count) const {
  const bool is_per_mesh = mode == v1::ADVANCE_MODE_PER_MESH;
  if (!is_per_mesh && mode != v1::ADVANCE_MODE_PER_VERTEX) return advanced;
  const uint32_t first = is_per_mesh ? mesh : first_vertex, count = is_per_mesh ? 1 : vertex_count;
  const auto found = std::lower_bound(ids.begin(), ids.end(), first);
  return found != ids.end() && *found - first < count ? fractions[static_cast<size_t>(found - ids.begin())] : 1;
}

void append(FrameAdvance& advance, const v1::ShortenedWays& ways, uint64_t id_count) {
  const size_t count = ways.ids().size() / sizeof(uint32_t), before = advance.ids.size();
  if (count == 0 || ways.ids().size() != count * sizeof(uint32_t) || ways.fractions().size() != count * sizeof(double))
    throw_lost("ids has " + std::to_string(ways.ids().size()) + " bytes and fractions " +
               std::to_string(ways.fractions().size()) + "; they must be 4 and 8 for each of one or more");
  append_bytes(advance.ids, ways.ids(), count);
  append_bytes(advance.fractions, ways.fractions(), count);
  for (size_t i = before; i < advance.ids.size(); ++i) {
    check_id(advance.ids, i, id_count);
    if (!(advance.fractions[i] >= 0 && advance.fractions[i] < 1))
      throw_lost("fractions has " + std::to_string(advance.fractions[i]) + "; it must be in [0, 1)");
  }
}

}  // namespace collided::client
