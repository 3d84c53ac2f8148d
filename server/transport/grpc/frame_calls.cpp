// The StreamFrames calls and their threads.
#include "server/transport/grpc/frame_calls.hpp"

#include <algorithm>

#include "server/transport/grpc/frame_call.hpp"

namespace collided::server {
namespace {

// Several threads read messages, so that a large one does not delay the small ones of other streams.
unsigned intake_threads() { return std::clamp(std::thread::hardware_concurrency(), 2u, 8u); }

}  // namespace

FrameCalls::FrameCalls(grpc::ServerBuilder& builder, RawService& service, FrameCallParts parts)
    : service_(service), parts_(parts), queue_(builder.AddCompletionQueue()) {}

FrameCalls::~FrameCalls() { stop(); }

void FrameCalls::start() {
  const unsigned count = intake_threads();
  for (unsigned i = 0; i < count; ++i) FrameCall::accept(*this);
  for (unsigned i = 0; i < count; ++i) threads_.emplace_back([this] { run(); });
}

void FrameCalls::run() {
  void* tag = nullptr;
  for (bool ok = false; queue_->Next(&tag, &ok);) static_cast<FrameCall::Tag*>(tag)->arrive(ok);
}

void FrameCalls::add(const std::shared_ptr<FrameCall>& call) {
  const std::lock_guard lock(mutex_);
  std::erase_if(calls_, [](const auto& weak) { return weak.expired(); });
  calls_.push_back(call);
}

std::vector<std::shared_ptr<FrameCall>> FrameCalls::calls() const {
  std::vector<std::shared_ptr<FrameCall>> calls;
  const std::lock_guard lock(mutex_);
  for (const auto& weak : calls_)
    if (auto call = weak.lock()) calls.push_back(std::move(call));
  return calls;
}

void FrameCalls::announce_stop() {
  for (const auto& call : calls()) call->end_unopened();
}

size_t FrameCalls::open() const { return calls().size(); }

uint64_t FrameCalls::outgoing_bytes() const {
  uint64_t bytes = 0;
  for (const auto& call : calls()) bytes += call->outgoing_bytes();
  return bytes;
}

void FrameCalls::stop() {
  if (!queue_) return;
  constexpr auto kPoll = std::chrono::milliseconds(2);
  while (!threads_.empty() && open() > 0) std::this_thread::sleep_for(kPoll);
  queue_->Shutdown();
  if (threads_.empty()) run();  // even an empty queue must be drained
  for (auto& thread : threads_) thread.join();
  threads_.clear();
  queue_.reset();
}

}  // namespace collided::server
