// Serves the page and what it shows. The only file that includes Boost.Beast, which takes long to compile.

#include "client/cli/web/page_server.hpp"

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <list>
#include <optional>
#include <stdexcept>
#include <thread>

#include "client/cli/web/messages.hpp"

namespace collided::cli {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;
using Request = http::request<http::empty_body>;

namespace {

/// Connections that have shown the secret, and those that have not yet. Of the latter the oldest gives way to a new
/// one, so that visitors who say nothing keep nobody out.
constexpr size_t kMaxConnections = 64, kMaxStrangers = 256;
constexpr uint32_t kMaxHeaderBytes = 16 << 10;
constexpr size_t kMaxPageMessageBytes = 16;  // kNextFrame
constexpr std::chrono::seconds kHttpTimeout(10), kIdleTimeout(60), kAcceptPause(1);

/// What a browser has been sent of what there is.
struct Shown {
  std::shared_ptr<const std::string> message;
  uint64_t version = 0;
};
/// In the order in which they are sent.
enum Slot : size_t { kStatusSlot, kSceneSlot, kFrameSlot, kSlots };
using Latest = std::array<Shown, kSlots>;

struct Identity {
  std::string page, secret, listen_host;
};

using Refusal = std::pair<http::status, std::string>;

std::string_view view(boost::beast::string_view text) { return {text.data(), text.size()}; }

/// Why a request is not answered with what it asks for.
std::optional<Refusal> refuse(const Request& request, const Identity& own) {
  if (!is_own_host(view(request[http::field::host]), own.listen_host))
    return Refusal{http::status::forbidden, "the Host of the request is not this server"};
  const std::string_view path = view(request.target());
  const std::string_view secret = path.substr(0, std::min(path.size(), own.secret.size() + 1));
  if (!secret.starts_with('/') || !is_equal_secret(secret.substr(1), own.secret))
    return Refusal{http::status::not_found, "not found; open the whole address that collidectl printed"};
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return Refusal{http::status::method_not_allowed, "only GET is served"};
  return {};
}

template <class Body>
void set_fields(http::response<Body>& response) {
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", "frame-ancestors 'none'");  // the page has the rest of its policy
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Referrer-Policy", "no-referrer");
  response.set("X-Content-Type-Options", "nosniff");
  response.keep_alive(false);
}

}  // namespace

/// One browser's connection for what is shown.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(beast::tcp_stream stream, const Latest& latest, std::shared_ptr<void> place)
      : socket_(std::move(stream)), latest_(latest), place_(std::move(place)) {}

  void begin(const Request& request) {
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has timeouts of its own
    socket_.set_option(websocket::stream_base::timeout{kHttpTimeout, kIdleTimeout, true});
    socket_.read_message_max(kMaxPageMessageBytes);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) return;
      self->is_open_ = true;
      self->read();
      self->send_next();
    });
  }

  /// Sends what is newer than what was sent, unless a message is on its way; a frame only where the page asked for it.
  void send_next() {
    if (!is_open_ || on_its_way_) return;
    for (size_t slot = 0; slot < kSlots; ++slot) {
      const Shown& shown = latest_[slot];
      if (!shown.message || shown.version == sent_[slot] || (slot == kFrameSlot && !takes_frame_)) continue;
      sent_[slot] = shown.version;
      if (slot == kFrameSlot) takes_frame_ = false;
      on_its_way_ = shown.message;
      socket_.async_write(asio::buffer(*on_its_way_), [self = shared_from_this()](error_code error, size_t) {
        self->on_its_way_.reset();
        if (!error) self->send_next();
      });
      return;
    }
  }

  void close() {
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

 private:
  void read() {
    socket_.async_read(incoming_, [self = shared_from_this()](error_code error, size_t) {
      if (error) return self->end();
      const bool is_known = self->socket_.got_text() && beast::buffers_to_string(self->incoming_.data()) == kNextFrame;
      if (!is_known) return self->refuse();
      self->incoming_.clear();
      self->takes_frame_ = true;
      self->send_next();
      self->read();
    });
  }

  void refuse() {
    socket_.async_close({websocket::close_code::policy_error, "the page sends nothing but \"next\""},
                        [self = shared_from_this()](error_code) { self->end(); });
  }

  void end() {
    is_open_ = false;
    close();
  }

  websocket::stream<beast::tcp_stream> socket_;
  const Latest& latest_;
  const std::shared_ptr<void> place_;
  beast::flat_buffer incoming_;
  std::shared_ptr<const std::string> on_its_way_;
  std::array<uint64_t, kSlots> sent_{};
  bool is_open_ = false, takes_frame_ = true;
};

