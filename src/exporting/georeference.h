#pragma once

#include <Eigen/Core>

namespace lsmvs {

// A place on the Earth (WGS 84).
struct GeodeticPosition {
  double latitude_deg = 0, longitude_deg = 0;  // north and east are positive
  double height = 0;                           // over the ellipsoid [m]
};

// Earth-centred, earth-fixed coordinates [m].
Eigen::Vector3d EcefFromGeodetic(const GeodeticPosition& position);

// The transform from east, north, up [m] at a place to earth-centred coordinates, 4 x 4.
Eigen::Matrix4d EcefFromEnu(const GeodeticPosition& origin);

}  // namespace lsmvs
