#include "lsmvs/synthetic/town.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "lsmvs/colmap_adapter/dense_workspace.h"
#include "lsmvs/colmap_adapter/fused_cloud.h"
#include "lsmvs/colmap_adapter/sparse_model_io.h"
#include "lsmvs/mesh/ply.h"
#include "lsmvs/synthetic/cameras.h"
#include "lsmvs/synthetic/random.h"
#include "lsmvs/synthetic/workspace.h"

namespace lsmvs {

namespace {

constexpr double kPointsPerSquarePixel = 0.5;  // as fused clouds have
// Ground, roof and walls of a lot, in the mean.
constexpr double kAreaOfLot = 520;  // of which points are left
constexpr double kStationX = 90, kStationY = 70;
constexpr double kObliqueDeg = 35;
constexpr int kWidth = 2000, kHeight = 1500;
constexpr double kFocalFactor = 1.0;
constexpr int kNumDirections = 5;
constexpr double kMinCosine = 0.25;  // between normal and line of sight

// Streams of random numbers.
constexpr uint64_t kHouseStream = uint64_t{1} << 40, kOrderStream = uint64_t{1} << 41;

// A rectangle of surface: origin + u [0,1] + v [0,1].
struct Patch {
  Eigen::Vector3d origin, u, v, normal;
  double Area() const { return u.cross(v).norm(); }
};

std::array<Patch, 5> SidesOf(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d a = box.min(), s = box.sizes();
  const Eigen::Vector3d x(s.x(), 0, 0), y(0, s.y(), 0), z(0, 0, s.z());
  return {{{a + z, x, y, Eigen::Vector3d::UnitZ()},
           {a, x, z, -Eigen::Vector3d::UnitY()},
           {a + y, x, z, Eigen::Vector3d::UnitY()},
           {a, y, z, -Eigen::Vector3d::UnitX()},
           {a + x, y, z, Eigen::Vector3d::UnitX()}}};
}

// Whether the segment from + t d, t in [0,1], meets the box.
bool Meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from, const Eigen::Vector3d& d) {
  double enter = 0, leave = 1;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (from[k] < box.min()[k] || from[k] > box.max()[k]) return false;
      continue;
    }
    const double a = (box.min()[k] - from[k]) / d[k], b = (box.max()[k] - from[k]) / d[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave;
}

Color ColorOf(const Eigen::Vector3d& normal, const Eigen::Vector3d& x) {
  const double shade = 0.55 + 0.35 * normal.dot(Eigen::Vector3d(0.4, 0.3, 0.866));
  const double stripes = 0.9 + 0.1 * std::sin(2 * x.x()) * std::sin(2 * x.y() + x.z());
  const Eigen::Vector3d base = normal.z() > 0.9 ? Eigen::Vector3d(130, 150, 110)  // grass, roofs
                                                : Eigen::Vector3d(190, 170, 150);
  return (shade * stripes * base).cwiseMin(255).cast<uint8_t>();
}

}  // namespace

void TownOptions::Describe(OptionSet* options) {
  options->Add("num_points", &num_points, "points of the cloud, about", {1e3, 1e11});
  options->Add("gsd", &gsd, "metres per pixel; there is a point for every two pixels", {0.01, 1});
  options->Add("noise_px", &noise_px, "standard deviation of the points along each axis, in pixels",
               {0, 10});
  options->Add("outlier_fraction", &outlier_fraction, "points that lie up to 3 m off", {0, 0.9});
}

namespace {

int LotsPerSide(const TownOptions& options) {
  const double per_lot = kPointsPerSquarePixel * kAreaOfLot / (options.gsd * options.gsd);
  return std::max(1, static_cast<int>(std::lround(std::sqrt(options.num_points / per_lot))));
}

}  // namespace

Town::Town(const TownOptions& options) : Town(options, LotsPerSide(options)) {}

Town::Town(const TownOptions& options, int lots_per_side)
    : options_(options), lots_per_side_(lots_per_side) {
  for (int j = 0; j < lots_per_side_; ++j) {
    for (int i = 0; i < lots_per_side_; ++i) houses_.push_back(MakeHouse(i, j));
  }
}

double Town::GroundAtCorner(int x, int y) const {
  constexpr double kTurn = 2 * std::numbers::pi;
  return 3 * std::sin(kTurn * x / 170) * std::cos(kTurn * y / 210) + std::sin(kTurn * (x + y) / 67);
}

