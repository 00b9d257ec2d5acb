#include "lsmvs/refinement/photo/pair_selection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "lsmvs/image/face_blocks.h"
#include "lsmvs/refinement/photo/surface_map_cache.h"
#include "lsmvs/refinement/sharing/loop_states.h"
#include "lsmvs/util/shared_loop.h"

namespace lsmvs {

namespace {

constexpr size_t kRegionsPerBlock = 16;
constexpr int kReduction = 4;
// Of the score of pairs that should come last.
constexpr double kUsedFactor = 1e-6;
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

std::vector<PosedCamera> Reduced(const std::vector<PosedCamera>& views) {
  std::vector<PosedCamera> reduced;
  for (const PosedCamera& view : views) {
    reduced.push_back({view.camera.Resized(std::max(2, view.camera.width / kReduction),
                                           std::max(2, view.camera.height / kReduction)),
                       view.cam_from_world});
  }
  return reduced;
}

// What has a region in the picture.
struct Surroundings {
  std::vector<size_t> views, pairs;                          // of all views and candidates
  std::vector<std::shared_ptr<const Raster<float>>> depths;  // as views
};

// How one view sees one face.
struct Sighting {
  bool seen = false;
  double cosine = 0;
  double pixel_size = 0;      // world units a pixel
  double area_px = 0;         // square pixels, at the views' own resolution
  Eigen::Vector3d to_camera;  // unit length
};

class Selector {
 public:
  Selector(const std::vector<PosedCamera>& views, const std::vector<ViewPair>& candidates,
           const TriangleMesh& mesh, const FacePairs* used, const PairSelectionOptions& options,
           const RunContext& context)
      : views_(views),
        candidates_(candidates),
        mesh_(mesh),
        used_(used),
        options_(options),
        coarse_(Reduced(views)),
        depths_(&coarse_, mesh.vertices, mesh.faces, options.map_budget_bytes, false, context) {
    FindReversed();
  }

  // Chooses for the faces of one region; their place in the block is from `place`.
  void SelectFor(std::span<const int32_t> faces, size_t place, BlockPairs* result) {
    const Surroundings near = FindSurroundings(faces);
    std::vector<std::vector<Ranked>> rankings;
    Scratch scratch{std::vector<Sighting>(views_.size()), std::vector<double>(candidates_.size())};
    std::vector<double> totals(candidates_.size(), 0.0);
    for (size_t k = 0; k < faces.size(); ++k) {
      rankings.push_back(
          RankFor(static_cast<size_t>(faces[k]), near, &scratch, &result->area_px[place + k]));
      for (const Ranked& ranked : rankings.back()) {
        totals[static_cast<size_t>(ranked.pair)] += ranked.score;
      }
    }
    if (used_ != nullptr) PutUsedLast(faces, &totals);
    std::vector<Ranked> best;
    for (const size_t p : near.pairs) {
      if (totals[p] > 0) best.push_back({totals[p], static_cast<int>(p), 0});
    }
    KeepBest(static_cast<size_t>(options_.max_pairs_per_face), &best);
    for (size_t k = 0; k < faces.size(); ++k) Assign(place + k, best, &rankings[k], result);
  }

 private:
  struct Ranked {
    double score;
    int pair;
    double pixel_size;
  };

  // Of one face: by view, and by candidate.
  struct Scratch {
    std::vector<Sighting> sightings;
    std::vector<double> scores;
  };

  // A pair and its reverse score alike: the second takes the score of the first.
  void FindReversed() {
    std::map<std::pair<int, int>, int> places;
    for (size_t p = 0; p < candidates_.size(); ++p) {
      const ViewPair& pair = candidates_[p];
      const auto found = places.find({pair.j, pair.i});
      reversed_.push_back(found == places.end() ? -1 : found->second);
      places.emplace(std::pair(pair.i, pair.j), static_cast<int>(p));
    }
  }

  Surroundings FindSurroundings(std::span<const int32_t> faces) {
    Eigen::AlignedBox3d box;
    for (const int32_t face : faces) {
      for (const int v : mesh_.faces[static_cast<size_t>(face)]) {
        box.extend(mesh_.vertices[static_cast<size_t>(v)]);
      }
    }
    Surroundings near;
    std::vector<uint8_t> is_near(views_.size(), 0);
    for (size_t v = 0; v < views_.size(); ++v) {
      if (!MayShow(coarse_[v].camera, coarse_[v].cam_from_world, box)) continue;
      is_near[v] = 1;
      near.views.push_back(v);
      near.depths.push_back(depths_.Depth(static_cast<int>(v)));
    }
    for (size_t p = 0; p < candidates_.size(); ++p) {
      const ViewPair& pair = candidates_[p];
      if (is_near[static_cast<size_t>(pair.i)] && is_near[static_cast<size_t>(pair.j)]) {
        near.pairs.push_back(p);
      }
    }
    return near;
  }

