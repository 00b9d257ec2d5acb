#include "lsmvs/colmap_adapter/model/camera_model.h"

#include <algorithm>
#include <array>

namespace lsmvs {

namespace {

constexpr std::array<CameraModel, 18> kModels = {{{0, "SIMPLE_PINHOLE", 3},
                                                  {1, "PINHOLE", 4},
                                                  {2, "SIMPLE_RADIAL", 4},
                                                  {3, "RADIAL", 5},
                                                  {4, "OPENCV", 8},
                                                  {5, "OPENCV_FISHEYE", 8},
                                                  {6, "FULL_OPENCV", 12},
                                                  {7, "FOV", 5},
                                                  {8, "SIMPLE_RADIAL_FISHEYE", 4},
                                                  {9, "RADIAL_FISHEYE", 5},
                                                  {10, "THIN_PRISM_FISHEYE", 12},
                                                  {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16},
                                                  {12, "SIMPLE_DIVISION", 4},
                                                  {13, "DIVISION", 5},
                                                  {14, "SIMPLE_FISHEYE", 3},
                                                  {15, "FISHEYE", 4},
                                                  {16, "EUCM", 6},
                                                  {17, "EQUIRECTANGULAR", 2}}};

template <class Predicate>
const CameraModel* FindIf(const Predicate& predicate) {
  const auto found = std::find_if(kModels.begin(), kModels.end(), predicate);
  return found == kModels.end() ? nullptr : &*found;
}

}  // namespace

std::span<const CameraModel> AllCameraModels() { return kModels; }

const CameraModel* FindCameraModel(int id) {
  return FindIf([id](const CameraModel& model) { return model.id == id; });
}

const CameraModel* FindCameraModel(std::string_view name) {
  return FindIf([name](const CameraModel& model) { return model.name == name; });
}

}  // namespace lsmvs
