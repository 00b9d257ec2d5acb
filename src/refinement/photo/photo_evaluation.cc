#include "lsmvs/refinement/photo/photo_evaluation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <functional>
#include <mutex>

#include "lsmvs/refinement/photo/surface_map_cache.h"
#include "lsmvs/refinement/photo/work_order.h"
#include "lsmvs/util/ranked_bits.h"

namespace lsmvs {

namespace {

constexpr int kTileSize = 128;

struct Rectangle {
  int left = 0, top = 0, right = 0, bottom = 0;  // right and bottom exclusive
  bool Empty() const { return right <= left || bottom <= top; }
  int Width() const { return right - left; }
  int Height() const { return bottom - top; }
};

Rectangle Grown(const Rectangle& r, int by, const PinholeCamera& camera) {
  return {std::max(0, r.left - by), std::max(0, r.top - by), std::min(camera.width, r.right + by),
          std::min(camera.height, r.bottom + by)};
}

Rectangle Intersection(const Rectangle& a, const Rectangle& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

// Works through the pairs of one reference view.
class ViewEvaluator {
 public:
  ViewEvaluator(const ImageStore& images, const std::vector<PosedCamera>& views,
                const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& directions,
                const FacePairs& pairs, const std::vector<uint8_t>& active,
                const PhotoEnergyOptions& options, SurfaceMapCache* cache)
      : images_(images),
        views_(views),
        mesh_(mesh),
        directions_(directions),
        pairs_(pairs),
        active_(active),
        options_(options),
        cache_(*cache) {
    correlation_.derivatives = !directions.empty();
  }

  ViewContribution Evaluate(int view_idx) {
    view_idx_ = view_idx;
    FindSlots();
    ViewContribution result = EvaluateSlots();
    LetGo();
    return result;
  }

 private:
  void FindSlots() {
    const std::span<const ViewPair> pairs = PairsOfView(pairs_.pairs, view_idx_);
    first_pair_ = static_cast<int>(pairs.data() - pairs_.pairs.data());
    num_slots_ = static_cast<int>(pairs.size());
  }

  // Of maps and photos.
  void LetGo() {
    maps_ = {};
    gray_.reset();
    mask_.reset();
    neighbors_.clear();
  }

  int OtherView(int slot) const { return (pairs_.pairs.begin() + first_pair_ + slot)->j; }

  ViewContribution EvaluateSlots() {
    maps_ = cache_.Draw(view_idx_);
    if (!FindFaces()) return {};
    gray_ = images_.Gray(view_idx_, options_.level);
    mask_ = images_.Mask(view_idx_, options_.level);
    sums_.assign(faces_.size(), FaceSums());
    LoadNeighbors();
    const PinholeCamera& camera = View().camera;
    for (int top = 0; top < camera.height; top += kTileSize) {
      for (int left = 0; left < camera.width; left += kTileSize) {
        EvaluateTile({left, top, std::min(left + kTileSize, camera.width),
                      std::min(top + kTileSize, camera.height)});
      }
    }
    return Collect();
  }

  // What a pair needs of its other view.
  struct Slot {
    std::shared_ptr<const Raster<float>> depth;
    std::shared_ptr<const GrayImage> gray;
    InverseDepthTransfer geometry;
    Rectangle judged;  // bounding box of the pixels near the present tile that the pair judges
  };

  // Lists the active faces that this view shows, with the pairs that judge each; false if none
  // does. A face that no pair judges may still lie in the windows of its neighbours.
  bool FindFaces() {
    local_.Assign(mesh_.faces.size());
    int32_t last = -1;
    for (const int32_t face : maps_.face->pixels) {
      if (face != last && face >= 0) local_.Set(static_cast<size_t>(face));
      last = face;
    }
    faces_.clear();
    slots_.clear();
    used_slots_ = 0;
    local_.ForEach([&](size_t f) {
      if (!active_.empty() && !active_[f]) return local_.Clear(f);
      faces_.push_back(static_cast<int32_t>(f));
      slots_.push_back(SlotsOf(f));
      used_slots_ |= slots_.back();
    });
    local_.Rank();
    return used_slots_ != 0;
  }

  uint32_t SlotsOf(size_t face) const {
    const size_t per_face = static_cast<size_t>(pairs_.per_face);
    uint32_t slots = 0;
    for (size_t k = 0; k < per_face; ++k) {
      const int slot = pairs_.of_face[face * per_face + k] - first_pair_;
      if (slot >= 0 && slot < num_slots_) slots |= uint32_t{1} << slot;
    }
    return slots;
  }

  void LoadNeighbors() {
    neighbors_.assign(static_cast<size_t>(num_slots_), Slot());
    for (int slot = 0; slot < num_slots_; ++slot) {
      if (!(used_slots_ >> slot & 1)) continue;
      const int j = OtherView(slot);
      neighbors_[static_cast<size_t>(slot)] = {
          cache_.Depth(j), images_.Gray(j, options_.level),
          MakeInverseDepthTransfer(views_[static_cast<size_t>(j)], View()), Rectangle()};
    }
  }

  void EvaluateTile(const Rectangle& tile) {
    const PinholeCamera& camera = View().camera;
    const int radius = correlation_.radius;
    // For the derivatives: pixels of the tile lie in windows of judged pixels up to a radius away,
    // which reach a radius further.
    const int margin = correlation_.derivatives ? radius : 0;
    FindMasks(Grown(tile, margin + radius, camera));
    FindJudgedParts(Grown(tile, margin, camera));
    const size_t size = static_cast<size_t>(tile.Width()) * static_cast<size_t>(tile.Height());
    for (auto* plane : {&error_, &mass_, &slope_, &curvature_}) plane->assign(size, 0.0f);
    bool any = false;
    for (int slot = 0; slot < num_slots_; ++slot) {
      const Rectangle& judged = neighbors_[static_cast<size_t>(slot)].judged;
      if (judged.Empty()) continue;
      any = true;
      const Rectangle part = Intersection(Grown(judged, margin, camera), tile);
      const Rectangle area = Grown(part, margin + radius, camera);
      FillTile(area, slot);
      CorrelateWindows(correlation_, &scratch_, &tile_);
      AddPlanes(tile, part, area);
    }
    if (any) AddToFaces(tile);
  }

  // The pairs that judge each pixel of an area, and the faces that they judge.
  void FindMasks(const Rectangle& area) {
    area_ = area;
    const size_t size = static_cast<size_t>(area.Width()) * static_cast<size_t>(area.Height());
    if (masks_.size() < size) masks_.resize(size);
    for (int row = area.top; row < area.bottom; ++row) {
      const int32_t* face = maps_.face->Row(row) + area.left;
      uint32_t* masks = MaskRow(row, area.left);
      for (int x = 0; x < area.Width(); ++x) {
        masks[x] = x > 0 && face[x] == face[x - 1] ? masks[x - 1] : SlotsAt(face[x]);
      }
    }
  }

  uint32_t* MaskRow(int row, int column) {
    return &masks_[static_cast<size_t>(row - area_.top) * static_cast<size_t>(area_.Width()) +
                   static_cast<size_t>(column - area_.left)];
  }

  // Bounding box of the pixels that each pair judges.
  void FindJudgedParts(const Rectangle& tile) {
    for (Slot& slot : neighbors_) slot.judged = {tile.right, tile.bottom, tile.left, tile.top};
    for (int row = tile.top; row < tile.bottom; ++row) {
      const uint32_t* masks = MaskRow(row, tile.left);
      for (int begin = 0, end = 0; begin < tile.Width(); begin = end) {
        while (end < tile.Width() && masks[end] == masks[begin]) ++end;
        for (uint32_t slots = masks[begin]; slots != 0; slots &= slots - 1) {
          Rectangle& part = neighbors_[static_cast<size_t>(std::countr_zero(slots))].judged;
          part = {std::min(part.left, tile.left + begin), std::min(part.top, row),
                  std::max(part.right, tile.left + end), row + 1};
        }
      }
    }
  }

  uint32_t SlotsAt(int32_t face) const {
    if (face < 0) return 0;
    const int32_t local = local_.RankOf(static_cast<size_t>(face));
    return local < 0 ? 0 : slots_[static_cast<size_t>(local)];
  }

  void FillTile(const Rectangle& area, int slot) {
    const Slot& neighbor = neighbors_[static_cast<size_t>(slot)];
    tile_.Resize(area.Width(), area.Height());
    by_depth_.resize(std::max(by_depth_.size(), tile_.warped.size()));
    FillWeights(area, slot);
    tile_.FindSpans(correlation_.radius);
    const float tolerance = static_cast<float>(options_.depth_tolerance);
    for (int row = area.top; row < area.bottom; ++row) {
      const ColumnSpan& span = tile_.reached[static_cast<size_t>(row - area.top)];
      if (span.Empty()) continue;
      const int left = area.left + span.begin, count = span.end - span.begin;
      const size_t start = TileIndex(area, row, left);
      const float* gray = gray_->Row(row) + left;
      std::copy(gray, gray + count, &tile_.reference[start]);
      WarpRow(neighbor.geometry, *neighbor.gray, *neighbor.depth, tolerance, row, left, count,
              maps_.depth->Row(row) + left,
              {&tile_.warped[start], &by_depth_[start], &tile_.valid[start]});
      if (mask_) ApplyMask(mask_->Row(row) + left, count, &tile_.valid[start]);
    }
  }

  // Position of a pixel in planes of a rectangle.
  static size_t TileIndex(const Rectangle& area, int row, int column) {
    return static_cast<size_t>(row - area.top) * static_cast<size_t>(area.Width()) +
           static_cast<size_t>(column - area.left);
  }

  void FillWeights(const Rectangle& area, int slot) {
    for (int row = area.top; row < area.bottom; ++row) {
      const uint32_t* masks = MaskRow(row, area.left);
      float* weights = &tile_.weight[TileIndex(area, row, area.left)];
      for (int x = 0; x < area.Width(); ++x) {
        weights[x] = static_cast<float>(static_cast<int32_t>(masks[x] >> slot & 1));
      }
    }
  }

  static void ApplyMask(const uint8_t* mask, int count, float* valid) {
    for (int x = 0; x < count; ++x) {
      if (mask[x] == 0) valid[x] = 0.0f;
    }
  }

  // Adds the results of a pair, which lie in `area`, on its `part` of the tile.
  void AddPlanes(const Rectangle& tile, const Rectangle& part, const Rectangle& area) {
    for (int row = part.top; row < part.bottom; ++row) {
      const ColumnSpan& span = tile_.reached[static_cast<size_t>(row - area.top)];
      const int left = std::max(part.left, area.left + span.begin);
      const int right = std::min(part.right, area.left + span.end);
      if (left >= right) continue;
      const size_t to = TileIndex(tile, row, left), from = TileIndex(area, row, left);
      const size_t count = static_cast<size_t>(right - left);
      for (size_t x = 0; x < count; ++x) error_[to + x] += tile_.error[from + x];
      for (size_t x = 0; x < count; ++x) mass_[to + x] += tile_.mass[from + x];
      if (!correlation_.derivatives) continue;
      for (size_t x = 0; x < count; ++x) {
        const float by_depth = by_depth_[from + x];
        slope_[to + x] += tile_.derivative[from + x] * by_depth;
        curvature_[to + x] += tile_.curvature[from + x] * by_depth * by_depth;
      }
    }
  }

  void AddToFaces(const Rectangle& tile) {
    for (int row = tile.top; row < tile.bottom; ++row) {
      const int32_t* face = maps_.face->Row(row);
      for (int begin = tile.left, end = begin; begin < tile.right; begin = end) {
        while (end < tile.right && face[end] == face[begin]) ++end;
        if (face[begin] < 0) continue;
        const int32_t local = local_.RankOf(static_cast<size_t>(face[begin]));
        if (local < 0) continue;
        FaceSums& sums = sums_[static_cast<size_t>(local)];
        sums.pixels +=
            static_cast<float>((end - begin) * std::popcount(slots_[static_cast<size_t>(local)]));
        AddRun(tile, row, begin, end, &sums);
      }
    }
  }

  void AddRun(const Rectangle& tile, int row, int begin, int end, FaceSums* sums) const {
    const PinholeCamera& camera = View().camera;
    const double ray_y = (row + 0.5 - camera.cy) / camera.fy, step = 1.0 / camera.fx;
    const float* depth = maps_.depth->Row(row);
    const size_t start = static_cast<size_t>(row - tile.top) * static_cast<size_t>(tile.Width());
    double error = 0, mass = 0, slope = 0, slope_x = 0, curvature = 0, curvature_x = 0;
    for (int column = begin; column < end; ++column) {
      const size_t at = start + static_cast<size_t>(column - tile.left);
      error += error_[at];
      mass += mass_[at];
      const double d = depth[column], ray_x = (column + 0.5 - camera.cx) * step;
      const double p = slope_[at] * d * d, q = curvature_[at] * d * d * d;
      slope += p;
      slope_x += p * ray_x;
      curvature += q;
      curvature_x += q * ray_x;
    }
    sums->error += static_cast<float>(error);
    sums->mass += static_cast<float>(mass);
    sums->slope += Eigen::Vector3d(slope_x, slope * ray_y, slope).cast<float>();
    sums->curvature += Eigen::Vector3d(curvature_x, curvature * ray_y, curvature).cast<float>();
  }

  ViewContribution Collect() {
    for (size_t k = 0; k < faces_.size() && !directions_.empty(); ++k) Differentiate(k);
    return {std::move(faces_), std::move(sums_)};
  }

  // A vertex displaced by t along u moves the surface along the ray of a pixel by d * lambda * (m .
  // u) t, where lambda is the vertex' barycentric coordinate there and m the face's plane, m . x
  // = 1. lambda = d * (P^-1 r) with P the vertices as columns.
  void Differentiate(size_t k) {
    FaceSums& sums = sums_[k];
    if (sums.curvature.z() == 0) return;
    const Eigen::Vector3i& face = mesh_.faces[static_cast<size_t>(faces_[k])];
    const Rigid3& pose = View().cam_from_world;
    Eigen::Matrix3d p;
    for (int c = 0; c < 3; ++c) p.col(c) = pose * mesh_.vertices[face[c]];
    const Eigen::Matrix3d inverse = p.inverse();
    const Eigen::Vector3d slopes = inverse * sums.slope.cast<double>();
    const Eigen::Vector3d curvatures = inverse * sums.curvature.cast<double>();
    sums.slope.setZero();
    sums.curvature.setZero();
    if (!inverse.allFinite()) return;
    const Eigen::Vector3d plane = inverse.colwise().sum();
    for (int c = 0; c < 3; ++c) {
      const double along = plane.dot(pose.rotation * directions_[static_cast<size_t>(face[c])]);
      sums.slope[c] = static_cast<float>(along * slopes[c]);
      sums.curvature[c] = static_cast<float>(along * along * std::max(curvatures[c], 0.0));
    }
  }

  const PosedCamera& View() const { return views_[static_cast<size_t>(view_idx_)]; }

  const ImageStore& images_;
  const std::vector<PosedCamera>& views_;
  const TriangleMesh& mesh_;
  const std::vector<Eigen::Vector3d>& directions_;
  const FacePairs& pairs_;
  const std::vector<uint8_t>& active_;
  const PhotoEnergyOptions& options_;
  SurfaceMapCache& cache_;
  CorrelationOptions correlation_ = options_.correlation;  // derivatives only where wanted

  int view_idx_ = 0, first_pair_ = 0, num_slots_ = 0;
  uint32_t used_slots_ = 0;
  RankedBits local_;             // of all faces: those in faces_
  std::vector<int32_t> faces_;   // faces that this view judges
  std::vector<uint32_t> slots_;  // as faces_: bit s is set if pair first_pair_ + s judges it
  std::vector<FaceSums> sums_;   // as faces_
  DrawnMaps maps_;
  std::shared_ptr<const GrayImage> gray_;
  std::shared_ptr<const ByteImage> mask_;
  std::vector<Slot> neighbors_;
  Rectangle area_;               // the present tile with its margin
  std::vector<uint32_t> masks_;  // as area_: bit s is set if pair first_pair_ + s judges the pixel
  CorrelationTile tile_;         // of one pair
  CorrelationScratch scratch_;
  std::vector<float>
      by_depth_;  // as the planes of tile_: derivative of the warped grey value by depth
  // Sums over the pairs in the present tile: of error, mass, and of the error's derivatives by
  // depth.
  std::vector<float> error_, mass_, slope_, curvature_;
};

// Evaluators that are at rest: as many as threads work at once keep their memory between views.
class EvaluatorPool {
 public:
  explicit EvaluatorPool(std::function<std::unique_ptr<ViewEvaluator>()> make)
      : make_(std::move(make)) {}

  std::unique_ptr<ViewEvaluator> Take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (resting_.empty()) return make_();
    std::unique_ptr<ViewEvaluator> evaluator = std::move(resting_.back());
    resting_.pop_back();
    return evaluator;
  }
  void Return(std::unique_ptr<ViewEvaluator> evaluator) {
    const std::lock_guard<std::mutex> lock(mutex_);
    resting_.push_back(std::move(evaluator));
  }

 private:
  std::function<std::unique_ptr<ViewEvaluator>()> make_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ViewEvaluator>> resting_;
};

}  // namespace

class PhotoEvaluation::Impl {
 public:
  Impl(const ImageStore& images, const std::vector<PosedCamera>& views, const TriangleMesh& mesh,
       const std::vector<Eigen::Vector3d>& directions, const FacePairs& pairs,
       const std::vector<uint8_t>& active, const PhotoEnergyOptions& options,
       const RunContext& context)
      : pairs_(pairs),
        cache_(&views, mesh.vertices, mesh.faces, options.map_budget_bytes, true, context),
        order_(WorkOrder(pairs.pairs, views.size())),
        pool_([&] {
          return std::make_unique<ViewEvaluator>(images, views, mesh, directions, pairs, active,
                                                 options, &cache_);
        }) {
    for (const int v : order_) cache_.ExpectUse(v);
    for (const ViewPair& pair : pairs.pairs) cache_.ExpectUse(pair.j);
  }