  // Lowers the score of pairs that judge one of the faces already.
  void PutUsedLast(std::span<const int32_t> faces, std::vector<double>* totals) const {
    std::vector<uint8_t> is_used(used_->pairs.size(), 0);
    const size_t per_face = static_cast<size_t>(used_->per_face);
    for (const int32_t face : faces) {
      for (size_t k = 0; k < per_face; ++k) {
        const int32_t pair = used_->of_face[static_cast<size_t>(face) * per_face + k];
        if (pair >= 0) is_used[static_cast<size_t>(pair)] = 1;
      }
    }
    for (size_t u = 0; u < is_used.size(); ++u) {
      if (!is_used[u]) continue;
      const ViewPair& used = used_->pairs[u];
      for (size_t p = 0; p < candidates_.size(); ++p) {
        const ViewPair& pair = candidates_[p];
        if ((pair.i == used.i && pair.j == used.j) || (pair.i == used.j && pair.j == used.i)) {
          (*totals)[p] = std::min((*totals)[p], kUsedFactor * (*totals)[p]);
        }
      }
    }
  }

  static void KeepBest(size_t count, std::vector<Ranked>* ranked) {
    std::sort(ranked->begin(), ranked->end(), [](const Ranked& a, const Ranked& b) {
      return a.score != b.score ? a.score > b.score : a.pair < b.pair;
    });
    if (ranked->size() > count) ranked->resize(count);
  }

  Sighting Look(size_t v, const Raster<float>& depth, const Eigen::Vector3d& center,
                const Eigen::Vector3d& normal_area) const {
    Sighting sighting;
    const PosedCamera& view = views_[v];
    const Eigen::Vector3d x = view.cam_from_world * center;
    if (x.z() <= 0) return sighting;
    const PinholeCamera& coarse = coarse_[v].camera;
    const Eigen::Vector2d x_px = coarse.Project(x);
    if (!coarse.Contains(x_px)) return sighting;
    const Eigen::Vector3d n = view.cam_from_world.rotation * normal_area;
    const double twice_area = n.norm();
    sighting.cosine = -n.dot(x) / std::max(twice_area * x.norm(), 1e-300);
    if (!(sighting.cosine > options_.min_cosine)) return sighting;
    if (Hidden(depth, x_px, x.z())) return sighting;
    sighting.seen = true;
    sighting.pixel_size = x.z() / view.camera.MeanFocalLength();
    sighting.area_px = 0.5 * twice_area * sighting.cosine * x.norm() / x.z() /
                       (sighting.pixel_size * sighting.pixel_size);
    sighting.to_camera = -(view.cam_from_world.rotation.transpose() * x).normalized();
    return sighting;
  }

  // Whether all coarse pixels around are nearer: the map is coarse, a face at an edge should not be
  // lost.
  bool Hidden(const Raster<float>& map, const Eigen::Vector2d& x_px, double depth) const {
    const int column = std::clamp(static_cast<int>(x_px.x() - 0.5), 0, map.width - 2);
    const int row = std::clamp(static_cast<int>(x_px.y() - 0.5), 0, map.height - 2);
    const double limit = depth * (1.0 - options_.depth_tolerance);
    for (int k = 0; k < 4; ++k) {
      const float z = map(column + k % 2, row + k / 2);
      if (z == 0 || z >= limit) return false;
    }
    return true;
  }

  double Score(const Sighting& a, const Sighting& b) const {
    const double angle = std::acos(std::clamp(a.to_camera.dot(b.to_camera), -1.0, 1.0));
    if (angle < options_.min_angle_deg * kRadiansPerDegree) return 0;
    if (angle > options_.max_angle_deg * kRadiansPerDegree) return 0;
    const double best = options_.best_angle_deg * kRadiansPerDegree;
    const double parallax = std::min(angle / best, best / angle);
    return parallax * std::sqrt(std::min(a.area_px, b.area_px)) * std::min(a.cosine, b.cosine);
  }

