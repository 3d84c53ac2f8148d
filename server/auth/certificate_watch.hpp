#pragma once
// The files for TLS while the daemon runs: renewed ones are taken up, those that cannot be used are not.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "server/auth/tls_files.hpp"

namespace collided::server {

/// Thread-safe. Looks at the files twice a second; what it finds counts once it has been there at two looks, so that no
/// file is judged while it is written.
class CertificateWatch {
 public:
  /// `tell` is called for each change of the files: whether they were taken. Throws ConfigError if they cannot be used
  /// to begin with.
  CertificateWatch(const Tls& tls, std::function<void(bool is_taken)> tell);
  ~CertificateWatch();
  CertificateWatch(const CertificateWatch&) = delete;
  CertificateWatch& operator=(const CertificateWatch&) = delete;

  /// The last ones that can be used.
  std::shared_ptr<const TlsFiles> files() const;
  bool asks_clients() const { return !tls_.client_ca.empty(); }

 private:
  void run();
  void look();
  void judge(const TlsFiles& found);

  const Tls tls_;
  const std::function<void(bool)> tell_;
  TlsFiles seen_, judged_;  // of the thread
  mutable std::mutex mutex_;
  std::condition_variable stopping_;
  std::shared_ptr<const TlsFiles> files_;  // guarded by mutex_
  bool is_stopping_ = false;               // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
