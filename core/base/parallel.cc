#include "core/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "core/base/stop_check.h"

namespace kinegraph {
namespace {

thread_local int allowed_threads = 1;

// Sets allowed_threads for its lifetime.
class Allowance {
 public:
  explicit Allowance(int threads) : before_(allowed_threads) {
    allowed_threads = threads;
  }
  ~Allowance() { allowed_threads = before_; }
  Allowance(const Allowance&) = delete;
  Allowance& operator=(const Allowance&) = delete;

 private:
  int before_;
};

// The work of one call of ParallelFor.
struct Batch {
  Batch(int call_threads, int piece_count,
        const std::function<void(int)>& piece_work)
      : threads(call_threads),
        count(piece_count),
        work(piece_work),
        stop_check(CurrentStopCheck()),
        errors(piece_count) {}

  // Takes pieces until none is left.
  void Run() {
    const Allowance allowance(threads);
    const StopScope scope(stop_check);
    for (int i = next++; i < count; i = next++) {
      try {
        CheckStop();
        work(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    }
  }

  const int threads;
  const int count;
  const std::function<void(int)>& work;
  const StopCheck* const stop_check;  // of the calling thread
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> errors;  // one per piece
  std::exception_ptr stop;                 // raised while waiting
  int helpers = 0;  // pool threads working on it; guarded by the pool
};

// Threads that live as long as the program, because starting them for each call
// would cost more than a call of a few hundred microseconds. A piece may itself
// call ParallelFor: every caller works on its own pieces and waits only for
// pieces already begun by others, so nested calls cannot deadlock.
class ThreadPool {
 public:
  ~ThreadPool() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ending_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  void Run(int helpers, Batch* batch) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      Grow(helpers);
      waiting_.insert(waiting_.end(), helpers, batch);
    }
    wake_.notify_all();
    batch->Run();
    std::unique_lock<std::mutex> lock(mutex_);
    waiting_.erase(std::remove(waiting_.begin(), waiting_.end(), batch),
                   waiting_.end());
    const auto is_done = [&] { return batch->helpers == 0; };
    if (batch->stop_check == nullptr) return done_.wait(lock, is_done);
    // The check may detect a stop on this thread only (Python's signal
    // handlers) and then stops the helpers, so it also runs while this thread
    // waits.
    constexpr auto kPatience = std::chrono::milliseconds(50);
    while (!done_.wait_for(lock, kPatience, is_done)) {
      lock.unlock();  // the check may acquire locks
      try {
        CheckStop();
      } catch (...) {
        batch->stop = std::current_exception();
      }
      lock.lock();
    }
  }

 private:
  void Grow(int count) {
    try {
      while (static_cast<int>(threads_.size()) < count) {
        threads_.emplace_back([this] { Help(); });
      }
    } catch (const std::system_error&) {
      // No more threads available: the existing ones do the work.
    }
  }

  void Help() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
      if (ending_) return;
      Batch* const batch = waiting_.front();
      waiting_.pop_front();
      ++batch->helpers;
      lock.unlock();
      batch->Run();
      lock.lock();
      --batch->helpers;
      done_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  // A batch is listed once for each helper it may get.
  std::deque<Batch*> waiting_;
  std::vector<std::thread> threads_;
  bool ending_ = false;
};

}  // namespace

void ParallelFor(int threads, int count, const std::function<void(int)>& work) {
  if (threads <= 1 || count <= 1) {
    const Allowance allowance(std::max(1, threads));
    for (int i = 0; i < count; ++i) {
      CheckStop();
      work(i);
    }
    return;
  }
  static ThreadPool pool;
  Batch batch(threads, count, work);
  pool.Run(std::min(threads, count) - 1, &batch);
  if (batch.stop) std::rethrow_exception(batch.stop);
  for (const std::exception_ptr& error : batch.errors) {
    if (error) std::rethrow_exception(error);
  }
}

int AllowedThreads() { return allowed_threads; }

}  // namespace kinegraph
