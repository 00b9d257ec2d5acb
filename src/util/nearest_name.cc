#include "lsmvs/util/nearest_name.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace lsmvs {

namespace {

char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

std::string WithoutGroup(const std::string& name) {
  const size_t dot = name.find('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

// Smaller is nearer; the name without its group counts as a little farther.
int Distance(const std::string& name, const std::string& candidate) {
  const int whole = EditDistance(name, candidate);
  const int bare = EditDistance(WithoutGroup(name), WithoutGroup(candidate)) + 1;
  return std::min(whole, bare);
}

// Of `length` characters at most a third may be edited.
template <class DistanceTo>
std::string Nearest(size_t length, const std::vector<std::string>& candidates,
                    const DistanceTo& distance_to) {
  std::string nearest;
  int nearest_distance = std::max(1, static_cast<int>(length) / 3 + 1) + 1;
  for (const std::string& candidate : candidates) {
    const int distance = distance_to(candidate);
    if (distance < nearest_distance) {
      nearest = candidate;
      nearest_distance = distance;
    }
  }
  return nearest;
}

}  // namespace

int EditDistance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (Lower(a[i - 1]) == Lower(b[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string NearestName(const std::string& name, const std::vector<std::string>& candidates) {
  return Nearest(name.size(), candidates,
                 [&](const std::string& candidate) { return EditDistance(name, candidate); });
}

std::string NearestOption(const std::string& name, const std::vector<std::string>& candidates) {
  return Nearest(WithoutGroup(name).size(), candidates,
                 [&](const std::string& candidate) { return Distance(name, candidate); });
}

}  // namespace lsmvs
