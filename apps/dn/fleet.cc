#include "fleet.h"

#include <dn/interrupted.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

namespace dn::apps {
namespace {

class Fleet {
 public:
  Fleet(std::size_t count, Run* run, const std::function<void(std::size_t)>& fly,
        const std::function<void(std::size_t)>& on_finished, const std::string& what)
      : count_(count), run_(run), fly_(fly), landed_(on_finished), what_(what) {}

  void Fly() {
    std::vector<std::thread> threads;
    const std::size_t workers = std::min(static_cast<std::size_t>(run_->options().threads), count_);
    threads.reserve(workers);
    try {
      for (std::size_t i = 1; i < workers; ++i) threads.emplace_back([this] { Work(); });
    } catch (const std::system_error&) {
      run_->progress().Warn(
          fmt::format("only {} of {} threads can be started", threads.size() + 1, workers));
    }
    Work();
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
    if (SignalReceived()) throw dn::Interrupted();
  }

 private:
  void Work() {
    for (;;) {
      const std::size_t k = next_++;
      if (k >= count_ || SignalReceived() || failed_) return;
      try {
        fly_(k);
        const std::lock_guard lock(mutex_);
        landed_(k);
        run_->progress().Stage(
            what_, Share{static_cast<double>(++done_), static_cast<double>(count_), ""});
      } catch (const dn::Interrupted&) {
        return;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failed_ = true;
        if (!error_) error_ = std::current_exception();
        return;
      }
    }
  }

  std::size_t count_;
  Run* run_;
  const std::function<void(std::size_t)>& fly_;
  const std::function<void(std::size_t)>& landed_;
  const std::string& what_;
  std::mutex mutex_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> failed_{false};
  std::size_t done_ = 0;
  std::exception_ptr error_;
};

}  // namespace

void SimulateAll(std::size_t count, Run* run, const std::function<void(std::size_t)>& fly,
                 const std::function<void(std::size_t)>& on_finished, const std::string& what) {
  Fleet(count, run, fly, on_finished, what).Fly();
}

}  // namespace dn::apps
