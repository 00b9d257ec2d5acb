#include "lsmvs/stereo/quasi_dense/tracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lsmvs/geometry/triangulation.h"
#include "lsmvs/stereo/quasi_dense/cross_check.h"
#include "lsmvs/stereo/quasi_dense/planes.h"

namespace lsmvs::quasi_dense {

namespace {

constexpr size_t kRowsOfBlock = 4;
constexpr int kFitReach = 2;
constexpr float kMatchErrorPx = 0.4f;
// Spacings within which an interest point of another view counts as the same piece of surface.
constexpr float kCoverRadius = 0.7f;
// Steps in pixels at which a neighbour's ZNCC is taken to find its maximum.
constexpr float kObserveStepPx = 0.6f;
// A neighbour without interest points there joins the track if its ZNCC exceeds the threshold by
// this.
constexpr float kUnknownExtraNcc = 0.15f;

struct CoveredCell {
  int view_idx;
  size_t cell;
};

// What the blocks of a view hand over, put together in their order.
struct TrackBlock {
  VisibilityCloud cloud;
  std::vector<CoveredCell> covered;
  QuasiDenseCounters counters;
};

// Makes the tracks of one block of one view; reads the world only.
class TrackMaker {
 public:
  TrackMaker(int view_idx, const SearchView& view, const NeighborGrids& grids,
             const ColorImage& colors, const TrackWorld& world, TrackBlock* block)
      : view_idx_(view_idx),
        view_(view),
        grids_(grids),
        colors_(colors),
        world_(world),
        block_(block),
        optimizer_(world.options.loss_scale_px) {}

  void Make(const InterestPoint& point) {
    Begin(point);
    const InterestPoint smooth = Smoothed(point);
    for (size_t s = 0; s < view_.pairings.size(); ++s) AskSlot(smooth, s);
    block_->counters.num_patches += 3 * observations_.size();
    if (NumMutual() < world_.options.min_num_views) return;
    ++block_->counters.num_mutual;
    ++block_->counters.num_tracks;
    const std::optional<Eigen::Vector3d> x = Locate(smooth);
    if (x && Passes(*x)) Emit(smooth, *x);
  }

 private:
  struct Observer {
    int view_idx;
    size_t slot;
    bool mutual;
  };

  void Begin(const InterestPoint& point) {
    observations_.clear();
    observers_.clear();
    observations_.push_back(
        {&world_.projections[static_cast<size_t>(view_idx_)], point.position.cast<double>()});
    observers_.push_back({view_idx_, 0, true});
    WindowWarp warp;
    warp.x = point.position.x();
    warp.y = point.position.y();
    ReadReferenceWindow(*view_.image, view_.pattern, warp, &reference_);
  }

  // With the slopes of the plane through the points around.
  InterestPoint Smoothed(const InterestPoint& point) const {
    PlaneWarp warped;
    float velocity = 0;
    for (size_t s = 0; s < view_.pairings.size(); ++s) {
      if ((point.slots >> s & 1u) == 0) continue;
      if (WarpPlane(view_.pairings[s].there, point.position, point.plane, &warped)) {
        velocity = std::max(velocity, warped.velocity.norm());
      }
    }
    if (!(velocity > 0)) return point;
    InterestPoint smooth = point;
    const Plane fit =
        FitPlane(*grids_.own, point.position, point.plane, kMatchErrorPx / velocity, kFitReach);
    smooth.plane.qx = fit.qx;
    smooth.plane.qy = fit.qy;
    return smooth;
  }

  void AskSlot(const InterestPoint& point, size_t slot) {
    const Pairing& pairing = view_.pairings[slot];
    const CrossCheck check =
        CrossCheckPoint(pairing, *grids_.others[slot], point.position, point.plane.q,
                        static_cast<float>(world_.options.max_mutual_error_px));
    const bool mutual = check.status == CrossCheckStatus::kConfirmed;
    if (!mutual && check.status != CrossCheckStatus::kUnknown) return;
    const float min_ncc = view_.min_ncc + (mutual ? 0.0f : kUnknownExtraNcc);
    const std::optional<Eigen::Vector2d> x_px = Observe(point, slot, min_ncc);
    if (!x_px) return;
    observations_.push_back({&world_.projections[static_cast<size_t>(pairing.view_idx)], *x_px});
    observers_.push_back({pairing.view_idx, slot, mutual});
  }

