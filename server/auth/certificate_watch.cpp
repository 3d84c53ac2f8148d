// Watches the TLS files while the daemon runs.
#include "server/auth/certificate_watch.hpp"

#include <chrono>
#include <utility>

#include "server/ops/log.hpp"

namespace collided::server {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(500);

// A missing file reads as empty, which is equally unusable.
TlsFiles read_or_empty(const Tls& tls) try { return read_tls_files(tls); } catch (const ConfigError&) {
  return {};
}

}  // namespace

CertificateWatch::CertificateWatch(const Tls& tls, std::function<void(bool)> tell)
    : tls_(tls),
      tell_(std::move(tell)),
      seen_(sound_tls_files(tls)),
      judged_(seen_),
      files_(std::make_shared<const TlsFiles>(seen_)),
      thread_([this] { run(); }) {}

CertificateWatch::~CertificateWatch() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stopping_.notify_all();
  thread_.join();
}

std::shared_ptr<const TlsFiles> CertificateWatch::files() const {
  const std::lock_guard lock(mutex_);
  return files_;
}

void CertificateWatch::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_.wait_for(lock, kPeriod, [this] { return is_stopping_; })) {
    lock.unlock();
    check();
    lock.lock();
  }
}

void CertificateWatch::check() {
  TlsFiles found = read_or_empty(tls_);
  const bool is_settled = found == seen_;
  seen_ = std::move(found);
  if (!is_settled || seen_ == judged_) return;
  judged_ = seen_;
  judge(seen_);
}

void CertificateWatch::judge(const TlsFiles& found) try {
  if (found == *files()) return;  // the previous files are back
  auto files = std::make_shared<const TlsFiles>(found == TlsFiles() ? read_tls_files(tls_) : found);
  check_tls_files(tls_, *files);
  {
    const std::lock_guard lock(mutex_);
    files_ = std::move(files);
  }
  log_event(spdlog::level::info, "renewed TLS files loaded", {{"certificate", tls_.certificate}});
  tell_(true);
} catch (const ConfigError& error) {
  log_event(spdlog::level::warn, "TLS files cannot be used, keeping the previous ones", {{"reason", error.what()}});
  tell_(false);
}

}  // namespace collided::server
