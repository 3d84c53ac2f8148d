#include "gpu/scene/shards/merged.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "gpu/base/keys.hpp"

namespace collided {
namespace {

constexpr uint64_t kAlignment = 64;

uint64_t key_at(const ContactSet& set, size_t i) { return pack_ids(set.elements[i][0], set.elements[i][1]); }

/// A stage that runs several times counts with its sum; of several shards, with the slowest one's.
std::vector<StageTime> slowest_stages(const std::vector<FrameResult>& shards) {
  std::vector<StageTime> all;
  for (const FrameResult& shard : shards) {
    std::map<std::string, double> sums;
    for (const StageTime& stage : shard.stages) {
      sums[stage.stage] += stage.milliseconds;
      const auto is_it = [&](const StageTime& known) { return known.stage == stage.stage; };
      if (std::none_of(all.begin(), all.end(), is_it)) all.push_back({stage.stage, 0});
    }
    for (StageTime& stage : all) stage.milliseconds = std::max(stage.milliseconds, sums[stage.stage]);
  }
  return all;
}

void add(PerKind<uint64_t>& sum, const PerKind<uint64_t>& more) {
  for_each_kind([](ContactKind, uint64_t& to, uint64_t from) { to += from; }, sum, more);
}

void add(FrameCounts& sum, const FrameCounts& more) {
  sum.cells += more.cells, sum.leaves += more.leaves;
  sum.registrations += more.registrations, sum.tests += more.tests, sum.pairs += more.pairs;
  sum.exact_decisions += more.exact_decisions;
  sum.top_level = std::max(sum.top_level, more.top_level), sum.base_level = std::max(sum.base_level, more.base_level);
  add(sum.candidates, more.candidates);
  add(sum.survivors, more.survivors);
}

}  // namespace

void MergedContacts::take(AnswerRoom& room, uint64_t bytes_beside_contact) {
  clear();
  PerKind<uint64_t> counts;
  PerKind<FieldSet> fields;
  for_each_kind(
      [&](ContactKind kind, uint64_t& count, FieldSet& present) {
        for (const FrameResult& shard : shards_) {
          count += set_of(shard, kind).size();
          for_each_field(
              [&](ContactField field, const auto& column) {
                if (!column.empty()) present = present.with(field);
              },
              set_of(shard, kind));
        }
      },
      counts, fields);
  uint64_t bytes = 0, contacts = 0;
  const auto for_each_array = [&](const auto& use) {
    for_each_kind(
        [&](ContactKind, uint64_t count, FieldSet present, ContactSet& set) {
          for_each_field(
              [&](ContactField field, auto& column) {
                if (present.has(field)) use(column, count);
              },
              set);
        },
        counts, fields, contacts_);
  };
  const auto aligned_bytes = [](const auto& column, uint64_t count) {
    return (count * sizeof(*column.data()) + kAlignment - 1) / kAlignment * kAlignment;
  };
  for_each_array([&](auto& column, uint64_t count) { bytes += aligned_bytes(column, count); });
  for_each_kind([&](ContactKind, uint64_t count) { contacts += count; }, counts);
  if (contacts == 0) return;
  memory_ = room.take(bytes, contacts * bytes_beside_contact);
  std::byte* next = memory_.get();
  for_each_array([&]<class T>(Column<T>& column, uint64_t count) {
    column = Column<T>(std::shared_ptr<T>(memory_, reinterpret_cast<T*>(next)), count);
    next += aligned_bytes(column, count);
  });
}

void MergedContacts::place(size_t shard) const {
  for_each_kind([&](ContactKind kind, ContactSet to) { place(shard, kind, to); }, contacts_);
}

/// A contact's place is how many of each shard come before it.
void MergedContacts::place(size_t shard, ContactKind kind, ContactSet& to) const {
  constexpr size_t kAtATime = 1024;
  const ContactSet& own = set_of(shards_[shard], kind);
  std::vector<size_t> before(shards_.size());
  std::array<size_t, kAtATime> places;
  for (size_t first = 0; first < own.size(); first += kAtATime) {
    const size_t end = std::min(own.size(), first + kAtATime);
    for (size_t i = first; i < end; ++i) {
      const uint64_t key = key_at(own, i);
      size_t place = i;
      for (size_t other = 0; other < shards_.size(); ++other) {
        if (other == shard) continue;
        const ContactSet& set = set_of(shards_[other], kind);
        while (before[other] < set.size() && key_at(set, before[other]) < key) ++before[other];
        place += before[other];
      }
      places[i - first] = place;
    }
    for_each_field(
        [&](ContactField, const auto& from, auto& column) {
          for (size_t i = first; i < end && !from.empty(); ++i) column[places[i - first]] = from[i];
        },
        own, to);
  }
}

std::shared_ptr<const void> MergedContacts::move_to(PerKind<ContactSet>& contacts) {
  contacts = std::move(contacts_);
  std::shared_ptr<const void> memory = std::move(memory_);
  clear();
  return memory;
}

FrameResult merged_facts(const std::vector<FrameResult>& shards, Report report) {
  const FrameResult& first = shards.front();
  FrameResult all;
  all.broad_phase = first.broad_phase;
  all.reuse = first.reuse;
  // What they agreed on.
  all.advanced = first.advanced, all.way = first.way;
  all.shortened = first.shortened;
  all.unused_options = first.unused_options;
  all.stages = slowest_stages(shards);
  for (const FrameResult& shard : shards) {
    add(all.counts, shard.counts);
    all.replays += shard.replays, all.allocations += shard.allocations, all.graph_launches += shard.graph_launches;
    all.step_milliseconds = std::max(all.step_milliseconds, shard.step_milliseconds);
    all.earliest_toi = std::min(all.earliest_toi, shard.earliest_toi);
    all.any_contact |= shard.any_contact;
    all.input_resolution |= shard.input_resolution;
  }
  for (const FrameResult& shard : shards)  // of those that are later than another shard's nobody asks
    if (report != Report::kEarliestOnly || shard.earliest_toi == all.earliest_toi)
      add(all.counts.contacts, shard.counts.contacts);
  return all;
}

}  // namespace collided
