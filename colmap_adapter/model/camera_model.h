#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace lsmvs {

// One of COLMAP's camera models: its number in binary files, its name in text files, its number of
// parameters.
struct CameraModel {
  int id;
  std::string_view name;
  size_t num_params;
};

// All models that COLMAP 3.x and 4.x know, in ascending id.
std::span<const CameraModel> AllCameraModels();

// Null if COLMAP has no such model (or is newer than we are).
const CameraModel* FindCameraModel(int id);
const CameraModel* FindCameraModel(std::string_view name);

inline constexpr int kSimplePinholeModel = 0;  // f, cx, cy
inline constexpr int kPinholeModel = 1;        // fx, fy, cx, cy

}  // namespace lsmvs
