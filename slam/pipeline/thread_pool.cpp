#include <deque>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/pipeline/executor.h"

namespace semmap {
namespace {

// Threads that work off one queue.
class Workers {
 public:
  explicit Workers(int threads) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
  }
  ~Workers() {
    {
      MutexLock lock(&mutex_);
      closing_ = true;
    }
    for (std::thread& thread : threads_) thread.join();
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  void Add(std::function<void()> task) {
    MutexLock lock(&mutex_);
    tasks_.push_back(std::move(task));
  }

 private:
  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return closing_ || !tasks_.empty(); }

  void Work() {
    while (true) {
      std::function<void()> task;
      {
        MutexLock lock(&mutex_);
        mutex_.Await(&Workers::HasWork, this);
        if (tasks_.empty()) return;
        task = std::move(tasks_.front());
        tasks_.pop_front();
      }
      task();
    }
  }

  Mutex mutex_;  // guards the queue
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

class ThreadPool : public Executor {
 public:
  explicit ThreadPool(int threads) : short_(threads), long_(1) {}

  void Schedule(std::function<void()> task) override { short_.Add(std::move(task)); }
  void ScheduleLong(std::function<void()> task) override { long_.Add(std::move(task)); }

 private:
  // Long tasks may schedule short ones to their last, therefore these workers outlive those.
  Workers short_;
  Workers long_;
};

}  // namespace

std::unique_ptr<Executor> MakeThreadPool(int threads) { return std::make_unique<ThreadPool>(threads); }

}  // namespace semmap
