#include "lsmvs/exporting/mesh_exporter.h"
#include "lsmvs/evaluation/viewpoints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "lsmvs/cli/commands/commands.h"
#include "lsmvs/cli/commands/evaluation_input.h"
#include "lsmvs/cli/output_check.h"
#include "lsmvs/exporting/tileset_exporter.h"
#include "lsmvs/mesh/textured_ply.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace {

namespace fs = std::filesystem;

enum class OutputType { kPly, kObj, kGlb, k3dTiles };

class MeshExporter : public Command {
 public:
  CommandInfo Info() const override {
    CommandInfo info;
    info.name = "mesh_exporter";
    info.summary = "Mesh with texture or vertex colours -> PLY, OBJ, GLB or 3D Tiles";
    info.details =
        "PLY: the dialect of COLMAP's mesh_texturer, MeshLab and OpenMVS. OBJ: with MTL. GLB: one "
        "file with everything in it, y up. Pages of the texture are written beside the output as "
        "<name>_<number>, unless they lie there already.\n"
        "OBJ and GLB have single precision: where coordinates are large an offset is subtracted "
        "and written to <name>.offset.txt.\n"
        "3DTILES: --output_path is a folder; it gets tileset.json and tiles/*.glb, version 1.1, "
        "with levels of detail, for Cesium and 3d-tiles-renderer. z is up; with --origin the "
        "mesh's coordinates are metres east, north and up of that place, and the tileset lies "
        "there on the Earth.";
    info.examples = {
        "lsmvs mesh_exporter --input_path dense/textured/mesh.ply --output_path model.glb "
        "--output_type GLB --workspace_path dense",
        "lsmvs mesh_exporter --input_path meshed-refined.ply --output_path model.obj "
        "--output_type OBJ",
        "lsmvs mesh_exporter --input_path dense/textured/mesh.ply --output_path tiles "
        "--output_type 3DTILES --workspace_path dense"};
    info.required = {"input_path", "output_path", "output_type"};
    return info;
  }

  void Describe(OptionSet* options) override {
    options->Add("input_path", &input_path_, "Mesh to export (PLY, with or without texture)");
    options->Add("output_path", &output_path_, "File to write; of 3DTILES the folder");
    options->AddEnum<OutputType>("output_type", &type_, "What to write",
                                 {{"PLY", OutputType::kPly},
                                  {"OBJ", OutputType::kObj},
                                  {"GLB", OutputType::kGlb},
                                  {"3DTILES", OutputType::k3dTiles}});
    options->Add("workspace_path", &workspace_path_,
                 "Workspace whose photos tell what is up and in front");
    options->Add("up", &up_, "What is up as x,y,z; empty: up in the photos, or 0,-1,0");
    options->AddEnum<TextureFormat>("texture_format", &encoding_.format,
                                    "Format of the textures; keep: as they are, in 3DTILES JPEG",
                                    {{"keep", TextureFormat::kKeep},
                                     {"png", TextureFormat::kPng},
                                     {"jpeg", TextureFormat::kJpeg},
                                     {"webp", TextureFormat::kWebp}});
    options->Add("texture_quality", &encoding_.quality, "Of JPEG and WebP", {1, 100});
    options->Add("compress", &compress_,
                 "GLB: 16 bits per coordinate and meshopt compression; readers must know "
                 "EXT_meshopt_compression, as three.js, Babylon.js and Cesium do");
    options->Add("origin", &origin_,
                 "3DTILES: place on the Earth of the mesh's origin as latitude,longitude,height "
                 "(WGS 84, degrees and metres)");
    tileset_.Describe(options);
    options->Add("overwrite", &overwrite_, "Replace what is there");
  }

  void Run(const CommandContext& context) override {
    CheckOptions();
    context.console->Begin("Reading");
    const TexturedMesh textured = ReadTexturedPly(input_path_);
    if (textured.mesh.faces.empty()) {
      throw InputError(input_path_, "has no faces", "clouds cannot be exported; give a mesh");
    }
    context.console->End();
    context.console->Begin("Writing");
    CheckOverwrite(OutputFiles(textured));
    Write(textured, context.run);
    context.console->End();
    fmt::print("{}\n", output_path_);
  }

