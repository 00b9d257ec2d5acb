#include "lsmvs/texturing/charts/packing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lsmvs/image/page_packing.h"
#include "lsmvs/util/check.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

constexpr int kSideStep = 4;
// Rectangles are handed to a page until they would cover this part of it.
constexpr double kFullPage = 0.96;
constexpr double kGrowth = 1.002;

double Area(const Eigen::Vector2i& size) {
  return static_cast<double>(size.x()) * static_cast<double>(size.y());
}

int RoundUpToStep(double side, int max_side) {
  const int rounded = static_cast<int>(std::ceil(side / kSideStep)) * kSideStep;
  return std::min(rounded, max_side);
}

// Fills page after page.
class PageFiller {
 public:
  PageFiller(std::span<const Eigen::Vector2i> sizes, std::span<const uint32_t> order, int side)
      : sizes_(sizes), waiting_(order.begin(), order.end()), side_(side) {
    packing_.page_side = side;
    packing_.page_idx.resize(sizes.size());
    packing_.position.resize(sizes.size());
  }

  // False if that takes more than `max_pages`.
  bool Run(int max_pages) {
    while (!waiting_.empty()) {
      if (packing_.num_pages == max_pages) return false;
      FillPage(packing_.num_pages + 1 == max_pages);
      ++packing_.num_pages;
    }
    return true;
  }

  const Packing& packing() const { return packing_; }

 private:
  void FillPage(bool is_last) {
    const std::vector<uint32_t> chosen = Choose(is_last);
    std::vector<Eigen::Vector2i> sizes;
    for (const uint32_t i : chosen) sizes.push_back(sizes_[i]);
    const PagePacking page = PackPage(sizes, side_);
    std::vector<uint32_t> left;
    for (size_t k = 0; k < chosen.size(); ++k) {
      const uint32_t i = chosen[k];
      if (page.fits[k] == 0) {
        left.push_back(i);
        continue;
      }
      packing_.page_idx[i] = static_cast<uint16_t>(packing_.num_pages);
      packing_.position[i] = page.corners[k];
    }
    LSMVS_CHECK_LT(left.size(), chosen.size());
    left.insert(left.end(), waiting_.begin() + static_cast<std::ptrdiff_t>(chosen.size()),
                waiting_.end());
    waiting_.swap(left);
  }

  // The first of those that wait, as many as a page holds; all for the last page.
  std::vector<uint32_t> Choose(bool is_last) const {
    double area = 0;
    const double most = kFullPage * side_ * side_;
    size_t count = 0;
    while (count < waiting_.size()) {
      area += Area(sizes_[waiting_[count]]);
      if (area > most && count > 0 && !is_last) break;
      ++count;
    }
    return {waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count)};
  }

  std::span<const Eigen::Vector2i> sizes_;
  std::vector<uint32_t> waiting_;
  int side_;
  Packing packing_;
};

}  // namespace

Packing PackRectangles(std::span<const Eigen::Vector2i> sizes, std::span<const uint32_t> order,
                       int max_side) {
  if (sizes.empty()) return {};
  double area = 0;
  int longest = 1;
  for (const Eigen::Vector2i& size : sizes) {
    area += Area(size);
    longest = std::max(longest, size.maxCoeff());
  }
  LSMVS_CHECK_LE(longest, max_side);
  constexpr int kMaxPages = std::numeric_limits<uint16_t>::max();
  PageFiller full(sizes, order, max_side);
  if (!full.Run(kMaxPages)) {
    throw MemoryError("the texture would take more than 65,535 pages; give a larger texel_size");
  }
  const int num_pages = full.packing().num_pages;
  double side = std::max<double>(longest, std::sqrt(area / num_pages));
  for (; side < max_side; side *= kGrowth) {
    PageFiller smaller(sizes, order, RoundUpToStep(side, max_side));
    if (smaller.Run(num_pages)) return smaller.packing();
  }
  return full.packing();
}

}  // namespace lsmvs
