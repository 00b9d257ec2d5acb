#include "lsmvs/synthetic/synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/mesh_shape.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/sampled_cloud.h"
#include "lsmvs/synthetic/town.h"
#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
// Cameras are moved by this share of their distance.
constexpr double kJitter = 0.015;

// What the cameras look at: a ball of `radius` around `middle`.
struct Interest {
  Eigen::Vector3d middle;
  double radius;
  CameraLayout layout;
};

Interest InterestOf(ShapeName name) {
  switch (name) {
    case ShapeName::kSphere:
      return {{0, 0, 0}, 1.0, CameraLayout::kRing};
    case ShapeName::kBox:
      return {{0, 0, 0}, 1.25, CameraLayout::kRing};
    case ShapeName::kTorus:
      return {{0, 0, 0}, 1.3, CameraLayout::kRing};
    case ShapeName::kStep:
      return {{0, 0, 0.1}, 1.1, CameraLayout::kGrid};
    case ShapeName::kThinWalls:
    case ShapeName::kPole:
      return {{0, 0, 0.4}, 1.0, CameraLayout::kRing};
    case ShapeName::kSphereOnGround:
      return {{0, 0, 0.5}, 1.0, CameraLayout::kRing};
    case ShapeName::kTerrain:
      return {{0, 0, 0.1}, 1.5, CameraLayout::kGrid};
    case ShapeName::kRelief:
      return {{0, -0.1, 1.1}, 1.5, CameraLayout::kArc};
    case ShapeName::kTown:
      return {{60, 60, 5}, 80, CameraLayout::kGrid};
  }
  LSMVS_CHECK(false);
  return {};
}

// Distance from which the ball just fits the shorter side of the image.
double FittingDistance(const SyntheticSceneOptions& options, double radius) {
  const double half_short_side =
      0.5 * std::min(options.width, options.height) / std::max(options.width, options.height);
  return radius / std::sin(std::atan(half_short_side / options.focal_factor));
}

struct Stand {
  Eigen::Vector3d center, target;
};

void AddRing(const Interest& interest, double distance, double elevation_deg, int count,
             double begin_deg, double sweep_deg, std::vector<Stand>* stands) {
  const double angle = elevation_deg * kRadiansPerDegree;
  for (const Eigen::Vector3d& center :
       RingCenters(interest.middle, distance * std::cos(angle), distance * std::sin(angle), count,
                   begin_deg, sweep_deg)) {
    stands->push_back({center, interest.middle});
  }
}

// A few cameras stand side by side, so that neighbours see the same things.
double RingSweep(int count) { return count >= 6 ? 360.0 : 30.0 * std::max(1, count - 1); }

// Strips from which neighbours overlap by about two thirds; every second row looks 15 degrees
// aside.
void AddGrid(const Interest& interest, double distance, int count, std::vector<Stand>* stands) {
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(count * 4.0 / 3.0))));
  const int rows = (count + columns - 1) / columns;
  const double half = 0.55 * interest.radius, height = 0.75 * distance;
  for (const Eigen::Vector3d& offset : GridCenters(half, half, height, columns, rows)) {
    const int row = static_cast<int>(stands->size()) / columns;
    const Eigen::Vector3d ground(offset.x(), offset.y(), 0.0);
    const double aside = row % 2 == 0 ? 0.0 : height * std::tan(15.0 * kRadiansPerDegree);
    const Eigen::Vector3d sideways(0.0, offset.y() > 0 ? aside : -aside, 0.0);
    if (static_cast<int>(stands->size()) == count) break;
    stands->push_back({interest.middle + offset + sideways, interest.middle + ground});
  }
}

// So that no scene is accidentally symmetric.
void Jitter(uint64_t seed, double distance, std::vector<Stand>* stands) {
  for (size_t i = 0; i < stands->size(); ++i) {
    (*stands)[i].center += distance * Random(seed, i).Gaussian3();
  }
}

std::vector<Stand> MakeStands(const SyntheticSceneOptions& options, const Interest& interest) {
  const double distance = FittingDistance(options, interest.radius);
  const CameraLayout layout =
      options.layout == CameraLayout::kAuto ? interest.layout : options.layout;
  const int num_upper = options.num_views / 3, num_lower = options.num_views - num_upper;
  std::vector<Stand> stands;
  if (layout == CameraLayout::kRing) {
    AddRing(interest, distance, 20.0, num_lower, 5.0, RingSweep(num_lower), &stands);
    AddRing(interest, distance, 50.0, num_upper, 25.0, RingSweep(num_upper), &stands);
  } else if (layout == CameraLayout::kArc) {
    const double sweep = std::min(90.0, RingSweep(num_lower));
    AddRing(interest, 0.8 * distance, 3.0, num_lower, 270.0 - 0.5 * sweep, sweep, &stands);
    AddRing(interest, 0.85 * distance, 22.0, num_upper, 270.0 - 0.4 * sweep, 0.8 * sweep, &stands);
  } else {
    AddGrid(interest, distance, options.num_views, &stands);
  }
  Jitter(options.seed, kJitter * distance, &stands);
  return stands;
}

// Strips above a town, and how far they reach.
struct Flight {
  std::vector<Stand> stands;
  double length_x = 0, length_y = 0;
};

