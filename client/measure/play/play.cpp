// Plays frames through a stream.

#include "client/measure/play/play.hpp"

#include <exception>

#include "client/app/daemon/connection.hpp"
#include "client/app/daemon/interrupt.hpp"
#include "client/app/output/progress.hpp"

namespace collided::cli {

void play(client::FrameStream& stream, const FrameSource& source,
          const std::function<void(client::FrameOutput)>& take) {
  Progress progress;
  int sent = 0, taken = 0;
  const auto take_one = [&] {
    take(receive(stream));
    ++taken;
    if (!source.is_quiet) progress.show("frames", taken, source.frames);
  };
  std::exception_ptr failure;  // of the source, whose earlier frames still have their answers to come
  const auto next = [&]() -> std::optional<v1::Frame> {
    try {
      return source.next();
    } catch (const std::exception&) {
      failure = std::current_exception();
      return {};
    }
  };
  while (const auto frame = next()) {
    check_interrupt();
    if (sent - taken >= static_cast<int>(stream.window())) take_one();
    stream.send(*frame);
    ++sent;
  }
  while (taken < sent) take_one();
  stream.finish();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace collided::cli
