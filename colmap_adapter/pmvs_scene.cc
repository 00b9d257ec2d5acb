#include "lsmvs/colmap_adapter/pmvs_scene.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "lsmvs/colmap_adapter/files/text_reader.h"
#include "lsmvs/image/image_file.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

namespace {

using internal::TextReader;
using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

constexpr const char* kRemedy = "prepare the folder again by `colmap image_undistorter`";
// Of the focal length; matrices are written with six digits.
constexpr double kMaxSkew = 1e-4;

fs::path MatrixPath(const fs::path& folder, int photo) {
  return folder / "txt" / fmt::format("{:08d}.txt", photo);
}

ProjectionMatrix ReadProjectionMatrix(const fs::path& path) {
  TextReader reader(path, kRemedy);
  if (!reader.NextContentLine() || reader.Word() != "CONTOUR") {
    reader.Fail("does not begin with CONTOUR");
  }
  ProjectionMatrix matrix;
  for (int row = 0; row < 3; ++row) {
    if (!reader.NextContentLine()) reader.Fail("ends before the third row of the matrix");
    for (int column = 0; column < 4; ++column) matrix(row, column) = reader.Double();
    reader.ExpectEndOfLine();
  }
  if (!matrix.allFinite()) reader.Fail("has a number that is not finite");
  return matrix;
}

// Takes a projection matrix apart from its last row upwards: the viewing axis, then y, then x.
void Decompose(ProjectionMatrix matrix, const fs::path& path, View* view) {
  const double determinant = matrix.leftCols<3>().determinant();
  const double norm = matrix.row(2).head<3>().norm();
  if (!(std::abs(determinant) > 0) || !(norm > 0)) {
    throw InputError(path.string(), "is no matrix of a camera", kRemedy);
  }
  matrix *= (determinant > 0 ? 1 : -1) / norm;
  const Eigen::Vector3d m0 = matrix.row(0).head<3>(), m1 = matrix.row(1).head<3>();
  const Eigen::Vector3d z = matrix.row(2).head<3>();
  PinholeCamera& camera = view->camera;
  camera.cx = m0.dot(z);
  camera.cy = m1.dot(z);
  const Eigen::Vector3d scaled_y = m1 - camera.cy * z;
  camera.fy = scaled_y.norm();
  const Eigen::Vector3d y = scaled_y / camera.fy, x = y.cross(z);
  camera.fx = (m0 - camera.cx * z).dot(x);
  const double skew = m0.dot(y);
  if (!(camera.fx > 0) || std::abs(skew) > kMaxSkew * camera.fx) {
    throw InputError(path.string(), "is the matrix of a camera with skewed pixels", kRemedy);
  }
  view->cam_from_world.rotation << x.transpose(), y.transpose(), z.transpose();
  const double depth = matrix(2, 3);
  view->cam_from_world.translation = {
      (matrix(0, 3) - skew * (matrix(1, 3) - camera.cy * depth) / camera.fy - camera.cx * depth) /
          camera.fx,
      (matrix(1, 3) - camera.cy * depth) / camera.fy, depth};
}

View LoadView(const fs::path& folder, int photo) {
  View view;
  view.image_id = static_cast<ImageId>(photo);
  view.name = fmt::format("{:08d}.jpg", photo);
  const fs::path matrix_path = MatrixPath(folder, photo);
  Decompose(ReadProjectionMatrix(matrix_path), matrix_path, &view);
  const fs::path image_path = folder / "visualize" / view.name;
  const std::optional<ImageFileInfo> info = InspectImageFile(image_path.string());
  if (!info) throw InputError(image_path.string(), "is no JPEG file", kRemedy);
  view.camera.width = info->size.x();
  view.camera.height = info->size.y();
  return view;
}

// A point's line of sights: their number, then photo, key and position of each.
std::vector<int> ReadSights(TextReader* reader, int num_photos) {
  std::vector<int> view_idxs;
  for (uint64_t i = reader->Count(4); i > 0; --i) {
    view_idxs.push_back(static_cast<int>(reader->Unsigned(static_cast<uint64_t>(num_photos) - 1)));
    reader->Signed();
    for (int k = 0; k < 2; ++k) reader->Double();
  }
  std::sort(view_idxs.begin(), view_idxs.end());
  view_idxs.erase(std::unique(view_idxs.begin(), view_idxs.end()), view_idxs.end());
  return view_idxs;
}

void NextBundleLine(TextReader* reader) {
  if (!reader->NextContentLine()) reader->Fail("ends too early");
}

std::vector<SparsePoint> ReadBundlePoints(const fs::path& path, int num_photos) {
  TextReader reader(path, kRemedy);
  NextBundleLine(&reader);
  const int64_t num_cameras = reader.Signed();
  if (num_cameras != num_photos) {
    reader.Fail(
        fmt::format("tells of {} photos, but txt/ has {} matrices", num_cameras, num_photos));
  }
  const uint64_t num_points = reader.Unsigned(std::numeric_limits<uint32_t>::max());
  constexpr int kLinesPerCamera = 5;  // the matrices of txt/ say the same
  for (int i = 0; i < kLinesPerCamera * num_photos; ++i) NextBundleLine(&reader);
  std::vector<SparsePoint> points;
  for (uint64_t p = 0; p < num_points; ++p) {
    SparsePoint point;
    NextBundleLine(&reader);
    for (int k = 0; k < 3; ++k) point.x_in_world[k] = reader.Double();
    if (!point.x_in_world.allFinite()) reader.Fail("has a number that is not finite");
    NextBundleLine(&reader);
    for (int k = 0; k < 3; ++k) point.color[k] = static_cast<uint8_t>(reader.Unsigned(255));
    NextBundleLine(&reader);
    point.view_idxs = ReadSights(&reader, num_photos);
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

int CountPmvsPhotos(const fs::path& folder) {
  int count = 0;
  while (fs::exists(MatrixPath(folder, count))) ++count;
  int num_files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "txt")) {
    num_files += entry.path().extension() == ".txt";
  }
  if (count == 0 || num_files != count) {
    throw InputError(MatrixPath(folder, count).string(), "is missing", kRemedy);
  }
  return count;
}

Scene LoadPmvsScene(const fs::path& folder) {
  Scene scene;
  const int num_photos = CountPmvsPhotos(folder);
  for (int photo = 0; photo < num_photos; ++photo) scene.views.push_back(LoadView(folder, photo));
  const fs::path bundle = folder / "bundle.rd.out";
  if (fs::exists(bundle)) scene.points = ReadBundlePoints(bundle, num_photos);
  scene.image_folder = (folder / "visualize").string();
  return scene;
}

}  // namespace lsmvs