class PageServer::State : public std::enable_shared_from_this<State> {
 public:
  State(const ListenAddress& listen, std::string page, std::string secret) try
      : identity_{std::move(page), std::move(secret), listen.host} {
    const auto found = Tcp::resolver(context_).resolve(listen.host, listen.port, Tcp::resolver::passive);
    const Tcp::endpoint endpoint = *found.begin();
    acceptor_.open(endpoint.protocol());
    acceptor_.set_option(Tcp::acceptor::reuse_address(true));
    acceptor_.bind(endpoint);
    acceptor_.listen();
  } catch (const boost::system::system_error& e) {
    throw std::runtime_error("--listen " + listen.host + ":" + listen.port + ": " + e.code().message());
  }

  void run() {
    accept();
    thread_ = std::jthread([this] { context_.run(); });
  }

  void stop() {
    asio::post(context_, [this] {
      error_code ignored;
      acceptor_.close(ignored);
      for (const auto& weak : viewers_)
        if (const auto viewer = weak.lock()) viewer->close();
      context_.stop();
    });
    thread_.join();
  }

  std::string url() const {
    const Tcp::endpoint endpoint = acceptor_.local_endpoint();
    const asio::ip::address address = endpoint.address();
    std::string host = address.to_string();
    if (address.is_unspecified()) host = address.is_v6() ? "::1" : "127.0.0.1";
    if (host.find(':') != std::string::npos) host = "[" + host + "]";
    return "http://" + host + ":" + std::to_string(endpoint.port()) + "/" + identity_.secret + "/";
  }

  bool is_public() const { return !acceptor_.local_endpoint().address().is_loopback(); }

  void show(Slot slot, std::string message) {
    asio::post(context_, [this, slot, message = std::make_shared<const std::string>(std::move(message))] {
      latest_[slot] = {message, latest_[slot].version + 1};
      if (slot == kSceneSlot) latest_[kFrameSlot].message.reset();
      viewers_.remove_if([](const auto& weak) { return weak.expired(); });
      for (const auto& weak : viewers_)
        if (const auto viewer = weak.lock()) viewer->send_next();
    });
  }

 private:
  /// A connection until it has become a Viewer or was answered. It has a place once it has shown the secret.
  struct Visit {
    explicit Visit(Tcp::socket socket) : stream(std::move(socket)) { parser.header_limit(kMaxHeaderBytes); }
    beast::tcp_stream stream;
    beast::flat_buffer buffer{kMaxHeaderBytes};
    http::request_parser<http::empty_body> parser;
    std::shared_ptr<void> place;
  };

