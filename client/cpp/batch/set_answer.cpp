// What a daemon answers to a set's frame, as the caller gets it.

#include "client/cpp/batch/set_answer.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <cstring>
#include <string>
#include <utility>

namespace collided::client {

namespace {

[[noreturn]] void throw_lost(const std::string& what) { throw Error(grpc::DATA_LOSS, what); }

std::vector<uint64_t> begins_of(const v1::WorldContacts& from, size_t worlds) {
  std::vector<uint64_t> begin(worlds + 1);
  if (from.begin().size() != begin.size() * sizeof(uint64_t))
    throw_lost("contacts.begin has " + std::to_string(from.begin().size()) + " bytes for " + std::to_string(worlds) +
               " worlds");
  std::memcpy(begin.data(), from.begin().data(), from.begin().size());
  for (size_t i = 0; i < worlds; ++i)
    if (begin[i] > begin[i + 1]) throw_lost("contacts.begin descends at entry " + std::to_string(i + 1));
  if (begin[0] != 0 || begin[worlds] != from.contacts().count())
    throw_lost("contacts.begin does not go from 0 to the number of contacts");
  return begin;
}

/// Where the contacts of each of `worlds` begin, of contacts whose worlds ascend.
std::vector<uint64_t> begins_of(const Contacts& contacts, std::span<const uint32_t> worlds) {
  std::vector<uint64_t> begin{0};
  begin.reserve(worlds.size() + 1);
  size_t at = 0;
  for (const uint32_t world : worlds) {
    while (at < contacts.worlds.size() && contacts.worlds[at] == world) ++at;
    begin.push_back(at);
  }
  if (at == contacts.count) return begin;
  throw_lost("contacts.worlds has " + std::to_string(contacts.worlds.size()) + " entries for " +
             std::to_string(contacts.count) + " contacts, of which the first " + std::to_string(at) +
             " are of the frame's worlds in their order");
}

void take(WorldContacts& to, const v1::WorldContacts& from, size_t worlds) {
  if (to.count > 0)
    throw_lost("contacts has two entries of " + v1::ContactKind_Name(from.contacts().kind()) + "; it can have one");
  to.begin = begins_of(from, worlds);
  append(to, from.contacts());
}

}  // namespace

SetOutput read_answer(v1::SetAnswer&& answer, size_t worlds) {
  SetOutput output;
  output.frame_id = answer.frame_id();
  if (!answer.has_error() && !answer.has_done()) throw_lost("answers has an entry that is neither an error nor an end");
  if (answer.has_error()) output.error = std::move(*answer.mutable_error());
  output.done = std::move(*answer.mutable_done());
  output.refused = {answer.errors().begin(), answer.errors().end()};
  for_each_kind([&](v1::ContactKind, WorldContacts& contacts) { contacts.begin.assign(worlds + 1, 0); }, output);
  for (const v1::WorldContacts& from : answer.contacts())
    for_each_kind(
        [&](v1::ContactKind kind, WorldContacts& contacts) {
          if (kind == from.contacts().kind()) take(contacts, from, worlds);
        },
        output);
  return output;
}

SetOutput read_output(FrameOutput&& from, std::span<const uint32_t> worlds) {
  SetOutput output;
  output.frame_id = from.frame_id;
  output.error = std::move(from.error);
  output.done = std::move(from.done);
  output.refused = std::move(from.world_errors);
  for_each_kind(
      [&](v1::ContactKind, WorldContacts& to, Contacts& contacts) {
        to.begin = begins_of(contacts, worlds);
        contacts.worlds.clear();
        static_cast<Contacts&>(to) = std::move(contacts);
      },
      output, from);
  return output;
}

}  // namespace collided::client