  // The pairs that see a face; notes its area.
  std::vector<Ranked> RankFor(size_t face, const Surroundings& near, Scratch* scratch,
                              float* area_px) const {
    const Eigen::Vector3i& f = mesh_.faces[face];
    const Eigen::Vector3d center =
        (mesh_.vertices[f[0]] + mesh_.vertices[f[1]] + mesh_.vertices[f[2]]) / 3.0;
    const Eigen::Vector3d normal_area = FaceNormalTimesTwiceArea(mesh_, face);
    std::vector<Sighting>& sightings = scratch->sightings;
    for (size_t k = 0; k < near.views.size(); ++k) {
      const size_t v = near.views[k];
      sightings[v] = Look(v, *near.depths[k], center, normal_area);
    }
    std::vector<Ranked> ranked;
    double best_area = 0;
    for (const size_t p : near.pairs) {
      const Sighting& a = sightings[static_cast<size_t>(candidates_[p].i)];
      const Sighting& b = sightings[static_cast<size_t>(candidates_[p].j)];
      if (!a.seen || !b.seen) continue;
      const int reversed = reversed_[p];
      const double score =
          reversed < 0 ? Score(a, b) : scratch->scores[static_cast<size_t>(reversed)];
      scratch->scores[p] = score;
      if (score <= 0) continue;
      ranked.push_back({score, static_cast<int>(p), 0.5 * (a.pixel_size + b.pixel_size)});
      best_area = std::max(best_area, std::min(a.area_px, b.area_px));
    }
    *area_px = static_cast<float>(best_area);
    return ranked;
  }

  // Of `best`, those that are also in `own`; the best of `own` if there is none.
  void Assign(size_t place, const std::vector<Ranked>& best, std::vector<Ranked>* own,
              BlockPairs* result) const {
    if (own->empty()) return;
    int32_t* slots = &result->of_face[place * static_cast<size_t>(options_.max_pairs_per_face)];
    int count = 0;
    double pixel_size = 0;
    for (const Ranked& candidate : best) {
      for (const Ranked& ranked : *own) {
        if (ranked.pair != candidate.pair) continue;
        slots[count++] = ranked.pair;
        pixel_size += ranked.pixel_size;
      }
    }
    if (count == 0) {
      KeepBest(1, own);
      slots[count++] = own->front().pair;
      pixel_size = own->front().pixel_size;
    }
    result->pixel_size[place] = static_cast<float>(pixel_size / count);
  }

  const std::vector<PosedCamera>& views_;
  const std::vector<ViewPair>& candidates_;
  const TriangleMesh& mesh_;
  const FacePairs* used_;  // or null
  const PairSelectionOptions& options_;
  std::vector<int> reversed_;  // by candidate: an earlier one of the same views, or -1
  const std::vector<PosedCamera> coarse_;
  SurfaceMapCache depths_;  // of coarse_
};

}  // namespace

std::span<const ViewPair> PairsOfView(std::span<const ViewPair> pairs, int i) {
  const auto first = std::lower_bound(pairs.begin(), pairs.end(), i,
                                      [](const ViewPair& pair, int v) { return pair.i < v; });
  const auto end =
      std::find_if(first, pairs.end(), [i](const ViewPair& pair) { return pair.i != i; });
  return pairs.subspan(static_cast<size_t>(first - pairs.begin()),
                       static_cast<size_t>(end - first));
}

class PairSelection::Impl {
 public:
  Impl(const std::vector<PosedCamera>& views, const std::vector<ViewPair>& candidates,
       const TriangleMesh& mesh, const FaceRegions& regions, const FacePairs* used,
       const PairSelectionOptions& options, const RunContext& context)
      : per_face_(static_cast<size_t>(options.max_pairs_per_face)),
        begins_(static_cast<size_t>(regions.count) + 1, 0),
        faces_(mesh.faces.size()),
        selector_(views, candidates, mesh, used, options, context) {
    for (const int32_t region : regions.of_face) ++begins_[static_cast<size_t>(region) + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    std::vector<size_t> next(begins_.begin(), begins_.end() - 1);
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      faces_[next[static_cast<size_t>(regions.of_face[f])]++] = static_cast<int32_t>(f);
    }
  }

  size_t num_items() const {
    return (begins_.size() - 1 + kRegionsPerBlock - 1) / kRegionsPerBlock;
  }

