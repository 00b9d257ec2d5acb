#include "lsmvs/workflow/stage_options.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "lsmvs/colmap_adapter/scene_keypoints.h"
#include "lsmvs/util/error.h"

namespace lsmvs {

namespace fs = std::filesystem;

void StageOptions::DescribeWorkspace(OptionSet* options) {
  options->Add("workspace_path", &workspace_path,
               "Dense workspace: the folder that `colmap image_undistorter` wrote, with images/ "
               "and sparse/.");
  options->AddEnum("workspace_format", &format, "Format of the workspace.",
                   {{"COLMAP", DenseFormat::kColmap}});
  options->MarkRare({"workspace_format"});
}

void StageOptions::DescribeMaskPath(OptionSet* options) {
  options->Add("mask_path", &mask_path,
               "Folder with masks: of image a/b.jpg it is a/b.jpg.png or a/b.png; black pixels are "
               "not used. Images without a mask are used whole.");
}

void StageOptions::DescribeAlphaMask(OptionSet* options) {
  options->Add("alpha_mask", &alpha_is_mask,
               "Whether pixels that are transparent (alpha 0) count as masked in photos with an "
               "alpha channel.");
  options->MarkRare({"alpha_mask"});
}

void StageOptions::DescribeSkipMissingImages(OptionSet* options) {
  options->Add("skip_missing_images", &skip_missing_images,
               "Go on without photos of the model that are missing; without it the run stops.");
  options->MarkRare({"skip_missing_images"});
}

void StageOptions::DescribeSourcesPath(OptionSet* options) {
  options->Add("config_path", &sources_path,
               "File that lists the source photos of each photo, as COLMAP's patch-match.cfg; "
               "without it stereo/patch-match.cfg, if it is there.");
}

void StageOptions::DescribeBoxPath(OptionSet* options) {
  options->Add("bbox_path", &box_path,
               "As --bounding_box, from a text file as COLMAP's: xmin ymin zmin, xmax ymax zmax.");
}

void StageOptions::DescribeDatabasePath(OptionSet* options) {
  options->Add(
      "database_path", &database_path,
      "COLMAP's database, whose features quasi-dense matching takes besides its own interest "
      "points if they are of these photos; without it the database.db of the workspace or "
      "of its project, if there is one; the word none: no database.");
  options->MarkRare({"database_path"});
}

void StageOptions::DescribeBoundingBox(OptionSet* options) {
  options->Add("bounding_box", &bounding_box,
               "Region of interest xmin,ymin,zmin,xmax,ymax,zmax in the coordinates of the sparse "
               "model; points outside are "
               "dropped.");
}

void StageOptions::DescribeMaxImageSize(const std::string& name, OptionSet* options) {
  options->Add(name, &max_image_size,
               "Longer side in pixels to which photos are reduced; -1 takes them as they are. Time "
               "and memory go with its "
               "square.",
               {-1, 1000000});
}

void StageOptions::DescribeRun(OptionSet* options) {
  options->Add("overwrite", &overwrite,
               "Replace files that are there and were not made by this program. Without it they "
               "are used, or the run "
               "stops.");
  options->Add("ignore_disk_space", &ignore_disk_space,
               "Start even if the results are not expected to fit on the disk.");
  options->MarkRare({"ignore_disk_space"});
  engine.Describe(options);
}

void StageOptions::DescribeScratch(OptionSet* options) {
  options->Add(
      "scratch_path", &scratch_path,
      "Folder for the scratch file of a stage that does not fit into --max_memory, and for the "
      "finished steps of a surface, from which a run that was killed goes on; without it lsmvs/ "
      "of the workspace. It should lie on a fast local disk.");
  options->Add(
      "num_parts", &num_parts,
      "Work on the surface as if memory held only one of this many parts of it. The result is "
      "the same.",
      {1, 4096});
  options->MarkRare({"scratch_path", "num_parts"});
}

void StageOptions::DescribeMeshStage(OptionSet* options) {
  DescribeMaskPath(options);
  DescribeAlphaMask(options);
  DescribeSkipMissingImages(options);
  DescribeMaxImageSize("max_image_size", options);
  DescribeRun(options);
  DescribeScratch(options);
}

void StageOptions::DescribeMaps(bool keep, OptionSet* options) {
  keep_photometric_maps = keep;
  options->Add("keep_photometric_maps", &keep_photometric_maps,
               "Keep the maps of the photometric pass, a fifth of all maps. Without it each is "
               "removed once the geometric maps of its photo and of all that it is compared with "
               "are done; fusion takes the geometric ones.");
  options->AddEnum("map_format", &map_precision,
                   "How depth and normal maps are written: colmap, 16 bytes per pixel, which "
                   "COLMAP reads, too; compact, 1.2 to 2, within a 40th of a pixel's size of the "
                   "depth and a third of a degree. Either is read (see map_converter).",
                   {{"colmap", MapPrecision::kExact}, {"compact", MapPrecision::kCompact}});
  options->MarkRare({"keep_photometric_maps", "map_format"});
}

void StageOptions::Apply(ReconstructionOptions* options) const {
  options->max_image_size = std::max(0, max_image_size);
  options->keep_photometric_maps = keep_photometric_maps;
  options->map_precision = map_precision;
  options->bounding_box = bounding_box;
  if (box_path.empty()) return;
  if (!bounding_box.isEmpty())
    throw UsageError("--bounding_box and --bbox_path are the same; give one");
  std::ifstream file(box_path);
  if (!file) throw InputError(box_path, "cannot be opened", "correct --bbox_path");
  std::ostringstream text;
  text << file.rdbuf();
  std::string box = text.str();
  std::replace_if(
      box.begin(), box.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  options->bounding_box = ParseBox("bbox_path", box);
}

fs::path StageOptions::Database(const DenseWorkspace& workspace) const {
  if (database_path == "none") return {};
  return database_path.empty() ? FindDatabase(workspace) : fs::path(database_path);
}

}  // namespace lsmvs
