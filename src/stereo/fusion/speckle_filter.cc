#include "lsmvs/stereo/fusion/speckle_filter.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lsmvs {

namespace {

// Pixels so far apart, with none between, still hang together.
constexpr int kReach = 2;

// Pixels that hang together with `seed`, which is marked as visited.
void Flood(const Raster<float>& depths, float max_step, const Raster<uint8_t>& support, size_t seed,
           std::vector<bool>* visited, std::vector<size_t>* component) {
  const int width = depths.width, height = depths.height;
  component->assign(1, seed);
  (*visited)[seed] = true;
  for (size_t next = 0; next < component->size(); ++next) {
    const size_t at = (*component)[next];
    const int column = static_cast<int>(at) % width, row = static_cast<int>(at) / width;
    const float depth = depths.pixels[at];
    for (int y = std::max(0, row - kReach); y <= std::min(height - 1, row + kReach); ++y) {
      for (int x = std::max(0, column - kReach); x <= std::min(width - 1, column + kReach); ++x) {
        const size_t to = depths.Index(x, y);
        if ((*visited)[to] || support.pixels[to] == kNoSupport) continue;
        if (!(std::abs(depths.pixels[to] - depth) <= max_step * depth)) continue;
        (*visited)[to] = true;
        component->push_back(to);
      }
    }
  }
}

}  // namespace

void FilterSpeckles(const Raster<float>& depths, double max_depth_step, int min_area,
                    Raster<uint8_t>* support) {
  std::vector<bool> visited(depths.size(), false);
  std::vector<size_t> component;
  for (size_t i = 0; i < depths.size(); ++i) {
    if (visited[i] || support->pixels[i] != kWeakSupport) continue;
    Flood(depths, static_cast<float>(max_depth_step), *support, i, &visited, &component);
    if (component.size() >= static_cast<size_t>(min_area)) continue;
    for (const size_t pixel : component) {
      if (support->pixels[pixel] == kWeakSupport) support->pixels[pixel] = kNoSupport;
    }
  }
}

}  // namespace lsmvs
