#pragma once
// Watches the TLS files while the daemon runs: renewed ones are loaded unless they are unusable.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "server/auth/tls_files.hpp"

namespace collided::server {

/// Thread-safe. Reads the files twice a second; a change counts once two readings agree, so that half-written files are
/// not judged.
class CertificateWatch {
 public:
  /// `tell` is called at each change of the files, with whether they were loaded. Throws ConfigError if the files are
  /// unusable at the start.
  CertificateWatch(const Tls& tls, std::function<void(bool is_taken)> tell);
  ~CertificateWatch();
  CertificateWatch(const CertificateWatch&) = delete;
  CertificateWatch& operator=(const CertificateWatch&) = delete;

  /// The last usable ones.
  std::shared_ptr<const TlsFiles> files() const;
  bool asks_clients() const { return !tls_.client_ca.empty(); }

 private:
  void run();
  void check();
  void judge(const TlsFiles& found);

  const Tls tls_;
  const std::function<void(bool)> tell_;
  TlsFiles seen_, judged_;  // owned by the thread
  mutable std::mutex mutex_;
  std::condition_variable stopping_;
  std::shared_ptr<const TlsFiles> files_;  // guarded by mutex_
  bool is_stopping_ = false;               // guarded by mutex_
  std::thread thread_;
};

}  // namespace collided::server
