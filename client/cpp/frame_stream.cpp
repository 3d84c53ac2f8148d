// Frames in, contacts out. A thread of its own reads all the time: a writer that waited for the daemon while the daemon
// waited for its answers to be read would wait for ever.

#include "client/cpp/frame_stream.hpp"

#include "client/cpp/error.hpp"
#include "client/cpp/frame_stream_state.hpp"

namespace collided::client {

namespace {

Contacts& contacts_of(FrameOutput& output, v1::ContactKind kind) {
  switch (kind) {
    case v1::CONTACT_KIND_VERTEX_TRIANGLE:
      return output.vertex_triangle;
    case v1::CONTACT_KIND_EDGE_EDGE:
      return output.edge_edge;
    case v1::CONTACT_KIND_TRIANGLE_TRIANGLE:
      return output.triangle_triangle;
    default:
      throw Error(grpc::DATA_LOSS, "contacts.kind is " + std::to_string(kind) + ", which this client does not know");
  }
}

}  // namespace

void FrameOutput::check() const {
  if (error) throw Error(error->code(), error->message(), error->field());
}

FrameStream::State::State(v1::CollisionService::Stub& stub, const std::string& scene_id, uint32_t window,
                          uint64_t max_bytes)
    : call(stub.StreamFrames(&context)), max_message_bytes(max_bytes) {
  v1::StreamFramesRequest request;
  request.mutable_open()->set_scene_id(scene_id);
  request.mutable_open()->set_window(window);
  v1::StreamFramesResponse response;
  if (!call->Write(request) || !call->Read(&response)) client::check(call->Finish());
  if (!response.has_opened()) throw Error(grpc::INTERNAL, "the daemon's first answer does not open the stream");
  opened = std::move(*response.mutable_opened());
  reader = std::thread([this] { read_all(); });
}

FrameStream::State::~State() {
  {
    const std::lock_guard lock(mutex);
    if (!ended) context.TryCancel();
  }
  if (reader.joinable()) reader.join();
}

void FrameStream::State::read_all() {
  v1::StreamFramesResponse response;
  grpc::Status failure;
  try {
    while (call->Read(&response)) take(response);
  } catch (const Error& e) {  // a malformed chunk: the stream can't be trusted any more
    failure = grpc::Status(static_cast<grpc::StatusCode>(e.code()), e.message());
    context.TryCancel();
  }
  grpc::Status end = call->Finish();
  const std::lock_guard lock(mutex);
  status = failure.ok() ? std::move(end) : std::move(failure);
  ended = true;
  changed.notify_all();
}

void FrameStream::State::take(v1::StreamFramesResponse& response) {
  const uint64_t id = response.frame_id();
  switch (response.response_case()) {
    case v1::StreamFramesResponse::kContacts:
      return append(contacts_of(partial[id], response.contacts().kind()), response.contacts());
    case v1::StreamFramesResponse::kDone:
      partial[id].done = std::move(*response.mutable_done());
      break;
    case v1::StreamFramesResponse::kError:
      partial[id].error = std::move(*response.mutable_error());
      break;
    case v1::StreamFramesResponse::kSkipped:
      partial[id].skipped = true;
      break;
    default:
      return;  // draining: the frames in flight are still answered
  }
  complete(id);
}

void FrameStream::State::complete(uint64_t frame_id) {
  FrameOutput output = std::move(partial[frame_id]);
  partial.erase(frame_id);
  output.frame_id = frame_id;
  const std::lock_guard lock(mutex);
  ready.push_back(std::move(output));
  if (in_flight > 0) --in_flight;
  changed.notify_all();
}

void FrameStream::State::throw_ended() const {
  client::check(status);
  throw Error(grpc::UNAVAILABLE, "the stream has ended");
}

FrameStream::FrameStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
FrameStream::FrameStream(FrameStream&&) noexcept = default;
FrameStream& FrameStream::operator=(FrameStream&&) noexcept = default;
FrameStream::~FrameStream() = default;

const v1::Scene& FrameStream::scene() const { return state_->opened.scene(); }
uint32_t FrameStream::window() const { return state_->opened.window(); }

void FrameStream::send(const v1::Frame& frame) {
  v1::StreamFramesRequest request;
  *request.mutable_frame() = frame;
  if (const uint64_t bytes = request.ByteSizeLong(); bytes > state_->max_message_bytes)
    throw Error(grpc::RESOURCE_EXHAUSTED, "frame is " + std::to_string(bytes) + " bytes; the daemon's limit is " +
                                              std::to_string(state_->max_message_bytes) + " (--max-message-mb)");
  {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return state_->ended || state_->in_flight < window(); });
    if (state_->ended) state_->throw_ended();
    ++state_->in_flight;
  }
  if (state_->call->Write(request)) return;
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [&] { return state_->ended; });  // the reader brings the reason
  state_->throw_ended();
}

FrameOutput FrameStream::receive() {
  std::unique_lock lock(state_->mutex);
  if (state_->ready.empty() && state_->in_flight == 0 && !state_->ended)
    throw Error(grpc::FAILED_PRECONDITION, "receive() was called with no frame in flight");
  state_->changed.wait(lock, [&] { return state_->ended || !state_->ready.empty(); });
  if (state_->ready.empty()) state_->throw_ended();
  FrameOutput output = std::move(state_->ready.front());
  state_->ready.pop_front();
  return output;
}

void FrameStream::finish() {
  if (!state_->half_closed) state_->call->WritesDone();
  state_->half_closed = true;
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [&] { return state_->ended; });
  client::check(state_->status);
}

}  // namespace collided::client
