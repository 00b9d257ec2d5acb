#include "lsmvs/refinement/mesh_refiner.h"

namespace lsmvs {

void MeshRefinerOptions::Describe(OptionSet* options) {
  options->Add("MeshRefinement.num_levels", &num_levels,
               "Image pyramid levels, coarse to fine; more pull in vertices from further away.",
               {1, 8});
  options->AddEnum("MeshRefinement.optimizer", &optimizer,
                   "How the energy is minimised; lbfgs is slower and there for comparison.",
                   {{"gauss_newton", RefinementOptimizer::kGaussNewton},
                    {"lbfgs", RefinementOptimizer::kLbfgs}});
  options->AddEnum("MeshRefinement.deformation", &deformation,
                   "All parts of the surface move at once, or one after the other while their "
                   "neighbours are held: slower, for comparison.",
                   {{"independent", RefinementDeformation::kIndependent},
                    {"sequential", RefinementDeformation::kSequential}});
  options->Add("MeshRefinement.max_num_iterations", &max_num_iterations,
               "Maximum number of steps per level; with 0 only the filters move vertices.",
               {0, 1000});
  options->Add("MeshRefinement.window_radius", &window_radius,
               "Half side of the correlation window in pixels; larger is more stable and smoother.",
               {1, 7});
  options->Add("MeshRefinement.max_num_neighbors", &max_num_neighbors,
               "Maximum number of neighbours that a view is compared with.", {1, 16});
  options->Add("MeshRefinement.max_pairs_per_face", &max_pairs_per_face,
               "Maximum number of ordered pairs of views per facet; time grows with it.", {1, 64});
  options->Add("MeshRefinement.min_triangulation_angle", &min_triangulation_angle_deg,
               "Minimum triangulation angle [deg] of a pair at a facet.", {0.0, 180.0});
  options->Add("MeshRefinement.max_triangulation_angle", &max_triangulation_angle_deg,
               "Maximum triangulation angle [deg] of a pair at a facet.", {0.0, 180.0});
  options->Add(
      "MeshRefinement.smoothness", &smoothness,
      "Weight of the thin-plate energy; raising it smooths, whatever the unit of the scene.",
      {0.0, 1e6});
  options->Add("MeshRefinement.flat_stiffness", &flat_stiffness,
               "How many times stiffer the thin plate is on flat parts than at creases; raising it "
               "takes more noise out of plain surfaces; 1: the same everywhere.",
               {1.0, 1e4});
  options->Add("MeshRefinement.input_filter_passes", &input_filter_passes,
               "Passes of a filter that takes noise of the size of single triangles off the input "
               "and leaves edges sharp; more flatten small relief. 0: none.",
               {0, 100});
  options->Add("MeshRefinement.result_filter_passes", &result_filter_passes,
               "The same for the refined surface, before it is simplified.", {0, 100});
  options->Add("MeshRefinement.membrane", &membrane,
               "Weight of the membrane relative to the thin plate; raising it shrinks thin parts.",
               {0.0, 1e3});
  options->Add("MeshRefinement.anchor", &anchor,
               "Weight of the distance from the input where there is no texture; raising it keeps "
               "more of the input.",
               {0.0, 1e3});
  options->AddEnum(
      "MeshRefinement.laplacian", &laplacian, "Weights of a vertex' neighbours.",
      {{"uniform", LaplacianWeights::kUniform}, {"cotangent", LaplacianWeights::kCotangent}});
  options->Add("MeshRefinement.noise", &noise_gray_levels,
               "Noise of the photos in grey levels; windows flatter than this count little.",
               {0.0, 255.0});
  options->Add("MeshRefinement.depth_tolerance", &depth_tolerance,
               "A point is hidden if the surface is nearer by more than this part of its depth.",
               {1e-6, 1.0});
  options->Add("MeshRefinement.max_step", &max_step_px,
               "Maximum step of a vertex per iteration [px of the level].", {1e-3, 100.0});
  options->Add("MeshRefinement.min_relative_gain", &min_relative_gain,
               "A level ends when a step lowers the energy by less than this part of it.",
               {0.0, 1.0});
  options->Add("MeshRefinement.max_face_area", &max_face_area_px,
               "Maximum area of a facet in its best pair of views [px^2]; larger ones are split; "
               "0: no limit.",
               {0.0, 1e6});
  options->Add("MeshRefinement.improve_mesh", &improve_mesh,
               "Flip and collapse edges so that the triangles stay regular.");
  options->Add("MeshRefinement.guard", &guard,
               "Regions that lost more photo-consistency than they gained in smoothness return to "
               "their input.");
  options->Add("MeshRefinement.max_gap_share", &max_gap_share,
               "Width, as a share of the photos' longer side, up to which faces at the surface's "
               "ends stay although photos disagree through them; 0: none go.",
               {0.0, 1.0});
  options->Add("MeshRefinement.max_hole_edges", &max_hole_edges,
               "Holes with at most this many edges are closed at the end; 0: none.", {0, 100000});
  options->Add("MeshRefinement.hold_out_every", &hold_out_every,
               "Every n-th view takes no part in the refinement, only in the guard; 0: none.",
               {0, 1000000});
  options->Add("MeshRefinement.simplify_tolerance", &simplify_tolerance,
               "Maximum distance [px] between the surface before and after faces are saved at the "
               "end; 0: all stay.",
               {0.0, 100.0});
  options->Add("MeshRefinement.color_vertices", &color_vertices,
               "Colour the vertices with the photos.");
}

}  // namespace lsmvs
