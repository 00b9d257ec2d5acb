#include "lsmvs/colmap_adapter/option_synonyms.h"

namespace lsmvs {

const OptionSynonyms& ColmapSynonyms() {
  static const OptionSynonyms synonyms = {
      .names =
          {{"random_seed", "seed"},
           {"default_random_seed", "seed"},
           {"PatchMatchStereo.num_threads", "num_threads"},
           {"PatchMatchStereo.min_triangulation_angle", "ViewSelection.min_triangulation_angle"},
           {"PatchMatchStereo.allow_missing_files", "skip_missing_images"},
           {"StereoFusion.num_threads", "num_threads"},
           {"DelaunayMeshing.num_threads", "num_threads"},
           {"DelaunayMeshing.max_proj_dist", "VisibilityMeshing.max_proj_dist"},
           {"DelaunayMeshing.max_depth_dist", "VisibilityMeshing.max_depth_dist"},
           {"DelaunayMeshing.visibility_sigma", "VisibilityMeshing.visibility_sigma"},
           {"DelaunayMeshing.distance_sigma_factor", "VisibilityMeshing.distance_sigma_factor"},
           {"DelaunayMeshing.quality_regularization", "VisibilityMeshing.quality_regularization"},
           {"DelaunayMeshing.max_side_length_factor", "VisibilityMeshing.max_side_length_factor"},
           {"DelaunayMeshing.max_side_length_percentile",
            "VisibilityMeshing.max_side_length_percentile"}},
      .common_keys = {"database_path", "image_path", "log_to_stderr", "log_target", "log_path",
                      "log_color", "random_seed", "default_random_seed"},
      .default_texts = {{"PatchMatchStereo.depth_min", {"-1", "-1.0"}},
                        {"PatchMatchStereo.depth_max", {"-1", "-1.0"}},
                        {"PatchMatchStereo.sigma_spatial", {"-1", "-1.0"}}}};
  return synonyms;
}

}  // namespace lsmvs