 private:
  void CheckOptions() const {
    std::string error;
    if (!tileset_.Check(&error)) throw UsageError("--" + error);
    if (type_ != OutputType::k3dTiles && fs::is_directory(output_path_)) {
      throw UsageError("--output_path " + output_path_ + " is a folder; name a file in it");
    }
    if (type_ == OutputType::k3dTiles && fs::exists(output_path_) &&
        !fs::is_directory(output_path_)) {
      throw UsageError("--output_path " + output_path_ + " is a file; 3DTILES go into a folder");
    }
    if (type_ != OutputType::k3dTiles && !origin_.empty()) {
      throw UsageError("--origin is for --output_type 3DTILES");
    }
    if (type_ != OutputType::kGlb && compress_)
      throw UsageError("--compress is for --output_type GLB");
    Origin();
  }

  std::vector<fs::path> OutputFiles(const TexturedMesh& textured) const {
    switch (type_) {
      case OutputType::kPly:
        return PlyExportFiles(output_path_, textured, encoding_);
      case OutputType::kObj:
        return ObjExportFiles(output_path_, textured, encoding_);
      case OutputType::kGlb:
        return GlbExportFiles(output_path_, textured);
      case OutputType::k3dTiles:
        return {fs::path(output_path_) / "tileset.json", fs::path(output_path_) / "tiles"};
    }
    return {};
  }

  void CheckOverwrite(const std::vector<fs::path>& files) const {
    for (const fs::path& file : files) {
      std::error_code ignored;
      if (fs::equivalent(file, input_path_, ignored)) {
        throw UsageError("--output_path " + output_path_ + " is the input itself");
      }
      RefuseToReplace({file}, overwrite_);
    }
  }

  void Write(const TexturedMesh& textured, const RunContext& run) const {
    switch (type_) {
      case OutputType::kPly:
        return ExportPly(output_path_, textured, encoding_);
      case OutputType::kObj:
        return ExportObj(output_path_, textured, encoding_);
      case OutputType::kGlb:
        return ExportGlb(output_path_, textured, Directions(textured.mesh), encoding_, compress_);
      case OutputType::k3dTiles:
        const TilesetSummary summary = ExportTileset(
            output_path_, textured, Directions(textured.mesh), Origin(), encoding_, tileset_, run);
        fmt::print("{} tiles in {} levels\n", summary.num_tiles, summary.num_levels);
    }
  }

  ExportDirections Directions(const TriangleMesh& mesh) const {
    ExportDirections directions;
    if (!workspace_path_.empty()) {
      const Scene scene = LoadSceneToEvaluate(workspace_path_, false);
      const TurntableOptions turntable = TurntableBefore(mesh.vertices, scene.views);
      directions = {turntable.up, turntable.front};
    }
    if (!up_.empty()) directions.up = ParseDirection("up", up_);
    return directions;
  }

  std::optional<GeodeticPosition> Origin() const {
    if (origin_.empty()) return std::nullopt;
    GeodeticPosition place;
    char rest = 0;
    const int count = std::sscanf(origin_.c_str(), "%lf,%lf,%lf%c", &place.latitude_deg,
                                  &place.longitude_deg, &place.height, &rest);
    if (count == 3 && std::abs(place.latitude_deg) <= 90 && std::abs(place.longitude_deg) <= 180 &&
        std::abs(place.height) <= 1e7) {
      return place;
    }
    throw UsageError(fmt::format(
        "--origin '{}' must be latitude, longitude and height such as 48.2,16.37,171", origin_));
  }

  std::string input_path_, output_path_, workspace_path_, up_, origin_;
  OutputType type_ = OutputType::kGlb;
  TextureEncoding encoding_;
  TilesetOptions tileset_;
  bool overwrite_ = false, compress_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeMeshExporter() { return std::make_unique<MeshExporter>(); }

}  // namespace lsmvs
