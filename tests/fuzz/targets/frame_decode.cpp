// The decoder of frames against the parser that protoc generates. The first byte says how the wire is cut and how many
// meshes the scene has.

#include <google/protobuf/stubs/logging.h>

#include "server/errors.hpp"
#include "tests/fuzz/targets/fuzz.hpp"
#include "tests/server/frames/wire_request.hpp"

namespace collided::fuzz {
namespace {

using namespace server;  // NOLINT: the code under test

struct Settings {
  int block;  ///< bytes that the stream gives at a time; 0: all
  std::optional<size_t> meshes;

  explicit Settings(uint8_t byte) : block(byte & 7) {
    if (byte & 8) meshes = byte >> 4;
  }
};

struct Expected {
  bool is_valid;
  std::string bytes;

  explicit Expected(const std::string& wire) {
    pb::StreamFramesRequest message;
    is_valid = message.ParseFromString(wire);
    message.DiscardUnknownFields();
    bytes = message.SerializeAsString();
  }
};

void check(const DecodedRequest& decoded, const Room& room, const std::string& wire) {
  for (const PlacedPositions& placed : decoded.placed)
    require(room.holds(placed.start) && room.holds(placed.end), "positions are in the room that there is");
  if (decoded.refusal) return require(decoded.message.frame().frame_id() != 0, "a refused frame has an id");
  const Expected expected(wire);
  require(expected.is_valid, "what is decoded is a message");
  require(decoded.placed.size() == static_cast<size_t>(decoded.message.frame().updates_size()),
          "each update is placed");
  require(whole(decoded) == expected.bytes, "it is the message that the generated parser reads");
}

// Of what the generated parser takes, only what the decoder must not take.
void check_refusal(const std::string& what, const std::string& wire) {
  const auto says = [&](const char* words) { return what.find(words) != std::string::npos; };
  const bool is_ours = says("must have one of them") || says(" entries, the number") || says(" levels deep");
  require(is_ours || !Expected(wire).is_valid, "a message is not refused as malformed: " + what);
}

void decode(const Settings& settings, const std::string& wire) {
  Room room(1024);
  try {
    check(decode(wire, room, settings.block, settings.meshes), room, wire);
  } catch (const InvalidInput& e) {
    check_refusal(e.what(), wire);
  } catch (const LimitExceeded&) {
  } catch (const FailedPrecondition&) {
    require(!settings.meshes, "an open stream takes frames");
  }
  require(room.is_intact(), "nothing is written past the room");
}

}  // namespace

void run(Input input) {
  static const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  const Settings settings(input.number<uint8_t>());
  decode(settings, input.rest());
}

}  // namespace collided::fuzz