  void accept() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return accept_later();  // such as a lack of descriptors
      const auto visit = std::make_shared<Visit>(std::move(socket));
      admit(visit);
      read(visit);
      accept();
    });
  }

  void admit(const std::shared_ptr<Visit>& visit) {
    strangers_.remove_if([](const auto& weak) {
      const auto stranger = weak.lock();
      return !stranger || stranger->place;
    });
    if (strangers_.size() >= kMaxStrangers) {
      if (const auto oldest = strangers_.front().lock()) oldest->stream.close();
      strangers_.pop_front();
    }
    strangers_.push_back(visit);
  }

  void accept_later() {
    pause_.expires_after(kAcceptPause);
    pause_.async_wait([this](error_code error) {
      if (!error) accept();
    });
  }

  void read(const std::shared_ptr<Visit>& visit) {
    visit->stream.expires_after(kHttpTimeout);
    http::async_read(visit->stream, visit->buffer, visit->parser, [this, visit](error_code error, size_t) {
      const bool is_malformed = error.category() == http::make_error_code(http::error::bad_method).category();
      if (error && (!is_malformed || error == http::error::end_of_stream)) return;
      if (error) return answer(visit, http::status::bad_request, "the request is not HTTP as it is served here");
      serve(visit);
    });
  }

  void serve(const std::shared_ptr<Visit>& visit) {
    const Request& request = visit->parser.get();
    if (const auto refusal = refuse(request, identity_)) return answer(visit, refusal->first, refusal->second);
    if (places_.use_count() > static_cast<long>(kMaxConnections))
      return answer(visit, http::status::service_unavailable, "as many browsers look already as this server takes");
    visit->place = places_;
    const std::string_view rest = view(request.target()).substr(identity_.secret.size() + 1);
    if (rest == "/frames") return watch(visit);
    if (rest == "/") return answer(visit, http::status::ok, identity_.page, "text/html; charset=utf-8");
    if (rest.empty()) return answer(visit, http::status::moved_permanently, "the address ends with a /");
    answer(visit, http::status::not_found, "not found");
  }

  void watch(const std::shared_ptr<Visit>& visit) {
    const Request& request = visit->parser.get();
    const std::string_view origin = view(request[http::field::origin]), host = view(request[http::field::host]);
    if (!websocket::is_upgrade(request))
      return answer(visit, http::status::upgrade_required, "frames are sent over a WebSocket");
    if (request.count(http::field::origin) > 0 && !is_own_origin(origin, host))
      return answer(visit, http::status::forbidden, "the Origin of the request is not this server");
    const auto viewer = std::make_shared<Viewer>(std::move(visit->stream), latest_, visit->place);
    viewers_.push_back(viewer);
    viewer->begin(request);
  }

  void answer(const std::shared_ptr<Visit>& visit, http::status status, const std::string& text,
              const char* type = "text/plain; charset=utf-8") {
    const auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    set_fields(*response);
    response->set(http::field::content_type, type);
    if (status == http::status::moved_permanently) response->set(http::field::location, "/" + identity_.secret + "/");
    response->body() = text;
    response->prepare_payload();
    if (visit->parser.get().method() == http::verb::head) response->body().clear();
    visit->stream.expires_after(kHttpTimeout);
    http::async_write(visit->stream, *response, [visit, response](error_code, size_t) {
      error_code ignored;
      visit->stream.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    });
  }

  const Identity identity_;
  asio::io_context context_{1};
  Tcp::acceptor acceptor_{context_};
  asio::steady_timer pause_{context_};
  const std::shared_ptr<int> places_ = std::make_shared<int>();  // each connection has a copy
  Latest latest_;
  std::list<std::weak_ptr<Viewer>> viewers_;
  std::list<std::weak_ptr<Visit>> strangers_;  // the oldest first
  std::jthread thread_;
};

PageServer::PageServer(const ListenAddress& listen, std::string page, std::string secret)
    : state_(std::make_shared<State>(listen, std::move(page), std::move(secret))) {
  state_->run();
}

PageServer::~PageServer() { state_->stop(); }

std::string PageServer::url() const { return state_->url(); }
bool PageServer::is_public() const { return state_->is_public(); }
void PageServer::show_status(std::string message) { state_->show(kStatusSlot, std::move(message)); }
void PageServer::show_scene(std::string message) { state_->show(kSceneSlot, std::move(message)); }
void PageServer::show_frame(std::string message) { state_->show(kFrameSlot, std::move(message)); }

}  // namespace collided::cli
