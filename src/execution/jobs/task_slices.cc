#include "lsmvs/execution/jobs/task_slices.h"

#include <algorithm>
#include <string>
#include <unordered_map>

namespace lsmvs {

namespace {

constexpr size_t kMaxReaders = 64;
// Tasks of equal costs are to fill a slice in spite of rounding.
constexpr double kSlack = 1e-6;

class Slicer {
 public:
  Slicer(const std::vector<Task>& tasks, std::span<const size_t> task_idxs)
      : tasks_(tasks), task_idxs_(task_idxs), is_taken_(task_idxs.size(), false) {
    std::unordered_map<std::string, size_t> numbers;
    inputs_.resize(task_idxs.size());
    for (size_t t = 0; t < task_idxs.size(); ++t) {
      for (const auto& input : tasks[task_idxs[t]].inputs) {
        const size_t number = numbers.emplace(input.string(), numbers.size()).first->second;
        if (number == readers_.size()) readers_.emplace_back();
        readers_[number].push_back(t);
        inputs_[t].push_back(number);
      }
    }
  }

  std::vector<std::vector<size_t>> Slices(const SliceLengths& lengths, double seconds_left,
                                          size_t max_slices) {
    std::vector<std::vector<size_t>> slices;
    for (size_t first = 0; first < task_idxs_.size() && slices.size() < max_slices; ++first) {
      if (is_taken_[first]) continue;
      slices.push_back(Grow(first, lengths.Next(seconds_left)));
      for (const size_t i : slices.back()) seconds_left -= tasks_[i].cost.cpu_seconds;
    }
    return slices;
  }

 private:
  std::vector<size_t> Grow(size_t first, double seconds) {
    std::vector<size_t> slice;
    std::unordered_map<size_t, size_t> shared;  // inputs that a task has in common with the slice
    double slice_seconds = 0;
    for (size_t t = first; t < task_idxs_.size(); t = Best(shared, first)) {
      const double task_seconds = tasks_[task_idxs_[t]].cost.cpu_seconds;
      if (!slice.empty() && slice_seconds + task_seconds > (1 + kSlack) * seconds) break;
      is_taken_[t] = true;
      slice.push_back(task_idxs_[t]);
      slice_seconds += task_seconds;
      for (const size_t input : inputs_[t]) {
        if (readers_[input].size() > kMaxReaders) continue;
        for (const size_t reader : readers_[input]) {
          if (!is_taken_[reader]) ++shared[reader];
        }
      }
    }
    return slice;
  }

  // Ties go to the first; without any that shares inputs, the first that is left.
  size_t Best(const std::unordered_map<size_t, size_t>& shared, size_t first) const {
    size_t best = task_idxs_.size(), best_count = 0;
    for (const auto& [t, count] : shared) {
      if (is_taken_[t]) continue;
      if (count > best_count || (count == best_count && t < best)) {
        best = t;
        best_count = count;
      }
    }
    if (best_count > 0) return best;
    while (first < task_idxs_.size() && is_taken_[first]) ++first;
    return first;
  }

  const std::vector<Task>& tasks_;
  const std::span<const size_t> task_idxs_;
  std::vector<std::vector<size_t>> inputs_, readers_;
  std::vector<bool> is_taken_;
};

}  // namespace

double SliceLengths::Next(double seconds_left) const {
  const double share = seconds_left / (2.0 * static_cast<double>(jobs_at_once));
  return std::clamp(share, std::min(shortest, longest), longest);
}

std::vector<std::vector<size_t>> SliceTasks(const std::vector<Task>& tasks,
                                            std::span<const size_t> task_idxs,
                                            const SliceLengths& lengths, double seconds_left,
                                            size_t max_slices) {
  return Slicer(tasks, task_idxs).Slices(lengths, seconds_left, max_slices);
}

std::vector<std::vector<size_t>> RoundsOf(const std::vector<Task>& tasks,
                                          std::span<const size_t> task_idxs) {
  std::unordered_map<std::string, size_t> round_of;  // that makes a file
  std::vector<std::vector<size_t>> rounds;
  for (const size_t i : task_idxs) {
    size_t round = 0;
    for (const auto& input : tasks[i].inputs) {
      const auto made = round_of.find(input.string());
      if (made != round_of.end()) round = std::max(round, made->second + 1);
    }
    for (const auto& output : tasks[i].outputs) round_of[output.string()] = round;
    if (rounds.size() <= round) rounds.resize(round + 1);
    rounds[round].push_back(i);
  }
  return rounds;
}

}  // namespace lsmvs
