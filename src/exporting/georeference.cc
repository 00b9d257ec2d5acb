#include "lsmvs/exporting/georeference.h"

#include <cmath>
#include <numbers>

namespace lsmvs {

namespace {

// The ellipsoid of WGS 84.
constexpr double kSemiMajorAxis = 6378137, kFlattening = 1 / 298.257223563;

}  // namespace

Eigen::Vector3d EcefFromGeodetic(const GeodeticPosition& position) {
  const double latitude = position.latitude_deg * std::numbers::pi / 180,
               longitude = position.longitude_deg * std::numbers::pi / 180;
  const double e2 = kFlattening * (2 - kFlattening);
  const double radius =
      kSemiMajorAxis / std::sqrt(1 - e2 * std::sin(latitude) * std::sin(latitude));
  const double from_axis = (radius + position.height) * std::cos(latitude);
  return {from_axis * std::cos(longitude), from_axis * std::sin(longitude),
          (radius * (1 - e2) + position.height) * std::sin(latitude)};
}

Eigen::Matrix4d EcefFromEnu(const GeodeticPosition& origin) {
  const double latitude = origin.latitude_deg * std::numbers::pi / 180,
               longitude = origin.longitude_deg * std::numbers::pi / 180;
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude),
               sin_lon = std::sin(longitude), cos_lon = std::cos(longitude);
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
  transform.block<3, 1>(0, 0) = Eigen::Vector3d(-sin_lon, cos_lon, 0);
  transform.block<3, 1>(0, 1) = Eigen::Vector3d(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
  transform.block<3, 1>(0, 2) = Eigen::Vector3d(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
  transform.block<3, 1>(0, 3) = EcefFromGeodetic(origin);
  return transform;
}

}  // namespace lsmvs
