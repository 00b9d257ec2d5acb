#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace lsmvs {

// One bit per pixel.
class PixelSet {
 public:
  PixelSet() = default;
  explicit PixelSet(size_t num_pixels) : words_((num_pixels + 63) / 64, 0) {}
  bool empty() const { return words_.empty(); }
  bool Has(size_t i) const { return words_[i / 64] >> (i % 64) & 1; }
  void Insert(size_t i) { words_[i / 64] |= uint64_t{1} << (i % 64); }

 private:
  std::vector<uint64_t> words_;
};

// What one neighbour says about the depths of one row of the reference: few of its pixels where
// neighbours are many.
struct RowEstimates {
  PixelSet columns;           // that it has an estimate for; empty: none
  std::vector<float> depths;  // on the reference's ray, by ascending column
};

// What the neighbours say about the pixels of one reference view.
struct Evidence {
  Evidence(size_t num_pixels, size_t num_neighbors, int num_rows)
      : estimates(num_neighbors, std::vector<RowEstimates>(static_cast<size_t>(num_rows))),
        normal_sums(num_pixels, Eigen::Vector3f::Zero()),
        color_sums(num_pixels, Eigen::Vector3f::Zero()),
        num_agree(num_pixels, 0),
        num_close(num_pixels, 0),
        num_see_through(num_pixels, 0),
        is_covered(num_pixels, 0) {}
  // Counts the places of the neighbours that agree: views from one place see the same and do not
  // confirm each other. Those of one place come one after the other.
  void Count(size_t pixel, int place, bool is_close) {
    num_agree[pixel] += IsNew(pixel, place, &last_place);
    if (is_close) num_close[pixel] += IsNew(pixel, place, &last_close_place);
  }
  std::vector<std::vector<RowEstimates>> estimates;  // by neighbour and row
  std::vector<Eigen::Vector3f> normal_sums;          // world
  std::vector<Eigen::Vector3f> color_sums;
  std::vector<uint16_t> num_agree;        // places of neighbours with an estimate
  std::vector<uint16_t> num_close;        // ... that lies within weak_max_reproj_error
  std::vector<uint16_t> num_see_through;  // neighbours whose map lies behind the pixel's point
  std::vector<uint8_t> is_covered;  // a lower view has a point there; the rest is not complete
  // Places counted last; empty where all neighbours are from different ones.
  std::vector<int32_t> last_place, last_close_place;

 private:
  static bool IsNew(size_t pixel, int place, std::vector<int32_t>* last) {
    return last->empty() || std::exchange((*last)[pixel], place) != place;
  }
};

}  // namespace lsmvs
