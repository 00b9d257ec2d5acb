#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

namespace lsmvs {

// Who computes which item of a loop: threads of this process, and helpers, each known by a number
// from 1. Everybody puts a row of items aside, as items that follow each other have much in common;
// who has none left takes from the ends of the others' rows. What a helper does not finish is
// computed here. Thread-safe.
class LoopItems {
 public:
  // `num_helpers`: that take part, about.
  LoopItems(size_t count, size_t num_helpers, size_t longest_row);

  // The next item for a helper; nothing if all are taken.
  std::optional<size_t> TakeForHelper(int helper);
  // The helper is lost.
  void GiveBack(int helper);
  // The next item for a thread here. Waits where all are taken, until somebody has taken
  // suspiciously long for one; that one is handed out again. Nothing if all are finished, or the
  // loop was stopped. `poll` is called every while and may throw.
  template <class Poll>
  std::optional<size_t> TakeHere(const Poll& poll) {
    while (true) {
      poll();
      std::unique_lock lock(mutex_);
      if (IsOver()) return std::nullopt;
      if (const auto item = NextHere()) return item;
      changed_.wait_for(lock, kPollInterval);
    }
  }
  // False if somebody else has finished it before.
  bool Finish(size_t item, bool by_helper);
  // Ends the loop at once; the first error is kept.
  void Stop(std::exception_ptr error);
  std::exception_ptr error() const;
  // Items that helpers have finished.
  size_t num_by_helpers() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPollInterval{20};
  // Of this process; helpers follow.
  static constexpr int kHere = 0;

  struct Row {
    size_t begin = 0, end = 0;
    size_t size() const { return end - begin; }
  };
  struct Item {
    int owner = -1;  // -1: free
    bool is_done = false;
    Clock::time_point since;
  };

  bool IsOver() const { return error_ != nullptr || num_done_ == items_.size(); }
  std::optional<size_t> Take(int owner);
  std::optional<size_t> FindItem(int owner);
  std::optional<size_t> NextHere();
  std::optional<size_t> FindLate() const;
  Row NextRow();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Item> items_;
  const size_t row_length_;
  std::map<int, Row> rows_;  // what each has put aside for itself
  std::set<size_t> given_back_;
  size_t next_ = 0;  // the first item that nobody has put aside
  size_t num_done_ = 0, num_by_helpers_ = 0;
  std::chrono::duration<double> longest_{0};  // from when an item was taken until it was finished
  std::exception_ptr error_;
};

}  // namespace lsmvs
