#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lsmvs/colmap_adapter/sparse_model.h"

namespace lsmvs {

// COLMAP's database.db, read-only: nothing is ever written, not even a journal. Understands the
// schemas of COLMAP 3.x and 4.x, and skips tables and columns it does not know. Throws InputError
// if the file is missing, is not a database, lacks a table or holds blobs whose size does not fit
// their declared rows and columns.
class ColmapDatabase {
 public:
  struct Image {
    ImageId image_id{};
    std::string name;
    CameraId camera_id{};
  };
  // Image coordinates as COLMAP's (centre of the top-left pixel: 0.5, 0.5). The affine shape maps
  // the unit circle to the feature's ellipse; a scale and an orientation are converted to it;
  // identity if the file has positions only.
  struct Keypoint {
    Eigen::Vector2f x = Eigen::Vector2f::Zero();
    Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();
  };
  // Verified matches of two images: positions in their keypoints. `config` is COLMAP's
  // TwoViewGeometry configuration (2 calibrated, 3 uncalibrated, 4 planar, ...).
  struct TwoViewGeometry {
    ImageId image_id1{}, image_id2{};
    int config = 0;
    std::vector<std::pair<uint32_t, uint32_t>> inlier_matches;
  };

  explicit ColmapDatabase(const std::filesystem::path& path);
  ~ColmapDatabase();
  ColmapDatabase(const ColmapDatabase&) = delete;
  ColmapDatabase& operator=(const ColmapDatabase&) = delete;

  // In ascending image_id.
  std::vector<Image> ReadImages() const;
  // Empty if the image has none.
  std::vector<Keypoint> ReadKeypoints(ImageId image_id) const;
  // Those with at least one match, in ascending (image_id1, image_id2); image_id1 < image_id2.
  std::vector<TwoViewGeometry> ReadTwoViewGeometries() const;

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace lsmvs