  // Where the neighbour sees the window: the maximum of ZNCC along its epipolar line near the
  // point's image. Empty if there is none, or if it is too weak.
  std::optional<Eigen::Vector2d> Observe(const InterestPoint& point, size_t slot,
                                         float min_ncc) const {
    const Pairing& pairing = view_.pairings[slot];
    const PackedImage& other = *view_.others[slot];
    PlaneWarp warped;
    if (!WarpPlane(pairing.there, point.position, point.plane, &warped)) return std::nullopt;
    const Eigen::Vector2f along = warped.velocity.normalized() * kObserveStepPx;
    if (!along.allFinite()) return std::nullopt;
    float ncc[3];
    for (int k = 0; k < 3; ++k) {
      WindowWarp moved = warped.warp;
      moved.x += static_cast<float>(k - 1) * along.x();
      moved.y += static_cast<float>(k - 1) * along.y();
      if (!WindowInside(other, view_.pattern, moved)) return std::nullopt;
      ncc[k] = CompareWindow(other, view_.pattern, moved, reference_);
    }
    const float curvature = ncc[0] - 2 * ncc[1] + ncc[2];
    if (ncc[1] < min_ncc || !(curvature < -1e-5f)) return std::nullopt;
    const float peak = 0.5f * (ncc[0] - ncc[2]) / curvature;
    if (std::abs(peak) > 1.5f) return std::nullopt;
    return (Eigen::Vector2f(warped.warp.x, warped.warp.y) + peak * along).cast<double>();
  }

  int NumMutual() const {
    return static_cast<int>(
        std::count_if(observers_.begin(), observers_.end(),
                      [](const Observer& observer) { return observer.mutual; }));
  }

  // Optimises, drops the observations that stay off, and optimises again.
  std::optional<Eigen::Vector3d> Locate(const InterestPoint& point) {
    const View& view = world_.scene.views[static_cast<size_t>(view_idx_)];
    const PinholeCamera& camera = world_.cameras[static_cast<size_t>(view_idx_)];
    const double depth = 1.0 / point.plane.q;
    const Eigen::Vector3d in_camera = camera.Ray(point.position.cast<double>()) * depth;
    const Eigen::Vector3d start = view.cam_from_world.Inverse() * in_camera;
    const double unit = depth / camera.MeanFocalLength();
    std::optional<Eigen::Vector3d> x = optimizer_.Optimize(observations_, start, unit);
    if (x && DropOutliers(*x) && NumMutual() >= world_.options.min_num_views) {
      x = optimizer_.Optimize(observations_, *x, unit);
    }
    if (!x) ++block_->counters.num_dropped_cheirality;
    return x;
  }

  bool DropOutliers(const Eigen::Vector3d& x) {
    size_t kept = 0;
    for (size_t k = 0; k < observations_.size(); ++k) {
      if (ReprojectionError(observations_[k], x) > world_.options.max_reproj_error_px) continue;
      observations_[kept] = observations_[k];
      observers_[kept++] = observers_[k];
    }
    const bool dropped = kept < observations_.size();
    observations_.resize(kept);
    observers_.resize(kept);
    return dropped;
  }

  bool Passes(const Eigen::Vector3d& x) {
    DropOutliers(x);
    if (NumMutual() < world_.options.min_num_views) {
      ++block_->counters.num_dropped_error;
      return false;
    }
    const double min_angle = world_.options.min_triangulation_angle_deg * M_PI / 180.0;
    if (LargestAngle(x) < min_angle) {
      ++block_->counters.num_dropped_angle;
      return false;
    }
    const Eigen::AlignedBox3d& box = world_.options.bounding_box;
    if (!box.isEmpty() && !box.contains(x + world_.scene.world_offset)) {
      ++block_->counters.num_dropped_outside;
      return false;
    }
    return true;
  }

  double LargestAngle(const Eigen::Vector3d& x) const {
    double largest = 0;
    for (size_t a = 0; a < observers_.size(); ++a) {
      for (size_t b = a + 1; b < observers_.size(); ++b) {
        largest = std::max(largest, TriangulationAngle(Center(observers_[a].view_idx),
                                                       Center(observers_[b].view_idx), x));
      }
    }
    return largest;
  }

  Eigen::Vector3d Center(int view_idx) const {
    return world_.scene.views[static_cast<size_t>(view_idx)].CenterInWorld();
  }

  void Emit(const InterestPoint& point, const Eigen::Vector3d& x) {
    std::vector<uint32_t>& views = views_scratch_;
    views.clear();
    for (const Observer& observer : observers_) {
      views.push_back(static_cast<uint32_t>(observer.view_idx));
      if (observer.mutual && observer.view_idx > view_idx_) Cover(point, observer);
    }
    block_->cloud.Add(x.cast<float>(), NormalInWorld(point).cast<float>(), ColorAt(point.position),
                      views);
  }

