#include "lsmvs/execution/helpers/loop_items.h"

#include <algorithm>
#include <utility>

namespace lsmvs {

namespace {

// An item is late when it has taken so many times as long as the longest so far, and no less than
// this.
constexpr double kLateFactor = 2;
constexpr std::chrono::duration<double> kLeastPatience(0.1);

}  // namespace

LoopItems::LoopItems(size_t count, size_t num_helpers, size_t longest_row)
    : items_(count),
      row_length_(std::clamp<size_t>((count + num_helpers) / (1 + num_helpers), 1, longest_row)) {}

std::optional<size_t> LoopItems::TakeForHelper(int helper) {
  const std::lock_guard lock(mutex_);
  return IsOver() ? std::nullopt : Take(helper);
}

void LoopItems::GiveBack(int helper) {
  {
    const std::lock_guard lock(mutex_);
    for (size_t i = 0; i < items_.size(); ++i) {
      if (items_[i].owner == helper && !items_[i].is_done) given_back_.insert(i);
    }
    const Row row = rows_[helper];
    for (size_t i = row.begin; i < row.end; ++i) given_back_.insert(i);
    rows_.erase(helper);
  }
  changed_.notify_all();
}

bool LoopItems::Finish(size_t i, bool by_helper) {
  {
    const std::lock_guard lock(mutex_);
    Item& item = items_.at(i);
    if (item.is_done) return false;
    item.is_done = true;
    ++num_done_;
    num_by_helpers_ += by_helper;
    longest_ = std::max<std::chrono::duration<double>>(longest_, Clock::now() - item.since);
    given_back_.erase(i);
  }
  changed_.notify_all();
  return true;
}

void LoopItems::Stop(std::exception_ptr error) {
  {
    const std::lock_guard lock(mutex_);
    if (error_ == nullptr) error_ = std::move(error);
  }
  changed_.notify_all();
}

std::exception_ptr LoopItems::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

size_t LoopItems::num_by_helpers() const {
  const std::lock_guard lock(mutex_);
  return num_by_helpers_;
}

std::optional<size_t> LoopItems::Take(int owner) {
  const std::optional<size_t> i = FindItem(owner);
  if (!i) return std::nullopt;
  items_[*i].owner = owner;
  items_[*i].since = Clock::now();
  return i;
}

std::optional<size_t> LoopItems::FindItem(int owner) {
  if (!given_back_.empty()) return given_back_.extract(given_back_.begin()).value();
  Row& own = rows_[owner];
  if (own.size() == 0) own = NextRow();
  if (own.size() > 0) return own.begin++;
  // Nobody has begun the end of the longest row.
  const auto longest = std::max_element(
      rows_.begin(), rows_.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  if (longest->second.size() > 0) return --longest->second.end;
  return std::nullopt;
}

LoopItems::Row LoopItems::NextRow() {
  const size_t begin = next_;
  next_ = std::min(items_.size(), next_ + row_length_);
  return {begin, next_};
}

std::optional<size_t> LoopItems::NextHere() {
  if (const auto item = Take(kHere)) return item;
  const std::optional<size_t> late = FindLate();
  if (late) items_[*late].since = Clock::now();
  return late;
}

// Of a helper: the item that is under way for longest, if that is too long.
std::optional<size_t> LoopItems::FindLate() const {
  const auto limit = Clock::now() - std::chrono::duration_cast<Clock::duration>(
                                        std::max(kLeastPatience, kLateFactor * longest_));
  std::optional<size_t> late;
  for (size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    if (item.is_done || item.owner <= kHere || item.since > limit) continue;
    if (!late || item.since < items_[*late].since) late = i;
  }
  return late;
}

}  // namespace lsmvs
