// Flow control of a stream: the table of its header, cell by cell, and random events against a model that keeps a list
// of all that has happened and counts it anew for each question.
#include "server/frames/stream_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace collided::server {
namespace {

constexpr uint32_t kWindow = 2;

using Event = std::function<void(StreamFlow&)>;

const std::map<std::string, Event>& events() {
  static const std::map<std::string, Event> all = {
      {"open", [](StreamFlow& flow) { flow.open(kWindow); }},
      {"opened", [](StreamFlow& flow) { flow.opened(); }},
      {"submit", [](StreamFlow& flow) { flow.submit(1, false); }},
      {"edit", [](StreamFlow& flow) { flow.submit(2, true); }},
      {"answer", [](StreamFlow& flow) { flow.answer(2); }},
      {"release", [](StreamFlow& flow) { flow.release(); }},
      {"half_close", [](StreamFlow& flow) { flow.half_close(); }},
      {"end", [](StreamFlow& flow) { flow.end(); }},
  };
  return all;
}

struct State {
  std::string name;
  std::vector<std::string> reached_by;
  std::vector<std::string> misuse;
  bool may_read, is_complete;
};

// Each phase, with and without half-close, frames in flight and an edit.
const State kStates[] = {
    {"unopened", {}, {"opened", "submit", "edit", "answer", "release"}, true, false},
    {"unopened, half-closed", {"half_close"}, {"opened", "submit", "edit", "answer", "release"}, false, true},
    {"opening", {"open"}, {"open", "answer", "release"}, true, false},
    {"opening, half-closed", {"open", "half_close"}, {"open", "answer", "release"}, false, false},
    {"opening, window used up", {"open", "submit", "submit"}, {"open", "answer", "release"}, false, false},
    {"opening, edit", {"open", "edit"}, {"open", "answer", "release"}, false, false},
    {"open", {"open", "opened"}, {"open", "opened", "release"}, true, false},
    {"open, half-closed", {"open", "opened", "half_close"}, {"open", "opened", "release"}, false, true},
    {"open, a credit left", {"open", "opened", "submit"}, {"open", "opened"}, true, false},
    {"open, window used up", {"open", "opened", "submit", "submit"}, {"open", "opened"}, false, false},
    {"open, half-closed, in flight", {"open", "opened", "submit", "half_close"}, {"open", "opened"}, false, false},
    {"open, edit", {"open", "opened", "edit"}, {"open", "opened"}, false, false},
    {"open, edit answered", {"open", "opened", "edit", "answer"}, {"open", "opened"}, true, false},
    {"open, edit done", {"open", "opened", "edit", "answer", "release"}, {"open", "opened", "release"}, true, false},
    {"ended", {"end"}, {}, false, false},
    {"ended, half-closed", {"half_close", "end"}, {}, false, false},
    {"ended, in flight", {"open", "opened", "submit", "end"}, {}, false, false},
};

StreamFlow flow_in(const State& state) {
  StreamFlow flow;
  for (const std::string& event : state.reached_by) events().at(event)(flow);
  return flow;
}

TEST(StreamFlow, AnswersBothQuestionsInEachState) {
  for (const State& state : kStates) {
    const StreamFlow flow = flow_in(state);
    EXPECT_EQ(flow.may_read(), state.may_read) << state.name;
    EXPECT_EQ(flow.is_complete(), state.is_complete) << state.name;
  }
}

TEST(StreamFlow, RefusesMisuseInEachStateAndNothingElse) {
  for (const State& state : kStates)
    for (const auto& [name, event] : events()) {
      StreamFlow flow = flow_in(state);
      const bool is_misuse = std::ranges::find(state.misuse, name) != state.misuse.end();
      if (is_misuse)
        EXPECT_THROW(event(flow), std::logic_error) << state.name << ": " << name;
      else
        EXPECT_NO_THROW(event(flow)) << state.name << ": " << name;
      if (!is_misuse) continue;
      EXPECT_EQ(flow.may_read(), state.may_read) << state.name << ": " << name;
      EXPECT_EQ(flow.is_complete(), state.is_complete) << state.name << ": " << name;
    }
}

TEST(StreamFlow, IgnoresAllEventsAfterTheEnd) {
  for (const auto& [name, event] : events()) {
    StreamFlow flow = flow_in({"", {"open", "opened", "edit", "end"}, {}, false, false});
    event(flow);
    EXPECT_TRUE(flow.is_ended()) << name;
    EXPECT_FALSE(flow.accepts()) << name;
    EXPECT_FALSE(flow.may_read()) << name;
    EXPECT_FALSE(flow.is_complete()) << name;
  }
}

TEST(StreamFlow, SaysWhenReadingBecomesPossible) {
  StreamFlow flow = flow_in({"", {"open", "opened", "submit", "edit"}, {}, false, false});
  EXPECT_FALSE(flow.answer(1));
  EXPECT_FALSE(flow.answer(2));  // the window is used up
  EXPECT_TRUE(flow.release());
  EXPECT_FALSE(flow.release());  // it was possible before
  flow.submit(3, true);
  EXPECT_FALSE(flow.answer(2));  // another frame's
  EXPECT_TRUE(flow.has_edit());
  EXPECT_TRUE(flow.answer(3));
}

TEST(StreamFlow, DoesNotReadAfterHalfCloseHoweverManyCreditsThereAre) {
  StreamFlow flow = flow_in({"", {"open", "opened", "edit", "half_close"}, {}, false, false});
  EXPECT_FALSE(flow.answer(2));
  EXPECT_FALSE(flow.is_complete());
  EXPECT_FALSE(flow.release());
  EXPECT_TRUE(flow.is_complete());
}

// What happened, in order; each question is answered by reading all of it.
class History {
 public:
  struct Entry {
    char event;
    uint64_t id = 0;
  };

