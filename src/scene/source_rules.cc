#include "lsmvs/scene/source_rules.h"

#include <algorithm>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

bool Contains(const std::vector<Neighbor>& neighbors, int view_idx) {
  return std::any_of(neighbors.begin(), neighbors.end(),
                     [&](const Neighbor& n) { return n.view_idx == view_idx; });
}

// Best first: 1, 1/2, 1/3, ...
std::vector<Neighbor> Listed(const std::vector<int>& view_idxs, int reference_idx) {
  std::vector<Neighbor> neighbors;
  for (const int view_idx : view_idxs) {
    if (view_idx == reference_idx || Contains(neighbors, view_idx)) continue;
    neighbors.push_back({view_idx, 1.0 / static_cast<double>(neighbors.size() + 1), 0.0, 0});
  }
  return neighbors;
}

// All other views, nearest first.
std::vector<int> ByDistance(const Scene& scene, int view_idx) {
  std::vector<std::pair<double, int>> views;
  const Eigen::Vector3d center = scene.views[static_cast<size_t>(view_idx)].CenterInWorld();
  for (int v = 0; v < scene.num_views(); ++v) {
    const double distance =
        (scene.views[static_cast<size_t>(v)].CenterInWorld() - center).squaredNorm();
    if (v != view_idx && distance > 0) views.emplace_back(distance, v);
  }
  std::sort(views.begin(), views.end());
  std::vector<int> view_idxs;
  for (const auto& [distance, v] : views) view_idxs.push_back(v);
  return view_idxs;
}

std::vector<Neighbor> All(const Scene& scene, int view_idx, const std::vector<Neighbor>& best) {
  std::vector<int> view_idxs;
  for (const Neighbor& neighbor : best) view_idxs.push_back(neighbor.view_idx);
  for (const int v : ByDistance(scene, view_idx)) view_idxs.push_back(v);
  return Listed(view_idxs, view_idx);
}

std::vector<Neighbor> Apply(const Scene& scene, const SourceRule& rule, int view_idx,
                            std::vector<Neighbor> best) {
  switch (rule.kind) {
    case SourceRule::Kind::kAll:
      return All(scene, view_idx, best);
    case SourceRule::Kind::kListed:
      return Listed(rule.view_idxs, view_idx);
    case SourceRule::Kind::kNone:
      return {};
    case SourceRule::Kind::kBest:
      break;
  }
  if (rule.max_count > 0 && static_cast<int>(best.size()) > rule.max_count) {
    best.resize(static_cast<size_t>(rule.max_count));
  }
  return best;
}

}  // namespace

bool ChangeNothing(const std::vector<SourceRule>& rules, int max_num_neighbors) {
  return std::all_of(rules.begin(), rules.end(), [&](const SourceRule& rule) {
    return rule.kind == SourceRule::Kind::kBest &&
           (rule.max_count == 0 || rule.max_count >= max_num_neighbors);
  });
}

void ApplySourceRules(const Scene& scene, const std::vector<SourceRule>& rules,
                      std::vector<std::vector<Neighbor>>* neighbors) {
  LSMVS_CHECK(rules.empty() || rules.size() == scene.views.size());
  for (size_t v = 0; v < neighbors->size(); ++v) {
    std::vector<Neighbor>& list = (*neighbors)[v];
    if (!rules.empty()) list = Apply(scene, rules[v], static_cast<int>(v), std::move(list));
    if (!scene.views[v].has_photo) list.clear();
    std::erase_if(list, [&](const Neighbor& n) {
      return !scene.views[static_cast<size_t>(n.view_idx)].has_photo;
    });
  }
}

}  // namespace lsmvs