Flight FlyOver(const SyntheticSceneOptions& options, double gsd) {
  const double step_x = gsd * options.width / 4, step_y = gsd * options.height / 3;
  const int columns =
      std::max(1, static_cast<int>(std::lround(std::sqrt(options.num_views * step_y / step_x))));
  const double height = gsd * options.focal_factor * std::max(options.width, options.height);
  const double aside = height * std::tan(25.0 * kRadiansPerDegree);
  const int rows = (options.num_views + columns - 1) / columns;
  Flight flight{{}, step_x * columns, step_y * rows};
  for (int k = 0; k < options.num_views; ++k) {
    const int row = k / columns, column = row % 2 == 0 ? k % columns : columns - 1 - k % columns;
    const Eigen::Vector3d center(step_x * (column + 0.5), step_y * (row + 0.5), height);
    Eigen::Vector3d target(center.x(), center.y(), 0);
    if (k % 2 == 1) {
      const int axis = (k / 2) % 2;
      const double length = axis == 0 ? flight.length_x : flight.length_y;
      // Towards the middle, and back where there is room.
      const bool up = (k / 4) % 2 == 0 ? center[axis] + aside < length : center[axis] < aside;
      target[axis] += up ? aside : -aside;
    }
    flight.stands.push_back({center, target});
  }
  Jitter(options.seed, kJitter * height, &flight.stands);
  return flight;
}

// Adds the sparse points and finds the gsd: the median over exact points, of which there are enough
// even if none are asked for.
void AddSparsePoints(const SyntheticSceneOptions& options, const RunContext& context,
                     SyntheticScene* result) {
  constexpr size_t kMinPointsForGsd = 1000;
  const auto num_points = static_cast<size_t>(options.num_sparse_points);
  Scene& scene = result->scene;
  scene.points = SampleSparsePoints(*result->shape, scene, std::max(num_points, kMinPointsForGsd),
                                    0.0, options.seed + 1, context);
  result->gsd = GroundSamplingDistance(scene);
  scene.points.resize(num_points);
  for (size_t p = 0; p < num_points; ++p) {
    Random random(options.seed + 4, p);
    scene.points[p].x_in_world += options.sparse_noise_px * result->gsd * random.Gaussian3();
  }
}

}  // namespace

void SyntheticSceneOptions::Describe(OptionSet* options) {
  options->AddEnum("shape", &shape, "what is photographed",
                   {{"sphere", ShapeName::kSphere},
                    {"box", ShapeName::kBox},
                    {"torus", ShapeName::kTorus},
                    {"step", ShapeName::kStep},
                    {"thin_walls", ShapeName::kThinWalls},
                    {"pole", ShapeName::kPole},
                    {"sphere_on_ground", ShapeName::kSphereOnGround},
                    {"terrain", ShapeName::kTerrain},
                    {"relief", ShapeName::kRelief},
                    {"town", ShapeName::kTown}});
  options->AddEnum("layout", &layout, "where the cameras stand",
                   {{"auto", CameraLayout::kAuto},
                    {"ring", CameraLayout::kRing},
                    {"arc", CameraLayout::kArc},
                    {"grid", CameraLayout::kGrid}});
  options->Add("num_views", &num_views, "number of photos", {1, 10000});
  options->Add("width", &width, "width of the photos, pixels", {16, 20000});
  options->Add("height", &height, "height of the photos, pixels", {16, 20000});
  options->Add("focal_factor", &focal_factor, "focal length / longer side", {0.2, 20.0});
  options->Add("num_sparse_points", &num_sparse_points,
               "points with tracks in the sparse model; 0: none", {0, 10000000});
  options->Add("sparse_noise", &sparse_noise_px,
               "standard deviation of the sparse points, pixels on the surface", {0.0, 100.0});
  options->Add("image_extension", &image_extension, "file format of the photos: png or jpg");
}

namespace {

// The shape and where its cameras stand.
std::vector<Stand> MakeShapeAndStands(const SyntheticSceneOptions& options,
                                      const PinholeCamera& camera, ShapePtr* shape) {
  if (options.shape == ShapeName::kTown) {
    const TownOptions town_options;
    Flight flight = FlyOver(options, town_options.gsd);
    const double length = std::max(flight.length_x, flight.length_y);
    const Town town(town_options, static_cast<int>(std::ceil(length / Town::kLot)));
    *shape = std::make_shared<MeshShape>(town.Mesh(0, town.lots_per_side()));
    return std::move(flight.stands);
  }
  const double distance = FittingDistance(options, InterestOf(options.shape).radius);
  *shape = MakeShape(options.shape, distance / camera.MeanFocalLength());
  return MakeStands(options, InterestOf(options.shape));
}

}  // namespace

SyntheticScene MakeScene(const SyntheticSceneOptions& options, const RunContext& context) {
  const PinholeCamera camera = MakeCamera(options.width, options.height, options.focal_factor);
  SyntheticScene result;
  for (const Stand& stand : MakeShapeAndStands(options, camera, &result.shape)) {
    result.scene.views.push_back(
        MakeView(result.scene.num_views(), camera, LookAt(stand.center, stand.target)));
    std::string& name = result.scene.views.back().name;
    name = std::filesystem::path(name).replace_extension(options.image_extension).string();
  }
  AddSparsePoints(options, context, &result);
  result.photo.texture.finest_wavelength = 2.5 * result.gsd;
  result.photo.texture.coarsest_wavelength = 80.0 * result.gsd;
  result.photo.texture.weak_zone_size = 100.0 * result.gsd;
  result.photo.texture.seed = options.seed + 2;
  result.photo.seed = options.seed + 3;
  return result;
}

SyntheticScene MakeScene(ShapeName shape, int num_views, int width, int height) {
  SyntheticSceneOptions options;
  options.shape = shape;
  options.num_views = num_views;
  options.width = width;
  options.height = height;
  return MakeScene(options, RunContext());
}

}  // namespace lsmvs