  void add(char event, uint64_t id = 0) { all_.push_back({event, id}); }
  bool has(char event) const { return count(event) > 0; }
  bool reads(uint32_t window) const {
    if (has('x') || has('h')) return false;
    return !has('o') || (unanswered() < window && !has_edit());
  }
  bool is_complete() const { return !has('x') && has('h') && has('o') == has('O') && unanswered() == 0; }
  long unanswered() const { return count('s') + count('e') - count('r'); }
  bool has_edit() const {
    return std::ranges::any_of(all_, [&](const Entry& edit) {
      return edit.event == 'e' &&
             std::ranges::none_of(all_, [&](const Entry& other) { return other.event == 'a' && other.id == edit.id; });
    });
  }

 private:
  long count(char event) const { return std::ranges::count(all_, event, &Entry::event); }

  std::vector<Entry> all_;
};

// A transport that obeys may_read(), and a scene that answers frames in their order, at random times.
TEST(StreamFlow, AgreesWithAHistoryOfAllEvents) {
  for (uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const uint32_t window = 1 + random() % 4;
    StreamFlow flow;
    History history;
    uint64_t submitted = 0, answered = 0, released = 0;
    for (int step = 0; step < 200; ++step) {
      const bool could_read = history.reads(window);
      bool says_so = false;
      switch (random() % 16) {
        case 0:
          if (!history.has('o')) flow.open(window), history.add('o');
          break;
        case 1:
          if (history.has('o') && !history.has('O')) flow.opened(), history.add('O');
          break;
        case 2:
          if (random() % 64 == 0) flow.half_close(), history.add('h');
          break;
        case 3:
          if (random() % 64 == 0) flow.end(), history.add('x');
          break;
        case 4:
        case 5:
        case 6:
        case 7: {
          if (!history.has('o') || !flow.may_read()) break;
          const bool edits = random() % 8 == 0;
          flow.submit(++submitted, edits);
          history.add(edits ? 'e' : 's', submitted);
          break;
        }
        case 8:
        case 9:
        case 10:
        case 11:
          if (!history.has('O') || answered == submitted) break;
          says_so = flow.answer(++answered);
          history.add('a', answered);
          EXPECT_EQ(says_so, !could_read && history.reads(window)) << seed << ", step " << step;
          break;
        default:
          if (!history.has('O') || released == answered) break;
          says_so = flow.release();
          history.add('r', ++released);
          EXPECT_EQ(says_so, !could_read && history.reads(window)) << seed << ", step " << step;
      }
      ASSERT_EQ(flow.may_read(), history.reads(window)) << seed << ", step " << step;
      ASSERT_EQ(flow.is_complete(), history.is_complete()) << seed << ", step " << step;
      ASSERT_EQ(flow.is_ended(), history.has('x')) << seed << ", step " << step;
      ASSERT_TRUE(history.has('x') || flow.has_edit() == history.has_edit()) << seed << ", step " << step;
    }
  }
}

}  // namespace
}  // namespace collided::server