  BlockPairs Select(size_t item) {
    const std::span<const int32_t> faces = FacesOf(item);
    BlockPairs block{std::vector<int32_t>(faces.size() * per_face_, -1),
                     std::vector<float>(faces.size(), 0.0f),
                     std::vector<float>(faces.size(), 0.0f)};
    for (size_t r = FirstRegion(item); r < FirstRegion(item + 1); ++r) {
      const size_t place = begins_[r] - begins_[FirstRegion(item)];
      selector_.SelectFor(faces.subspan(place, begins_[r + 1] - begins_[r]), place, &block);
    }
    return block;
  }

  void Store(size_t item, const BlockPairs& block, FacePairs* result) const {
    const std::span<const int32_t> faces = FacesOf(item);
    for (size_t k = 0; k < faces.size(); ++k) {
      const auto face = static_cast<size_t>(faces[k]);
      std::copy_n(&block.of_face.at(k * per_face_), per_face_, &result->of_face[face * per_face_]);
      result->pixel_size[face] = block.pixel_size.at(k);
      result->area_px[face] = block.area_px.at(k);
    }
  }

 private:
  size_t FirstRegion(size_t item) const {
    return std::min(item * kRegionsPerBlock, begins_.size() - 1);
  }
  std::span<const int32_t> FacesOf(size_t item) const {
    const size_t begin = begins_[FirstRegion(item)], end = begins_[FirstRegion(item + 1)];
    return std::span(faces_).subspan(begin, end - begin);
  }

  const size_t per_face_;
  // Faces by regions: those of region r are faces_[begins_[r] .. begins_[r + 1]).
  std::vector<size_t> begins_;
  std::vector<int32_t> faces_;
  Selector selector_;
};

PairSelection::PairSelection(const std::vector<PosedCamera>& views,
                             const std::vector<ViewPair>& candidates, const TriangleMesh& mesh,
                             const FaceRegions& regions, const FacePairs* used,
                             const PairSelectionOptions& options, const RunContext& context)
    : impl_(std::make_unique<Impl>(views, candidates, mesh, regions, used, options, context)) {}

PairSelection::~PairSelection() = default;
size_t PairSelection::num_items() const { return impl_->num_items(); }
BlockPairs PairSelection::Select(size_t item) { return impl_->Select(item); }
void PairSelection::Store(size_t item, const BlockPairs& block, FacePairs* result) const {
  impl_->Store(item, block, result);
}

namespace {

FacePairs Select(const std::vector<PosedCamera>& views, const std::vector<ViewPair>& candidates,
                 const TriangleMesh& mesh, const FaceRegions& regions, const FacePairs* used,
                 const PairSelectionOptions& options, const RunContext& context) {
  FacePairs result;
  result.pairs = candidates;
  result.per_face = options.max_pairs_per_face;
  result.of_face.assign(mesh.faces.size() * static_cast<size_t>(result.per_face), -1);
  result.pixel_size.assign(mesh.faces.size(), 0.0f);
  result.area_px.assign(mesh.faces.size(), 0.0f);
  PairSelection selection(views, candidates, mesh, regions, used, options, context);
  SharedLoop loop;
  loop.kind = kPairSelectionLoop;
  loop.count = selection.num_items();
  loop.states = [&] {
    return PairSelectionStates(views, candidates, mesh, regions, used, options);
  };
  loop.compute = [&](size_t item, const std::function<bool()>& is_first) {
    const BlockPairs block = selection.Select(item);
    if (is_first()) selection.Store(item, block, &result);
  };
  loop.keep = [&](size_t item, std::string_view bytes) {
    selection.Store(item, DecodeBlockPairs(bytes), &result);
  };
  RunSharedLoop(loop, context);
  return result;
}

}  // namespace

FacePairs SelectFacePairs(const std::vector<PosedCamera>& views,
                          const std::vector<ViewPair>& candidates, const TriangleMesh& mesh,
                          const FaceRegions& regions, const PairSelectionOptions& options,
                          const RunContext& context) {
  return Select(views, candidates, mesh, regions, nullptr, options, context);
}

FacePairs SelectOtherFacePairs(const std::vector<PosedCamera>& views,
                               const std::vector<ViewPair>& candidates, const TriangleMesh& mesh,
                               const FaceRegions& regions, const FacePairs& used,
                               const PairSelectionOptions& options, const RunContext& context) {
  return Select(views, candidates, mesh, regions, &used, options, context);
}

}  // namespace lsmvs