double Town::GroundHeight(double x, double y) const {
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double u = x - i, v = y - j;
  const double a = GroundAtCorner(i, j), c = GroundAtCorner(i + 1, j + 1);
  // The cell's diagonal runs from (0, 0) to (1, 1).
  if (u > v) {
    const double b = GroundAtCorner(i + 1, j);
    return a + u * (b - a) + v * (c - b);
  }
  const double b = GroundAtCorner(i, j + 1);
  return a + v * (b - a) + u * (c - b);
}

Eigen::AlignedBox3d Town::MakeHouse(int i, int j) const {
  const auto lot =
      static_cast<uint64_t>(j) * static_cast<uint64_t>(lots_per_side_) + static_cast<uint64_t>(i);
  Random random(options_.seed, kHouseStream + lot);
  const auto whole = [&](int low, int high) {
    return low + static_cast<int>(random.Below(static_cast<uint64_t>(high - low + 1)));
  };
  const int width = whole(7, 12), depth = whole(7, 12);
  const int x = kLot * i + whole(3, kLot - 3 - width), y = kLot * j + whole(3, kLot - 3 - depth);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int a = 0; a <= width; ++a) {
    for (int b = 0; b <= depth; ++b) {
      low = std::min(low, GroundAtCorner(x + a, y + b));
      high = std::max(high, GroundAtCorner(x + a, y + b));
    }
  }
  return {Eigen::Vector3d(x, y, low - 0.5),
          Eigen::Vector3d(x + width, y + depth, high + random.Uniform(4, 12))};
}

double Town::HeightAbove(const Eigen::Vector3d& x) const {
  constexpr double kNearWall = 0.5;
  const auto lot = [&](double at) {
    return std::clamp(static_cast<int>(at / kLot), 0, lots_per_side_ - 1);
  };
  Eigen::AlignedBox3d house = House(lot(x.x()), lot(x.y()));
  const double roof = house.max().z();
  house.extend(house.min() - Eigen::Vector3d::Constant(kNearWall));
  house.extend(house.max() + Eigen::Vector3d::Constant(kNearWall));
  const bool over_house =
      house.contains(Eigen::Vector3d(x.x(), x.y(), 0.5 * (house.min().z() + house.max().z())));
  return std::max(0.0, x.z() - (over_house ? roof : GroundHeight(x.x(), x.y())));
}

bool Town::Hides(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  constexpr double kHighest = 4 + 1 + 12;  // of ground and house
  Eigen::Vector3d d = to - from;
  if (d.z() > 0 && to.z() > kHighest) d *= std::max(0.0, (kHighest - from.z()) / d.z());
  const Eigen::Vector3d end = from + d;
  const auto lots = [&](int k) {
    const double low = std::min(from[k], end[k]), high = std::max(from[k], end[k]);
    return std::pair(std::max(0, static_cast<int>(low / kLot)),
                     std::min(lots_per_side_ - 1, static_cast<int>(high / kLot)));
  };
  const auto [i0, i1] = lots(0);
  const auto [j0, j1] = lots(1);
  for (int i = i0; i <= i1; ++i) {
    for (int j = j0; j <= j1; ++j) {
      if (Meets(House(i, j), from, d)) return true;
    }
  }
  return false;
}

Scene Town::MakeViews() const {
  Scene scene;
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, kFocalFactor);
  const double height = options_.gsd * kFocalFactor * kWidth;
  const int columns = static_cast<int>(std::ceil(side() / kStationX)) + 1;
  const int rows = static_cast<int>(std::ceil(side() / kStationY)) + 1;
  const double tilt = std::tan(kObliqueDeg * std::numbers::pi / 180);
  const std::array<Eigen::Vector3d, kNumDirections> directions = {
      {{0, 0, -1}, {tilt, 0, -1}, {-tilt, 0, -1}, {0, tilt, -1}, {0, -tilt, -1}}};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector3d center(kStationX * i, kStationY * j, height);
      for (const Eigen::Vector3d& direction : directions) {
        scene.views.push_back(
            MakeView(scene.num_views(), camera, LookAt(center, center + direction)));
      }
    }
  }
  return scene;
}

