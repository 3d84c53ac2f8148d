#pragma once
// Certificates in their own folder, made by openssl.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace collided::test {

/// NAME.pem and NAME.key for: ca, other-ca; server (localhost, of ca), other-server (localhost, of other-ca);
/// client (common name sim-1, of ca), alternative (of ca, without a common name: sim-4.example is its alternative
/// name), expired (of ca), stranger (of other-ca), self-signed. Also text.pem, which is not a certificate, and
/// locked.key, which needs a password.
class Certificates {
 public:
  Certificates() {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-tls-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    make_ca("ca");
    make_ca("other-ca");
    make("server", "localhost", "ca");
    make("other-server", "localhost", "other-ca");
    make("client", "sim-1", "ca");
    make("expired", "sim-2", "ca", "-days 0");  // OpenSSL 3.5 makes none that ends before it begins
    make("stranger", "sim-3", "other-ca");
    make_named("alternative", "/O=robots", "sim-4.example", "ca");
    make_ca("self-signed");
    std::ofstream(path("text.pem")) << "none\n";
    run("openssl ec -aes128 -passout pass:secret -in server.key -out locked.key");
  }
  ~Certificates() { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(path(name)).rdbuf();
    return text.str();
  }
  /// The certificate and key of `from` become those of `to`.
  void copy(const std::string& from, const std::string& to) const {
    for (const auto* type : {".key", ".pem"})
      std::filesystem::copy_file(path(from + type), path(to + type), std::filesystem::copy_options::overwrite_existing);
  }

  void make_named(const std::string& name, const std::string& subject, const std::string& alternative,
                  const std::string& ca, const std::string& days = "-days 2") const {
    run("openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj " + subject + " -keyout " + name +
        ".key -out " + name + ".csr");
    std::ofstream(path("san")) << "subjectAltName=DNS:" << alternative << "\n";
    run("openssl x509 -req -in " + name + ".csr -CA " + ca + ".pem -CAkey " + ca +
        ".key -CAcreateserial -extfile san " + days + " -out " + name + ".pem");
  }

 private:
  void run(const std::string& command) const {
    const auto line = "cd " + folder_ + " && " + command + " >>log 2>&1";
    if (std::system(line.c_str()) != 0) throw std::runtime_error(command + ": " + read("log"));
  }
  void make_ca(const std::string& name) const {
    run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=" + name + " -keyout " +
        name + ".key -out " + name + ".pem");
  }
  void make(const std::string& name, const std::string& subject, const std::string& ca,
            const std::string& days = "-days 2") const {
    make_named(name, "/CN=" + subject, subject, ca, days);
  }
  std::string folder_;
};

}  // namespace collided::test
