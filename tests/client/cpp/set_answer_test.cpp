// Answers to a set's frame, also those that make no sense.
#include "client/cpp/batch/set_answer.hpp"

#include <grpcpp/support/status_code_enum.h>
#include <gtest/gtest.h>

#include <cstring>

namespace collided::client {
namespace {

template <class T>
std::string packed(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

v1::WorldContacts contacts_of(v1::ContactKind kind, const std::vector<uint64_t>& begin) {
  v1::WorldContacts contacts;
  contacts.set_begin(packed(begin));
  contacts.mutable_contacts()->set_kind(kind);
  contacts.mutable_contacts()->set_count(static_cast<uint32_t>(begin.back()));
  contacts.mutable_contacts()->set_toi(packed(std::vector<double>(begin.back(), 0.5)));
  return contacts;
}

template <class Read>
std::string lost(const Read& read) {
  try {
    read();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), grpc::DATA_LOSS);
    return e.message();
  }
  ADD_FAILURE() << "nothing was refused";
  return "";
}

TEST(SetAnswers, HaveOneEntryOfAKind) {
  v1::SetAnswer answer;
  *answer.add_contacts() = contacts_of(v1::CONTACT_KIND_VERTEX_TRIANGLE, {0, 1, 2});
  *answer.add_contacts() = contacts_of(v1::CONTACT_KIND_EDGE_EDGE, {0, 0, 1});
  answer.mutable_done()->set_contact_count(3);
  const SetOutput output = read_answer(v1::SetAnswer(answer), 2);
  EXPECT_EQ(output.vertex_triangle.begin, (std::vector<uint64_t>{0, 1, 2}));
  EXPECT_EQ(output.edge_edge.begin, (std::vector<uint64_t>{0, 0, 1}));
  EXPECT_EQ(output.triangle_triangle.begin, (std::vector<uint64_t>{0, 0, 0}));
  *answer.add_contacts() = contacts_of(v1::CONTACT_KIND_VERTEX_TRIANGLE, {0, 0, 1});
  EXPECT_EQ(lost([&] { read_answer(v1::SetAnswer(answer), 2); }),
            "contacts has two entries of CONTACT_KIND_VERTEX_TRIANGLE; it can have one");
}

FrameOutput output_of(const std::vector<uint32_t>& worlds) {
  FrameOutput output;
  output.vertex_triangle.count = worlds.size();
  output.vertex_triangle.worlds = worlds;
  return output;
}

TEST(SetAnswers, OfStreamsAreDividedByTheWorldsOfTheFrame) {
  const uint32_t worlds[] = {2, 5, 9};
  const SetOutput output = read_output(output_of({2, 2, 9}), worlds);
  EXPECT_EQ(output.vertex_triangle.begin, (std::vector<uint64_t>{0, 2, 2, 3}));
  EXPECT_EQ(output.edge_edge.begin, (std::vector<uint64_t>{0, 0, 0, 0}));
  EXPECT_TRUE(output.vertex_triangle.worlds.empty());
  const std::string before = "contacts.worlds has 2 entries for 2 contacts, of which the first ";
  EXPECT_EQ(lost([&] {
              read_output(output_of({2, 3}), worlds);
            }),
            before + "1 are of the frame's worlds in their order");
  EXPECT_EQ(lost([&] {
              read_output(output_of({5, 2}), worlds);
            }),
            before + "1 are of the frame's worlds in their order");
  FrameOutput without = output_of({});
  without.vertex_triangle.count = 1;
  lost([&] { read_output(std::move(without), worlds); });
}

}  // namespace
}  // namespace collided::client