namespace {

// Draws the points of one lot.
class LotSampler {
 public:
  LotSampler(const Town& town, const TownOptions& options, const Scene& scene, int lot)
      : town_(town),
        options_(options),
        scene_(scene),
        random_(options.seed, static_cast<uint64_t>(lot)) {
    columns_ = static_cast<int>(std::ceil(town.side() / kStationX)) + 1;
    rows_ = static_cast<int>(std::ceil(town.side() / kStationY)) + 1;
    i_ = lot % town.lots_per_side();
    j_ = lot / town.lots_per_side();
  }

  VisibilityCloud Run() {
    const Eigen::AlignedBox3d& house = town_.House(i_, j_);
    const Eigen::Vector3d corner(Town::kLot * i_, Town::kLot * j_, 0);
    Draw({corner, {Town::kLot, 0, 0}, {0, Town::kLot, 0}, Eigen::Vector3d::UnitZ()},
         [&](Eigen::Vector3d* x) {
           x->z() = town_.GroundHeight(x->x(), x->y());
           return !house.contains(Eigen::Vector3d(x->x(), x->y(), house.max().z()));
         });
    for (const Patch& side : SidesOf(house)) {
      Draw(side, [&](Eigen::Vector3d* x) {
        return side.normal.z() > 0 || x->z() > town_.GroundHeight(x->x(), x->y());
      });
    }
    return std::move(cloud_);
  }

 private:
  // One point in each square of a grid, moved onto the surface by `place` unless that refuses it.
  template <class Place>
  void Draw(const Patch& patch, const Place& place) {
    const double spacing = options_.gsd / std::sqrt(kPointsPerSquarePixel);
    const int rows = static_cast<int>(patch.v.norm() / spacing);
    const int columns = static_cast<int>(patch.u.norm() / spacing);
    for (int b = 0; b < rows; ++b) {
      for (int a = 0; a < columns; ++a) {
        const double u = (a + random_.Uniform()) / columns, v = (b + random_.Uniform()) / rows;
        Eigen::Vector3d x = patch.origin + u * patch.u + v * patch.v;
        if (place(&x)) Add(x, patch.normal);
      }
    }
  }

  void Add(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) {
    FindViews(x, normal);
    if (views_.size() < 2) return;
    Eigen::Vector3d measured = x + options_.noise_px * options_.gsd * random_.Gaussian3();
    if (random_.Uniform() < options_.outlier_fraction) {
      constexpr double kReach = 3;
      for (int k = 0; k < 3; ++k) measured[k] += random_.Uniform(-kReach, kReach);
    }
    cloud_.Add(measured.cast<float>(), normal.cast<float>(), ColorOf(normal, x), views_);
  }

  // Up to kMaxViews, from the nearest stations first.
  void FindViews(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) {
    views_.clear();
    const Eigen::Vector3d above = x + 1e-3 * normal;
    const int i0 = static_cast<int>(std::lround(x.x() / kStationX));
    const int j0 = static_cast<int>(std::lround(x.y() / kStationY));
    for (const auto& [i, j] : kStations) {
      if (i0 + i < 0 || i0 + i >= columns_ || j0 + j < 0 || j0 + j >= rows_) continue;
      const int first = kNumDirections * ((j0 + j) * columns_ + i0 + i);
      if (!CanSee(above, normal, first)) continue;
      for (int k = first; k < first + kNumDirections; ++k) {
        const View& view = scene_.views[static_cast<size_t>(k)];
        const Eigen::Vector3d in_cam = view.cam_from_world * above;
        if (in_cam.z() <= 0 || !view.camera.Contains(view.camera.Project(in_cam))) continue;
        views_.push_back(static_cast<uint32_t>(k));
        if (views_.size() == Town::kMaxViews) return;
      }
    }
  }

  bool CanSee(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int view) const {
    const Eigen::Vector3d center = scene_.views[static_cast<size_t>(view)].CenterInWorld();
    return (center - x).normalized().dot(normal) > kMinCosine && !town_.Hides(x, center);
  }

  // Offsets of stations, nearest first.
  static constexpr std::array<std::pair<int, int>, 13> kStations = {{{0, 0},
                                                                     {0, 1},
                                                                     {0, -1},
                                                                     {1, 0},
                                                                     {-1, 0},
                                                                     {1, 1},
                                                                     {-1, -1},
                                                                     {1, -1},
                                                                     {-1, 1},
                                                                     {0, 2},
                                                                     {0, -2},
                                                                     {2, 0},
                                                                     {-2, 0}}};

