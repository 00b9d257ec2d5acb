#include "lsmvs/stereo/patch_match/textureless_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

namespace lsmvs {

namespace {

// A pixel without texture is kept if along a row, a column or a diagonal one of these holds:
//   - from the nearest textured pixel with a plane on either side to that on the other every pixel
//     has a plane, and their inverse depths go on without a jump;
//   - those two span a chord (a plane is straight in inverse depth) from which the pixel's inverse
//     depth deviates little;
//   - one such lies on one side, with a plane from which the pixel deviates little, and on the
//     other the image ends within reach.
// With each such pixel go those of its texture window that continue its depth: a window without
// texture has none in any of its pixels, though windows around those at its rim reach out to some.

// What lies behind a pixel along a line.
struct Anchor {
  const Plane* plane = nullptr;  // of the nearest pixel with texture and a plane, if there is one
  int distance = 0;              // steps to that pixel, or to the image's border
  bool linked = false;  // all pixels from there hither have planes, and these go on without a jump
  float last_q = 0;     // inverse depth of the last of them
};

bool Continues(const Anchor& anchor, float q, float max_step) {
  return anchor.linked && std::abs(q - anchor.last_q) <= max_step;
}

// What the next pixel of the line finds behind it.
Anchor Passed(const Anchor& anchor, const Plane& plane, bool textured, float max_step) {
  if (plane.q > 0 && textured) return {&plane, 1, true, plane.q};
  return {anchor.plane, anchor.distance + 1, plane.q > 0 && Continues(anchor, plane.q, max_step),
          plane.q};
}

// Walks the image such that (column - dx, row - dy) comes before (column, row), and tells `visit`
// the nearest anchor strictly before each pixel.
template <class Visit>
void ScanAnchors(const Raster<uint8_t>& textured, const PlaneMap& planes, int dx, int dy,
                 float max_step, const Visit& visit) {
  const int width = planes.width, height = planes.height;
  const bool rightward = dx > 0 || (dx == 0 && dy > 0), downward = dy >= 0;
  // Anchors seen from the row before and from the row at hand, by column.
  std::vector<Anchor> before(static_cast<size_t>(width)), here(static_cast<size_t>(width));
  for (int i = 0; i < height; ++i) {
    const int row = downward ? i : height - 1 - i;
    for (int j = 0; j < width; ++j) {
      const int column = rightward ? j : width - 1 - j;
      const int from = column - dx;
      Anchor anchor;
      if (from >= 0 && from < width) anchor = (dy == 0 ? here : before)[static_cast<size_t>(from)];
      const size_t pixel = planes.Index(column, row);
      visit(pixel, anchor);
      here[static_cast<size_t>(column)] =
          Passed(anchor, planes.pixels[pixel], textured.pixels[pixel] != 0, max_step);
    }
    std::swap(before, here);
  }
}

// Inverse depth of the anchor's plane at the pixel that it lies behind.
float Extended(const Anchor& anchor, int dx, int dy) {
  return anchor.plane
      ->Moved(static_cast<float>(dx * anchor.distance), static_cast<float>(dy * anchor.distance))
      .q;
}

// Inverse depth at a pixel by what lies before it (`a`) and after it (`b`) along (dx, dy).
std::optional<float> Expected(const Anchor& a, const Anchor& b, int dx, int dy, int border_reach) {
  if (a.plane != nullptr && b.plane != nullptr) {
    const float along =
        static_cast<float>(a.distance) / static_cast<float>(a.distance + b.distance);
    return a.plane->q + along * (b.plane->q - a.plane->q);
  }
  if (a.plane != nullptr && b.distance < border_reach) return Extended(a, dx, dy);
  if (b.plane != nullptr && a.distance < border_reach) return Extended(b, -dx, -dy);
  return std::nullopt;
}

// Whether a pixel of inverse depth `q` is part of what lies on both sides of it.
bool Interpolates(float q, const Anchor& a, const Anchor& b, int dx, int dy,
                  const TexturelessFilterOptions& settings) {
  if (Continues(a, q, settings.max_step) && Continues(b, q, settings.max_step)) return true;
  const auto expected = Expected(a, b, dx, dy, settings.border_reach);
  return expected && std::abs(q - *expected) <= settings.max_deviation;
}

// A pixel whose plane was reset, and the inverse depth that it had.
struct Dropped {
  int column, row;
  float q;
};

// Resets what continues the depth of dropped pixels within their texture windows.
size_t DropWindowsAround(const std::vector<Dropped>& dropped,
                         const TexturelessFilterOptions& settings, PlaneMap* planes) {
  const int radius = settings.texture_radius;
  size_t num_dropped = 0;
  for (const Dropped& from : dropped) {
    const int top = std::max(0, from.row - radius),
              bottom = std::min(planes->height - 1, from.row + radius),
              left = std::max(0, from.column - radius),
              right = std::min(planes->width - 1, from.column + radius);
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) {
        Plane& plane = (*planes)(column, row);
        const int steps = std::max(std::abs(column - from.column), std::abs(row - from.row));
        if (!(plane.q > 0) ||
            std::abs(plane.q - from.q) > settings.max_step * static_cast<float>(steps)) {
          continue;
        }
        plane = {};
        ++num_dropped;
      }
    }
  }
  return num_dropped;
}

}  // namespace

Raster<uint8_t> TexturedPixels(const GrayImage& gray, int radius, float min_variance) {
  const cv::Mat image(gray.height, gray.width, CV_32F, const_cast<float*>(gray.pixels.data()));
  const cv::Size window(2 * radius + 1, 2 * radius + 1);
  cv::Mat mean, mean_square;
  cv::boxFilter(image, mean, CV_64F, window);
  cv::sqrBoxFilter(image, mean_square, CV_64F, window);
  Raster<uint8_t> textured(gray.width, gray.height, 0);
  for (int row = 0; row < gray.height; ++row) {
    for (int column = 0; column < gray.width; ++column) {
      const double m = mean.at<double>(row, column);
      textured(column, row) = mean_square.at<double>(row, column) - m * m > min_variance;
    }
  }
  return textured;
}

size_t FilterTexturelessPixels(const Raster<uint8_t>& textured,
                               const TexturelessFilterOptions& settings, PlaneMap* planes) {
  constexpr std::array<std::array<int, 2>, 4> kLines = {{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  std::vector<bool> between(planes->size(), false);
  std::vector<Anchor> one_side(planes->size());
  for (const std::array<int, 2>& line : kLines) {
    const int dx = line[0], dy = line[1];
    ScanAnchors(textured, *planes, dx, dy, settings.max_step,
                [&](size_t pixel, const Anchor& anchor) { one_side[pixel] = anchor; });
    ScanAnchors(textured, *planes, -dx, -dy, settings.max_step, [&](size_t pixel, const Anchor& b) {
      const float q = planes->pixels[pixel].q;
      if (Interpolates(q, one_side[pixel], b, dx, dy, settings)) between[pixel] = true;
    });
  }
  std::vector<Dropped> dropped;
  for (int row = 0; row < planes->height; ++row) {
    for (int column = 0; column < planes->width; ++column) {
      const size_t pixel = planes->Index(column, row);
      Plane& plane = planes->pixels[pixel];
      if (!(plane.q > 0) || textured.pixels[pixel] != 0 || between[pixel]) continue;
      dropped.push_back({column, row, plane.q});
      plane = {};
    }
  }
  return dropped.size() + DropWindowsAround(dropped, settings, planes);
}

}  // namespace lsmvs
