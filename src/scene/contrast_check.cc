#include "lsmvs/scene/contrast_check.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <vector>

#include "lsmvs/image/largest_image.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

// Grey levels of 256 between the quantiles below which nothing can be matched.
constexpr float kMinRange = 6;
constexpr double kQuantile = 0.01;
constexpr size_t kMaxSamples = 100'000;
constexpr size_t kNamesListed = 5;
// Of more photos, so many are looked at, spread over all: each has to be read and decoded.
constexpr size_t kMaxPhotos = 64;

struct GrayRange {
  float low = 0, high = 255;
  bool HasContrast() const { return high - low >= kMinRange; }
};

// Full where all is masked: that is meant so.
GrayRange RangeOf(const ImageStore& images, int view_idx) {
  const auto gray = images.Gray(view_idx, 0);
  const auto mask = images.Mask(view_idx, 0);
  std::vector<float> values;
  const size_t stride = gray->size() / kMaxSamples + 1;
  for (size_t i = 0; i < gray->size(); i += stride) {
    if (mask == nullptr || mask->pixels[i] != 0) values.push_back(gray->pixels[i]);
  }
  if (values.empty()) return {};
  const float low = Quantile(&values, kQuantile);
  return {low, Quantile(&values, 1 - kQuantile)};
}

}  // namespace

void CheckContrast(const Scene& scene, const ImageStore& images, const RunContext& context) {
  std::vector<GrayRange> ranges(std::min(kMaxPhotos, scene.views.size()));
  const auto view_of = [&](size_t i) { return i * scene.views.size() / ranges.size(); };
  ParallelFor(context, ranges.size(), 1, [&](size_t i) {
    ranges[i] = RangeOf(images, static_cast<int>(view_of(i)));
    TrimToViewsHeld(images);
  });
  std::string names;
  size_t num_flat = 0;
  for (size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].HasContrast() || ++num_flat > kNamesListed) continue;
    names += fmt::format("{}{} ({:.0f} to {:.0f} of 255)", names.empty() ? "" : ", ",
                         scene.views[view_of(i)].name, ranges[i].low, ranges[i].high);
  }
  if (num_flat == 0) return;
  const std::string what =
      fmt::format("{} of {} photos have no contrast: {}{}", num_flat, ranges.size(), names,
                  num_flat > kNamesListed ? ", ..." : "");
  if (num_flat == ranges.size()) {
    throw InputError(scene.image_folder, what, "export the photos again with their full range");
  }
  LOG(WARNING) << scene.image_folder << ": " << what << "; they will hardly give depth";
}

}  // namespace lsmvs