  // On a plane a X + b Y + c Z = 1 in the camera frame, inverse depth is a u + b v + c at
  // normalised image coordinates (u, v).
  Eigen::Vector3d NormalInWorld(const InterestPoint& point) const {
    const PinholeCamera& camera = world_.cameras[static_cast<size_t>(view_idx_)];
    const double a = point.plane.qx * camera.fx, b = point.plane.qy * camera.fy;
    const Eigen::Vector3d ray = camera.Ray(point.position.cast<double>());
    const double c = point.plane.q - a * ray.x() - b * ray.y();
    const Eigen::Vector3d in_camera = -Eigen::Vector3d(a, b, c).normalized();
    return world_.scene.views[static_cast<size_t>(view_idx_)].cam_from_world.rotation.transpose() *
           in_camera;
  }

  Color ColorAt(const Eigen::Vector2f& position) const {
    return colors_(std::clamp(static_cast<int>(position.x()), 0, colors_.width - 1),
                   std::clamp(static_cast<int>(position.y()), 0, colors_.height - 1));
  }

  void Cover(const InterestPoint& point, const Observer& observer) {
    const Pairing& pairing = view_.pairings[observer.slot];
    const PointGrid& grid = *grids_.others[observer.slot];
    const Eigen::Vector3f seen = pairing.there(point.position, point.plane.q);
    const Eigen::Vector2f place = seen.head<2>() / seen.z();
    const float radius = kCoverRadius * grid.spacing;
    ForPointsAround(grid, place, 1, [&](const InterestPoint& other) {
      if (!other.matched() || (other.position - place).squaredNorm() > radius * radius) return;
      if (MutualError(pairing.back, point.position, place, other) >
          world_.options.max_mutual_error_px) {
        return;
      }
      block_->covered.push_back(
          {observer.view_idx, static_cast<size_t>(&other - grid.cells.pixels.data())});
    });
  }

  int view_idx_;
  const SearchView& view_;
  const NeighborGrids& grids_;
  const ColorImage& colors_;
  const TrackWorld& world_;
  TrackBlock* block_;
  PointOptimizer optimizer_;
  ReferenceWindow reference_;
  std::vector<Observation> observations_;  // parallel to observers_; the reference first
  std::vector<Observer> observers_;
  std::vector<uint32_t> views_scratch_;
};

void AddCounters(const QuasiDenseCounters& from, QuasiDenseCounters* to) {
  to->num_mutual += from.num_mutual;
  to->num_tracks += from.num_tracks;
  to->num_dropped_angle += from.num_dropped_angle;
  to->num_dropped_error += from.num_dropped_error;
  to->num_dropped_cheirality += from.num_dropped_cheirality;
  to->num_dropped_outside += from.num_dropped_outside;
  to->num_patches += from.num_patches;
}

void AddBlock(const TrackBlock& block, TrackWorld* world, VisibilityCloud* cloud,
              QuasiDenseCounters* counters) {
  for (size_t p = 0; p < block.cloud.size(); ++p) {
    cloud->Add(block.cloud.positions[p], block.cloud.normals[p], block.cloud.colors[p],
               block.cloud.ViewsOf(p));
  }
  for (const CoveredCell& covered : block.covered) {
    world->covered[static_cast<size_t>(covered.view_idx)][covered.cell] = true;
  }
  AddCounters(block.counters, counters);
}

}  // namespace

VisibilityCloud MakeTracks(int view_idx, const SearchView& view, const NeighborGrids& grids,
                           const ColorImage& colors, const RunContext& context, TrackWorld* world,
                           QuasiDenseCounters* counters) {
  const PointGrid& grid = *grids.own;
  std::vector<bool> covered = std::exchange(world->covered[static_cast<size_t>(view_idx)], {});
  covered.resize(grid.cells.size());
  const size_t num_rows = static_cast<size_t>(grid.cells.height);
  std::vector<TrackBlock> blocks((num_rows + kRowsOfBlock - 1) / kRowsOfBlock);
  ParallelBlocks(context, num_rows, kRowsOfBlock, [&](size_t begin, size_t end) {
    TrackMaker maker(view_idx, view, grids, colors, *world, &blocks[begin / kRowsOfBlock]);
    const size_t width = static_cast<size_t>(grid.cells.width);
    for (size_t cell = begin * width; cell < end * width; ++cell) {
      if (grid.cells.pixels[cell].matched() && !covered[cell]) {
        maker.Make(grid.cells.pixels[cell]);
      }
    }
  });
  for (size_t s = 0; s < view.pairings.size(); ++s) {
    const int other = view.pairings[s].view_idx;
    if (other > view_idx) {
      world->covered[static_cast<size_t>(other)].resize(grids.others[s]->cells.size());
    }
  }
  VisibilityCloud cloud;
  for (const TrackBlock& block : blocks) AddBlock(block, world, &cloud, counters);
  return cloud;
}

}  // namespace lsmvs::quasi_dense
