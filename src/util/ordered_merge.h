#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <utility>

namespace lsmvs {

// Hands over what parallel work makes in the order of its numbers 0, 1, 2, ..., whichever is
// finished first: sums of floating-point numbers then do not depend on the number of threads. What
// comes early waits.
template <class T>
class OrderedMerge {
 public:
  explicit OrderedMerge(std::function<void(size_t, T&&)> take) : take_(std::move(take)) {}

  // Thread-safe; every number once.
  void Add(size_t number, T&& value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.emplace(number, std::move(value));
    while (!waiting_.empty() && waiting_.begin()->first == next_) {
      take_(next_, std::move(waiting_.begin()->second));
      waiting_.erase(waiting_.begin());
      ++next_;
    }
  }

 private:
  std::function<void(size_t, T&&)> take_;
  std::mutex mutex_;
  std::map<size_t, T> waiting_;
  size_t next_ = 0;
};

}  // namespace lsmvs
