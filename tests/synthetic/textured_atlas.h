#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>

#include "lsmvs/image/raster.h"
#include "lsmvs/mesh/textured_mesh.h"

namespace lsmvs {

struct AtlasOptions {
  int page_width = 512, page_height = 512;  // [px]
  int chart_px = 12;  // side of each face's chart: a right triangle of one face
  int gutter_px = 4;  // texels around a chart that continue its colours
  std::string name = "page";
};

// Paints a mesh: each face gets a chart of its own, each texel the colour of its point on the
// face's plane, so that the texture's truth is known everywhere. Writes the pages as PNG into
// `folder` (name + number + ".png").
TexturedMesh PaintAtlas(const TriangleMesh& mesh,
                        const std::function<Color(const Eigen::Vector3d& x_in_world)>& color,
                        const std::filesystem::path& folder, const AtlasOptions& options = {});

}  // namespace lsmvs
