#include "lsmvs/texturing/labels/guests.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "lsmvs/util/disjoint_sets.h"

namespace lsmvs {

namespace {

constexpr double kMaxUnseenArea_px = 64, kMaxSeenArea_px = 4;
constexpr double kMaxFace_px = 8;

struct Region {
  double area = 0;                    // world units
  std::map<int32_t, double> borders;  // world length beside other views
  double density_sum = 0;             // of the faces across the border
  int num_borders = 0;
  std::vector<uint32_t> faces;
};

class GuestFinder {
 public:
  GuestFinder(const Scene& scene, const LabelEnergy& energy, const std::vector<int32_t>& views)
      : scene_(scene), energy_(energy), mesh_(energy.mesh()), views_(views) {}

  std::vector<int32_t> Run() const {
    std::vector<int32_t> guest_of(views_.size(), -1);
    for (const Region& region : FindRegions()) {
      const int32_t host = HostOf(region);
      for (const uint32_t f : region.faces) guest_of[f] = host;
    }
    return guest_of;
  }

 private:
  // Connected faces of the same view that could be small enough.
  std::vector<Region> FindRegions() const {
    DisjointSets sets(views_.size());
    for (uint32_t f = 0; f < views_.size(); ++f) {
      for (const int32_t other : energy_.neighbors()[f]) {
        if (other >= 0 && views_[f] == views_[static_cast<size_t>(other)]) {
          sets.Unite(f, static_cast<uint32_t>(other));
        }
      }
    }
    std::vector<double> area_px(views_.size(), 0.0);
    for (uint32_t f = 0; f < views_.size(); ++f) area_px[sets.Find(f)] += energy_.AreaPx(f);
    std::map<uint32_t, Region> by_root;
    for (uint32_t f = 0; f < views_.size(); ++f) {
      const uint32_t root = sets.Find(f);
      if (views_[f] >= 0 && area_px[root] >= kMaxSeenArea_px) continue;
      AddFace(f, &by_root[root]);
    }
    std::vector<Region> regions;
    for (auto& [root, region] : by_root) regions.push_back(std::move(region));
    return regions;
  }

  void AddFace(uint32_t f, Region* region) const {
    region->faces.push_back(f);
    region->area += 0.5 * FaceNormalTimesTwiceArea(mesh_, f).norm();
    for (int side = 0; side < 3; ++side) {
      const int32_t other = energy_.neighbors()[f][static_cast<size_t>(side)];
      if (other < 0) continue;
      const int32_t view = views_[static_cast<size_t>(other)];
      if (view < 0 || view == views_[f]) continue;
      const Eigen::Vector3i& face = mesh_.faces[f];
      region->borders[view] +=
          (mesh_.vertices[face[(side + 1) % 3]] - mesh_.vertices[face[side]]).norm();
      region->density_sum += energy_.candidates().density(static_cast<size_t>(other));
      ++region->num_borders;
    }
  }

  // -1: none.
  int32_t HostOf(const Region& region) const {
    if (region.num_borders == 0) return -1;
    const double density = region.density_sum / region.num_borders;
    const bool is_seen = views_[region.faces.front()] >= 0;
    const double most = is_seen ? kMaxSeenArea_px : kMaxUnseenArea_px;
    if (region.area * density * density >= most) return -1;
    const auto longest =
        std::max_element(region.borders.begin(), region.borders.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    const View& view = scene_.views[static_cast<size_t>(longest->first)];
    const bool fits = std::all_of(region.faces.begin(), region.faces.end(),
                                  [&](uint32_t f) { return Fits(f, view); });
    return fits ? longest->first : -1;
  }

  bool Fits(uint32_t f, const View& view) const {
    Eigen::AlignedBox2d box;
    for (const int v : mesh_.faces[f]) {
      const Eigen::Vector3d x = view.cam_from_world * mesh_.vertices[v];
      if (!(x.z() > 0)) return false;
      const Eigen::Vector2d x_px = view.camera.Project(x);
      if (!view.camera.Contains(x_px)) return false;
      box.extend(x_px);
    }
    return box.sizes().maxCoeff() <= kMaxFace_px;
  }

  const Scene& scene_;
  const LabelEnergy& energy_;
  const TriangleMesh& mesh_;
  const std::vector<int32_t>& views_;
};

}  // namespace

std::vector<int32_t> FindGuests(const Scene& scene, const LabelEnergy& energy,
                                std::vector<int32_t>* views) {
  std::vector<int32_t> guest_of = GuestFinder(scene, energy, *views).Run();
  for (size_t f = 0; f < guest_of.size(); ++f) {
    if (guest_of[f] >= 0) (*views)[f] = -1;
  }
  return guest_of;
}

}  // namespace lsmvs