  const Town& town_;
  const TownOptions& options_;
  const Scene& scene_;
  Random random_;
  int columns_, rows_, i_, j_;
  VisibilityCloud cloud_;
  std::vector<uint32_t> views_;
};

}  // namespace

VisibilityCloud Town::SampleLot(int lot, const Scene& views) const {
  return LotSampler(*this, options_, views, lot).Run();
}

void SampleTown(const Town& town, const Scene& views, const RunContext& context,
                const CloudSink& sink) {
  const size_t num_lots =
      static_cast<size_t>(town.lots_per_side()) * static_cast<size_t>(town.lots_per_side());
  std::vector<uint32_t> order(num_lots);
  for (size_t i = 0; i < num_lots; ++i) order[i] = static_cast<uint32_t>(i);
  Random random(0, kOrderStream);
  for (size_t i = num_lots; i > 1; --i) std::swap(order[i - 1], order[random.Below(i)]);
  constexpr size_t kBatch = 32;
  std::vector<VisibilityCloud> batch(kBatch);
  for (size_t first = 0; first < num_lots; first += kBatch) {
    const size_t count = std::min(kBatch, num_lots - first);
    ParallelFor(context, count, 1, [&](size_t k) {
      batch[k] = town.SampleLot(static_cast<int>(order[first + k]), views);
    });
    for (size_t k = 0; k < count; ++k) sink(batch[k]);
  }
}

TownWorkspace WriteTown(const std::filesystem::path& folder, const Town& town, int truth_lots,
                        const RunContext& context) {
  const Scene views = town.MakeViews();
  const DenseWorkspace workspace{folder};
  std::filesystem::create_directories(workspace.SparseFolder());
  std::filesystem::create_directories(folder / "images");
  WriteSparseModel(workspace.SparseFolder(), MakeSparseModel(views));
  TownWorkspace result;
  result.num_views = views.num_views();
  FusedCloudWriter writer(workspace.FusedPath(), views);
  SampleTown(town, views, context, [&](const VisibilityCloud& part) {
    writer.Add(part);
    result.num_points += part.size();
  });
  writer.Commit();
  const int lots = std::min(truth_lots, town.lots_per_side());
  result.truth_begin = (town.lots_per_side() - lots) / 2;
  result.truth_end = result.truth_begin + lots;
  WriteMeshPly(folder / "gt_mesh.ply", town.Mesh(result.truth_begin, result.truth_end));
  return result;
}

TriangleMesh Town::Mesh(int begin, int end) const {
  TriangleMesh mesh;
  const auto add = [&](const Eigen::Vector3d& x) {
    mesh.vertices.push_back(x);
    return static_cast<int>(mesh.vertices.size()) - 1;
  };
  const auto add_quad = [&](const std::array<Eigen::Vector3d, 4>& x) {
    const int a = add(x[0]), b = add(x[1]), c = add(x[2]), d = add(x[3]);
    mesh.faces.emplace_back(a, b, c);
    mesh.faces.emplace_back(a, c, d);
  };
  const auto ground = [&](int x, int y) { return Eigen::Vector3d(x, y, GroundAtCorner(x, y)); };
  for (int j = begin; j < end; ++j) {
    for (int i = begin; i < end; ++i) {
      const Eigen::AlignedBox3d& house = House(i, j);
      for (int y = kLot * j; y < kLot * (j + 1); ++y) {
        for (int x = kLot * i; x < kLot * (i + 1); ++x) {
          const Eigen::Vector3d middle(x + 0.5, y + 0.5, house.max().z());
          if (house.contains(middle)) continue;
          add_quad({ground(x, y), ground(x + 1, y), ground(x + 1, y + 1), ground(x, y + 1)});
        }
      }
      for (const Patch& side : SidesOf(house)) {
        const bool outward = side.u.cross(side.v).dot(side.normal) > 0;
        const Eigen::Vector3d &o = side.origin, p = o + side.u, q = p + side.v, r = o + side.v;
        add_quad(outward ? std::array{o, p, q, r} : std::array{o, r, q, p});
      }
    }
  }
  return mesh;
}

}  // namespace lsmvs
