// Many streams on two threads.

#include "client/measure/load/drive/lane.hpp"

#include <sys/prctl.h>
#include <time.h>

#include <algorithm>
#include <utility>

#include "client/cpp/error.hpp"

namespace collided::cli::load {

namespace {

double cpu_seconds(std::thread& thread) {
  clockid_t clock;
  timespec time{};
  if (pthread_getcpuclockid(thread.native_handle(), &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

Lane::Lane(const Messages& messages)
    : messages_(messages), sender_([this] { run_sender(); }), receiver_([this] { run_receiver(); }) {}

Lane::~Lane() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
    for (const auto& stream : streams_) stream->call->cancel();
    queue_.Shutdown();  // under the mutex: no thread may begin anything on it afterwards
  }
  changed_.notify_all();
  sender_.join();
  receiver_.join();
}

void Lane::open(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                const v1::OpenStream& open, StreamPlace place) {
  const std::lock_guard lock(mutex_);
  auto stream = std::make_unique<Stream>();
  stream->call = std::make_unique<FrameCall>(std::move(channel), std::move(context), queue_, stream.get());
  stream->open = open;
  stream->place = place;
  streams_.push_back(std::move(stream));
  ++states_.opening;
  streams_.back()->call->start();
}

StreamStates Lane::states() const {
  const std::lock_guard lock(mutex_);
  return states_;
}

void Lane::begin(const Phase& phase) {
  {
    const std::lock_guard lock(mutex_);
    due_ = {};
    for (const auto& stream : streams_) {
      stream->is_queued = false;
      stream->pace.begin(phase, stream->place);
      advance(*stream);
    }
  }
  changed_.notify_all();
}

void Lane::stop() {
  const std::lock_guard lock(mutex_);
  for (const auto& stream : streams_) stream->pace.stop();
}

bool Lane::is_idle() const {
  const std::lock_guard lock(mutex_);
  return std::all_of(streams_.begin(), streams_.end(),
                     [](const auto& stream) { return stream->state == State::kEnded || stream->pace.is_idle(); });
}

void Lane::give_up(Time now) {
  const std::lock_guard lock(mutex_);
  for (const auto& stream : streams_) stream->pace.give_up(now, tally_);
}

Tally Lane::take_tally() {
  const std::lock_guard lock(mutex_);
  return std::exchange(tally_, {});
}

Second Lane::take_second() {
  const std::lock_guard lock(mutex_);
  return std::exchange(second_, {});
}

void Lane::finish() {
  const std::lock_guard lock(mutex_);
  is_finishing_ = true;
  for (const auto& stream : streams_)
    if (stream->state == State::kOpen && !stream->is_ending && !stream->pace.is_writing()) stream->call->half_close();
}

double Lane::busiest_thread_seconds() { return std::max(cpu_seconds(sender_), cpu_seconds(receiver_)); }

void Lane::run_sender() {
  prctl(PR_SET_TIMERSLACK, 1);  // wake on time, not up to 50 us late
  std::unique_lock lock(mutex_);
  while (!is_closing_) {
    if (due_.empty()) {
      changed_.wait(lock);
    } else if (const Time next = due_.top().time; next > Clock::now()) {
      changed_.wait_until(lock, next);
    } else {
      Stream& stream = *due_.top().stream;
      due_.pop();
      stream.is_queued = false;
      advance(stream);
    }
  }
}

void Lane::run_receiver() {
  v1::StreamFramesResponse message;  // reused, and with it its memory
  void* next = nullptr;
  for (bool is_ok = false; queue_.Next(&next, &is_ok);) {
    const Time now = Clock::now();
    const FrameCall::Tag& tag = *static_cast<FrameCall::Tag*>(next);
    Stream& stream = *static_cast<Stream*>(tag.owner);
    const bool is_message = tag.event == FrameCall::Event::kRead && is_ok && stream.call->parse(message);
    const std::lock_guard lock(mutex_);
    if (is_closing_) continue;
    if (is_message)
      take(stream, message, now);
    else
      handle(stream, tag.event, is_ok, now);
  }
}

void Lane::take(Stream& stream, const v1::StreamFramesResponse& message, Time now) {
  if (message.has_opened()) {
    stream.pace.open(message.opened().window());
    stream.state = State::kOpen;
    --states_.opening;
    ++states_.open;
  } else if (message.has_done() || message.has_error() || message.has_skipped()) {
    stream.pace.take(message, now, books());
  }
  stream.call->read();
  advance(stream);
}

void Lane::handle(Stream& stream, FrameCall::Event event, bool is_ok, Time now) {
  switch (event) {
    case FrameCall::Event::kStarted:
      if (!is_ok) return stream.call->finish();
      stream.call->write(stream.open);
      return stream.call->read();
    case FrameCall::Event::kWritten:
      stream.pace.written(now);
      if (is_finishing_ && is_ok && !stream.is_ending) return stream.call->half_close();
      return advance(stream);
    case FrameCall::Event::kRead:
      stream.is_ending = true;
      if (is_ok) stream.call->cancel();  // what was read is no message
      return stream.call->finish();
    case FrameCall::Event::kHalfClosed:
      return;
    case FrameCall::Event::kFinished:
      return end(stream);
  }
}

void Lane::end(Stream& stream) {
  --(stream.state == State::kOpen ? states_.open : states_.opening);
  ++states_.ended;
  stream.state = State::kEnded;
  const grpc::Status& status = stream.call->status();
  if (!is_finishing_ || !status.ok()) add(states_.ends, client::code_name(status.error_code()), status.error_message());
}

/// Sends the stream's next frame if it is due and there is room. If it is not due yet, the sender will; if there is no
/// room, the event that makes room leads here again.
void Lane::advance(Stream& stream) {
  if (stream.state != State::kOpen || stream.is_ending || is_finishing_) return;
  const Time now = Clock::now();
  if (stream.pace.due() <= now && stream.pace.can_send())
    stream.call->write(messages_.frame(stream.pace.send(now, books())));
  const Time due = stream.pace.due();
  if (due <= now || due == kNever || stream.is_queued) return;
  const bool is_first = due_.empty() || due < due_.top().time;
  stream.is_queued = true;
  due_.push({due, &stream});
  if (is_first) changed_.notify_one();
}

}  // namespace collided::cli::load