  size_t num_items() const { return order_.size(); }

  ViewContribution Evaluate(size_t item) {
    std::unique_ptr<ViewEvaluator> evaluator = pool_.Take();
    ViewContribution result = evaluator->Evaluate(order_[item]);
    pool_.Return(std::move(evaluator));
    return result;
  }

  void End(size_t item) {
    const int view_idx = order_[item];
    for (const ViewPair& pair : PairsOfView(pairs_.pairs, view_idx)) cache_.EndUse(pair.j);
    cache_.EndUse(view_idx);
  }

 private:
  const FacePairs& pairs_;
  SurfaceMapCache cache_;
  const std::vector<int> order_;
  EvaluatorPool pool_;
};

PhotoEvaluation::PhotoEvaluation(const ImageStore& images, const std::vector<PosedCamera>& views,
                                 const TriangleMesh& mesh,
                                 const std::vector<Eigen::Vector3d>& directions,
                                 const FacePairs& pairs, const std::vector<uint8_t>& active,
                                 const PhotoEnergyOptions& options, const RunContext& context)
    : impl_(std::make_unique<Impl>(images, views, mesh, directions, pairs, active, options,
                                   context)) {}

PhotoEvaluation::~PhotoEvaluation() = default;
size_t PhotoEvaluation::num_items() const { return impl_->num_items(); }
ViewContribution PhotoEvaluation::Evaluate(size_t item) { return impl_->Evaluate(item); }
void PhotoEvaluation::End(size_t item) { impl_->End(item); }

}  // namespace lsmvs
