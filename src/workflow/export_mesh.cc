#include "lsmvs/workflow/export_mesh.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "lsmvs/evaluation/viewpoints.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/error.h"
#include "lsmvs/util/valid_options.h"
#include "lsmvs/workflow/files/output_check.h"
#include "lsmvs/workflow/files/scene_input.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

class MeshExport {
 public:
  MeshExport(const MeshExportOptions& options, const CommandContext& context)
      : options_(options), context_(context) {}

  void Run() const {
    CheckOptions();
    context_.console->Begin("Reading");
    const TexturedMesh textured = ReadTexturedPly(options_.input_path);
    if (textured.mesh.faces.empty()) {
      throw InputError(options_.input_path, "has no faces",
                       "clouds cannot be exported; give a mesh");
    }
    context_.console->End();
    context_.console->Begin("Writing");
    CheckOverwrite(OutputFiles(textured));
    Write(textured);
    context_.console->End();
    context_.console->Print(options_.output_path + "\n");
  }

 private:
  void CheckOptions() const {
    RequireValid(options_);
    if (options_.output_type != ExportType::k3dTiles && fs::is_directory(options_.output_path)) {
      throw UsageError("--output_path " + options_.output_path + " is a folder; name a file in it");
    }
    if (options_.output_type == ExportType::k3dTiles && fs::exists(options_.output_path) &&
        !fs::is_directory(options_.output_path)) {
      throw UsageError("--output_path " + options_.output_path +
                       " is a file; 3DTILES go into a folder");
    }
    if (options_.output_type != ExportType::k3dTiles && !options_.origin.empty()) {
      throw UsageError("--origin is for --output_type 3DTILES");
    }
    if (options_.output_type != ExportType::kGlb && options_.compress)
      throw UsageError("--compress is for --output_type GLB");
    Origin();
  }

  std::vector<fs::path> OutputFiles(const TexturedMesh& textured) const {
    switch (options_.output_type) {
      case ExportType::kPly:
        return PlyExportFiles(options_.output_path, textured, options_.encoding);
      case ExportType::kObj:
        return ObjExportFiles(options_.output_path, textured, options_.encoding);
      case ExportType::kGlb:
        return GlbExportFiles(options_.output_path, textured);
      case ExportType::k3dTiles:
        return {fs::path(options_.output_path) / "tileset.json",
                fs::path(options_.output_path) / "tiles"};
    }
    return {};
  }

  void CheckOverwrite(const std::vector<fs::path>& files) const {
    for (const fs::path& file : files) {
      std::error_code ignored;
      if (fs::equivalent(file, options_.input_path, ignored)) {
        throw UsageError("--output_path " + options_.output_path + " is the input itself");
      }
      RefuseToReplace({file}, options_.overwrite);
    }
  }

  void Write(const TexturedMesh& textured) const {
    switch (options_.output_type) {
      case ExportType::kPly:
        return ExportPly(options_.output_path, textured, options_.encoding);
      case ExportType::kObj:
        return ExportObj(options_.output_path, textured, options_.encoding);
      case ExportType::kGlb:
        return ExportGlb(options_.output_path, textured, Directions(textured.mesh),
                         options_.encoding, options_.compress);
      case ExportType::k3dTiles:
        const TilesetSummary summary =
            ExportTileset(options_.output_path, textured, Directions(textured.mesh), Origin(),
                          options_.encoding, options_.tileset, context_.run);
        context_.console->Print(
            fmt::format("{} tiles in {} levels\n", summary.num_tiles, summary.num_levels));
    }
  }

  ExportDirections Directions(const TriangleMesh& mesh) const {
    ExportDirections directions;
    if (!options_.workspace_path.empty()) {
      const Scene scene = LoadSceneToEvaluate(options_.workspace_path, false);
      const TurntableOptions turntable = TurntableBefore(mesh.vertices, scene.views);
      directions = {turntable.up, turntable.front};
    }
    if (!options_.up.empty()) directions.up = ParseDirection("up", options_.up);
    return directions;
  }

  std::optional<GeodeticPosition> Origin() const {
    if (options_.origin.empty()) return std::nullopt;
    GeodeticPosition place;
    char rest = 0;
    const int count = std::sscanf(options_.origin.c_str(), "%lf,%lf,%lf%c", &place.latitude_deg,
                                  &place.longitude_deg, &place.height, &rest);
    if (count == 3 && std::abs(place.latitude_deg) <= 90 && std::abs(place.longitude_deg) <= 180 &&
        std::abs(place.height) <= 1e7) {
      return place;
    }
    throw UsageError(
        fmt::format("--origin '{}' must be latitude, longitude and height such as 48.2,16.37,171",
                    options_.origin));
  }

  const MeshExportOptions& options_;
  const CommandContext& context_;
};

}  // namespace

void MeshExportOptions::Describe(OptionSet* options) {
  options->Add("input_path", &input_path, "Mesh to export (PLY, with or without texture)");
  options->Add("output_path", &output_path, "File to write; of 3DTILES the folder");
  options->AddEnum<ExportType>("output_type", &output_type, "Format to write",
                               {{"PLY", ExportType::kPly},
                                {"OBJ", ExportType::kObj},
                                {"GLB", ExportType::kGlb},
                                {"3DTILES", ExportType::k3dTiles}});
  options->Add("workspace_path", &workspace_path,
               "Workspace whose photos tell which way is up and which side is the front");
  options->Add("up", &up,
               "Direction that is up, as x,y,z; without it that of the photos, or 0,-1,0");
  options->AddEnum<TextureFormat>("texture_format", &encoding.format,
                                  "Format of the textures; keep: as they are, in 3DTILES JPEG",
                                  {{"keep", TextureFormat::kKeep},
                                   {"png", TextureFormat::kPng},
                                   {"jpeg", TextureFormat::kJpeg},
                                   {"webp", TextureFormat::kWebp}});
  options->Add("texture_quality", &encoding.quality, "Quality of JPEG and WebP textures", {1, 100});
  options->Add("compress", &compress,
               "GLB: 16 bits per coordinate and meshopt compression; readers must know "
               "EXT_meshopt_compression, as three.js, Babylon.js and Cesium do");
  options->Add("origin", &origin,
               "3DTILES: place on the Earth of the mesh's origin as latitude,longitude,height "
               "(WGS 84, degrees and metres)");
  tileset.Describe(options);
  options->Add("overwrite", &overwrite, "Replace what is there");
}

bool MeshExportOptions::Check(std::string* error) const {
  return tileset.Check(error) && CheckOptions(*this, error);
}

void ExportMesh(const MeshExportOptions& options, const CommandContext& context) {
  MeshExport(options, context).Run();
}

}  // namespace lsmvs
