#include "lsmvs/mesh/undo_collisions.h"

#include <algorithm>
#include <optional>

#include "lsmvs/mesh/self_intersections.h"

namespace lsmvs {

size_t UndoCollisions(std::span<const Eigen::Vector3i> faces,
                      const std::vector<Eigen::Vector3d>& before,
                      std::vector<Eigen::Vector3d>* after, const RunContext& context,
                      bool has_long_steps) {
  size_t num_undone = 0;
  std::vector<uint8_t> has_moved(before.size());
  for (size_t v = 0; v < before.size(); ++v) has_moved[v] = before[v] != (*after)[v];
  const auto touches = [&](const Eigen::Vector3i& f, const std::vector<uint8_t>& mark) {
    return mark[static_cast<size_t>(f[0])] || mark[static_cast<size_t>(f[1])] ||
           mark[static_cast<size_t>(f[2])];
  };
  std::vector<uint8_t> changed = has_moved, moved(faces.size());
  std::optional<FaceGrid> grid;
  // Each pass takes back at least one vertex.
  for (bool any = true; any;) {
    context.ThrowIfCancelled();
    for (size_t f = 0; f < faces.size(); ++f) moved[f] = touches(faces[f], changed);
    if (has_long_steps) {
      grid.emplace(*after, faces);
    } else if (!grid) {
      grid.emplace(*after, faces, before);
    }
    const auto pairs = grid->CrossingPairs(moved, context);
    std::fill(changed.begin(), changed.end(), uint8_t{0});
    any = false;
    for (const auto& [a, b] : pairs) {
      const Eigen::Vector3i &face_a = faces[static_cast<size_t>(a)],
                            &face_b = faces[static_cast<size_t>(b)];
      if (FacesCross(before, face_a, face_b)) continue;
      for (const Eigen::Vector3i& face : {face_a, face_b}) {
        for (const int v : face) {
          const size_t vertex = static_cast<size_t>(v);
          if (!has_moved[vertex]) continue;
          (*after)[vertex] = before[vertex];
          has_moved[vertex] = 0;
          changed[vertex] = 1;
          any = true;
          ++num_undone;
        }
      }
    }
  }
  return num_undone;
}

}  // namespace lsmvs
