#include "lsmvs/image/hole_filling.h"

#include <vector>

namespace lsmvs {

namespace {

using MeanImage = Raster<Eigen::Vector4f>;  // mean of the known pixels; 1, or 0 if there is none

MeanImage Halved(const MeanImage& fine) {
  MeanImage coarse((fine.width + 1) / 2, (fine.height + 1) / 2, Eigen::Vector4f::Zero());
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      if (fine(x, y)[3] > 0) coarse(x / 2, y / 2) += fine(x, y);
    }
  }
  for (Eigen::Vector4f& mean : coarse.pixels) {
    if (mean[3] > 0) mean /= mean[3];
  }
  return coarse;
}

void Fill(const MeanImage& coarse, MeanImage* fine) {
  for (int y = 0; y < fine->height; ++y) {
    for (int x = 0; x < fine->width; ++x) {
      if ((*fine)(x, y)[3] == 0) (*fine)(x, y) = coarse(x / 2, y / 2);
    }
  }
}

MeanImage KnownPixels(const ByteImage& known, const ColorImage& image) {
  MeanImage means(image.width, image.height, Eigen::Vector4f::Zero());
  for (size_t i = 0; i < image.size(); ++i) {
    if (known.pixels[i] == 0) continue;
    means.pixels[i].head<3>() = image.pixels[i].cast<float>();
    means.pixels[i][3] = 1;
  }
  return means;
}

}  // namespace

void FillHoles(const ByteImage& known, ColorImage* image) {
  if (image->empty()) return;
  std::vector<MeanImage> levels = {KnownPixels(known, *image)};
  while (levels.back().size() > 1) levels.push_back(Halved(levels.back()));
  for (size_t level = levels.size() - 1; level > 0; --level) {
    Fill(levels[level], &levels[level - 1]);
  }
  for (size_t i = 0; i < image->size(); ++i) {
    if (known.pixels[i] != 0) continue;
    image->pixels[i] = (levels[0].pixels[i].head<3>().array() + 0.5f).matrix().cast<uint8_t>();
  }
}

}  // namespace lsmvs
