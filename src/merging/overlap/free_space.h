#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lsmvs/merging/overlap/mesh_band.h"
#include "lsmvs/scene/scene.h"
#include "lsmvs/util/run_context.h"

namespace lsmvs {

// Calls visit(view_idx) for each view that sees a vertex.
using VisitViews =
    std::function<void(const VertexSource& source, const std::function<void(uint32_t)>& visit)>;

// Vertices (#V) of a mesh that stand in space that the views of another mesh saw empty: two views
// or more see the other mesh at least `margin` behind them. A view sees a face if it sees one of
// its vertices. Depth maps of the other mesh are drawn at a width and height of up to 1,000 pixels,
// one view after the other.
std::vector<uint8_t> FindVerticesInFreeSpace(const TriangleMesh& mesh, const SourcedMesh& other,
                                             const std::vector<View>& views,
                                             const VisitViews& visit_views, double margin,
                                             const RunContext& context);

}  // namespace lsmvs
