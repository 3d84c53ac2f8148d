#pragma once
// Who may read a scene through collidectl view. The page's address has a secret. Beside it, what browsers tell of
// themselves is checked, so that another website cannot use a browser that knows the secret, nor a name that it makes
// point here (DNS rebinding).

#include <string>
#include <string_view>

namespace collided::cli {

struct ListenAddress {
  std::string host = "127.0.0.1";
  std::string port = "0";
};

/// "HOST:PORT", "[IPV6]:PORT", or one of them without the port. Throws UsageError naming --listen.
ListenAddress parse_listen_address(const std::string& text);

/// Returns 128 bits of the operating system's generator as hexadecimal digits.
std::string make_secret();
/// The one word in a file, 16 to 128 letters, digits, - and _. Throws std::runtime_error naming --secret-file.
std::string read_secret(const std::string& file);
/// In constant time.
bool is_equal_secret(std::string_view a, std::string_view b);

/// Whether a request may be meant for this server: `host_header` is an IP address, localhost, or the name that it
/// listens on, with any port (tunnels change it).
bool is_own_host(std::string_view host_header, std::string_view listen_host);
/// Whether the page that opens a connection came from this server. Programs that are no browsers send no origin.
bool is_own_origin(std::string_view origin, std::string_view host_header);

}  // namespace collided::cli
