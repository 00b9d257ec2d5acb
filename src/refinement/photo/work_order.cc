#include "lsmvs/refinement/photo/work_order.h"

#include <algorithm>
#include <cstdint>

namespace lsmvs {

std::vector<int> WorkOrder(const std::vector<ViewPair>& pairs, size_t num_views) {
  std::vector<std::vector<int>> neighbors(num_views);
  for (const ViewPair& pair : pairs) neighbors[static_cast<size_t>(pair.i)].push_back(pair.j);
  std::vector<uint8_t> drawn(num_views, 0);
  std::vector<int> waiting, order;
  for (size_t v = 0; v < num_views; ++v) {
    if (!neighbors[v].empty()) waiting.push_back(static_cast<int>(v));
  }
  const auto num_to_draw = [&](int v) {
    int count = !drawn[static_cast<size_t>(v)];
    for (const int j : neighbors[static_cast<size_t>(v)]) count += !drawn[static_cast<size_t>(j)];
    return count;
  };
  while (!waiting.empty()) {
    const auto next = std::min_element(waiting.begin(), waiting.end(), [&](int a, int b) {
      return num_to_draw(a) < num_to_draw(b);
    });
    order.push_back(*next);
    drawn[static_cast<size_t>(*next)] = 1;
    for (const int j : neighbors[static_cast<size_t>(*next)]) drawn[static_cast<size_t>(j)] = 1;
    waiting.erase(next);
  }
  return order;
}

}  // namespace lsmvs
