#include "lsmvs/scene/cloud_sample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lsmvs/util/statistics.h"

namespace lsmvs {

namespace {

constexpr size_t kNumFirst = 4000;  // points that tell the size of a pixel

uint64_t HashOf(const std::array<int32_t, 3>& cell) {
  uint64_t hash = 0;
  for (const int32_t k : cell) {
    hash = (hash ^ static_cast<uint32_t>(k)) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 32;
  }
  return hash * 0x9E3779B97F4A7C15ull;
}

// Of the finest view that is there; infinite without one.
double PixelSize(const Scene& scene, const Eigen::Vector3f& position,
                 std::span<const uint32_t> views) {
  double finest = std::numeric_limits<double>::infinity();
  for (const uint32_t view_idx : views) {
    if (view_idx >= scene.views.size()) continue;
    const View& view = scene.views[view_idx];
    const double depth = view.Depth(position.cast<double>());
    if (depth > 0) finest = std::min(finest, depth / view.camera.MeanFocalLength());
  }
  return finest;
}

}  // namespace

CloudSampler::CloudSampler(const Scene& scene, const Eigen::AlignedBox3d& box)
    : scene_(scene), box_(box) {
  SetCubeSize(GroundSamplingDistance(scene));
}

void CloudSampler::SetCubeSize(double pixel_size) {
  cube_size_ = static_cast<float>(kCubePixels * pixel_size);
  margin_ = static_cast<float>(kMarginPixels * pixel_size);
}

void CloudSampler::Add(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                       std::span<const uint32_t> views) {
  if (!position.allFinite()) return;
  if (!box_.isEmpty() && !box_.contains(position.cast<double>())) return;
  ++sample_.num_points;
  sample_.num_view_entries += views.size();
  if (cube_size_ > 0) {
    AddToPlaces(position, normal, views);
    return;
  }
  first_.Add(position, normal, Color::Zero(), views);
  if (first_.size() == kNumFirst) MeasureFirst();
}

void CloudSampler::MeasureFirst() {
  std::vector<double> sizes;
  for (size_t p = 0; p < first_.size(); ++p) {
    const double size = PixelSize(scene_, first_.positions[p], first_.ViewsOf(p));
    if (std::isfinite(size) && size > 0) sizes.push_back(size);
  }
  if (sizes.empty()) return;
  SetCubeSize(Median(&sizes));
  const VisibilityCloud first = std::exchange(first_, {});
  for (size_t p = 0; p < first.size(); ++p) {
    AddToPlaces(first.positions[p], first.normals[p], first.ViewsOf(p));
  }
}

// To its cube, and to those next to it that are within the margin.
void CloudSampler::AddToPlaces(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                               std::span<const uint32_t> views) {
  constexpr float kMaxCell = 1e9f;
  Cell low, high;
  for (int k = 0; k < 3; ++k) {
    const auto cell_of = [&](float x) {
      return static_cast<int32_t>(std::clamp(std::floor(x / cube_size_), -kMaxCell, kMaxCell));
    };
    low[k] = cell_of(position[k] - margin_);
    high[k] = cell_of(position[k] + margin_);
  }
  Cell cell;
  for (cell[0] = low[0]; cell[0] <= high[0]; ++cell[0]) {
    for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1]) {
      for (cell[2] = low[2]; cell[2] <= high[2]; ++cell[2]) {
        if (HashOf(cell) <= max_hash_) AddTo(cell, position, normal, views);
      }
    }
  }
}

void CloudSampler::AddTo(const Cell& cell, const Eigen::Vector3f& position,
                         const Eigen::Vector3f& normal, std::span<const uint32_t> views) {
  places_[cell].Add(position, normal, Color::Zero(), views);
  if (++num_in_places_ > kMaxPoints && places_.size() > 1) DropHalf();
}

void CloudSampler::DropHalf() {
  max_hash_ /= 2;
  std::erase_if(places_, [&](const auto& place) { return HashOf(place.first) > max_hash_; });
  num_in_places_ = 0;
  for (const auto& [cell, points] : places_) num_in_places_ += points.size();
}

CloudSample CloudSampler::Take() {
  if (first_.size() > 0) MeasureFirst();
  for (auto& [cell, points] : places_) {
    const Eigen::Vector3f low =
        cube_size_ * Eigen::Vector3i(cell[0], cell[1], cell[2]).cast<float>();
    sample_.places.push_back(
        {Eigen::AlignedBox3f(low, low + Eigen::Vector3f::Constant(cube_size_)), std::move(points)});
  }
  places_.clear();
  return std::move(sample_);
}

}  // namespace lsmvs
