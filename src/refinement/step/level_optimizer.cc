#include "lsmvs/refinement/step/level_optimizer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "lsmvs/mesh/undo_collisions.h"
#include "lsmvs/refinement/regions/cluster_colors.h"
#include "lsmvs/refinement/regions/face_regions.h"
#include "lsmvs/refinement/step/crease_weights.h"
#include "lsmvs/refinement/step/line_search.h"
#include "lsmvs/refinement/step/smoothness.h"
#include "lsmvs/refinement/step/step_limits.h"
#include "lsmvs/refinement/step/step_solver.h"
#include "lsmvs/refinement/step/vertex_frames.h"

namespace lsmvs {

namespace {

constexpr size_t kBlock = 8192;
constexpr int kMaxSolverIterations = 60;
constexpr double kSolverTolerance = 0.02;
// A region that lost more than this part of its judged pixels moved somewhere it cannot be judged.
constexpr double kMinMassKept = 0.7;
constexpr double kInitialDamping = 0.01, kMinDamping = 0.003, kMaxDamping = 100.0;
constexpr double kDampingRaise = 8.0, kDampingFall = 1.0 / 3.0;
constexpr int kMaxRejections = 3;
// Of the parts that move one after the other.
constexpr int kFacesPerCluster = 1 << 14;
// For progress: the part of the work that is left after each evaluation. How many follow is not
// known, and they get cheaper as regions stop.
constexpr double kLeftAfterEvaluation = 0.75;
// Part of the photo term's lumped Gauss-Newton matrix that steps are found with. Sums of rows
// overrate the curvature of all but constant displacements: with less of it, fewer steps lead as
// far.
constexpr double kCurvatureShare = 0.8;

// State of one region between steps.
struct RegionState {
  double photo_error = 0, mass = 0, smoothness = 0;
  double damping = kInitialDamping;
  int rejections = 0;  // in a row
  bool frozen = false;
};

class LevelOptimizer {
 public:
  LevelOptimizer(const ImageStore& images, const std::vector<PosedCamera>& views,
                 const FaceRegions& regions, const FacePairs& pairs,
                 const std::vector<Eigen::Vector3d>& input, const MeshRefinerOptions& options,
                 int level, TriangleMesh* mesh, const RunContext& context)
      : images_(images),
        views_(views),
        pairs_(pairs),
        input_(input),
        options_(options),
        energy_options_(MakePhotoEnergyOptions(options, level, context)),
        mesh_(*mesh),
        context_(context),
        photo_scale_(1.0 / pairs.per_face),
        smoothness_(*mesh, {options.smoothness, options.membrane, options.laplacian}),
        regions_(regions),
        states_(static_cast<size_t>(regions.count)) {
    summary_.level = level;
    summary_.num_faces = mesh->faces.size();
  }

  RefinementLevelSummary Run() {
    const std::vector<Eigen::Vector3d> start = mesh_.vertices;
    pixel_size_ = MeanPixelSizes(mesh_, pairs_);
    region_of_vertex_ = RegionsOfVertices(mesh_, regions_);
    if (options_.deformation == RefinementDeformation::kSequential) {
      colors_ = ColorClusters(mesh_, regions_, kFacesPerCluster);
    }
    if (options_.flat_stiffness > 1) {
      creases_.emplace(mesh_, regions_, options_.flat_stiffness);
    }
    FindRim();
    directions_ = VertexDirections(mesh_);
    UpdateActivity();
    terms_ = EvaluatePhotoTerms(images_, views_, mesh_, directions_, pairs_, active_,
                                energy_options_, context_);
    smoothness_.SetGeometry(mesh_.vertices, directions_, pixel_size_, context_);
    FindAnchors();
    SumRegions(terms_, SmoothEnergies(mesh_.vertices, directions_), &states_);
    RecordEnergy();
    summary_.initial_photo_error = MeanPhotoError();
    if (options_.optimizer == RefinementOptimizer::kLbfgs) {
      SearchAlongLines();
    } else {
      for (int k = 0; k < options_.max_num_iterations && AnyActive(); ++k) {
        context_.Report(1 - std::pow(kLeftAfterEvaluation, k + 1));
        if (!Step()) break;
      }
    }
    summary_.num_collisions_undone = UndoCollisions(mesh_.faces, start, &mesh_.vertices, context_);
    summary_.final_photo_error = MeanPhotoError();
    summary_.num_regions = static_cast<int>(states_.size());
    for (const RegionState& state : states_) summary_.num_stopped_regions += state.frozen;
    return summary_;
  }

 private:
  void FindRim() {
    on_rim_ = smoothness_.rings().on_border;
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (pairs_.Seen(f)) continue;
      for (const int v : mesh_.faces[f]) on_rim_[static_cast<size_t>(v)] = 1;
    }
  }

  RegionState& StateOf(size_t face) { return states_[static_cast<size_t>(regions_.of_face[face])]; }

  // Faces of regions that still move are evaluated; vertices move whose faces all are, and that a
  // pair sees.
  void UpdateActivity() {
    active_.assign(mesh_.faces.size(), 1);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) active_[f] = !StateOf(f).frozen;
    FixAllBut([](size_t) { return true; });
  }

  // The same for one colour: its vertices move, the regions around them are evaluated.
  void ActivateColor(int color) {
    const auto has_color = [&](size_t v) {
      return region_of_vertex_[v] >= 0 && ColorOf(region_of_vertex_[v]) == color;
    };
    std::vector<uint8_t> is_near(states_.size(), 0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (const int v : mesh_.faces[f]) {
        if (has_color(static_cast<size_t>(v)))
          is_near[static_cast<size_t>(regions_.of_face[f])] = 1;
      }
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      active_[f] = !StateOf(f).frozen && is_near[static_cast<size_t>(regions_.of_face[f])];
    }
    FixAllBut(has_color);
  }

  int ColorOf(int32_t region) const {
    return colors_.of_region.empty() ? 0 : colors_.of_region[static_cast<size_t>(region)];
  }

  template <class MayMove>
  void FixAllBut(const MayMove& may_move) {
    fixed_.assign(mesh_.vertices.size(), 1);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (!pairs_.Seen(f)) continue;
      for (const int v : mesh_.faces[f]) {
        const auto vertex = static_cast<size_t>(v);
        if (may_move(vertex)) fixed_[vertex] = 0;
      }
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (active_[f]) continue;
      for (const int v : mesh_.faces[f]) fixed_[static_cast<size_t>(v)] = 1;
    }
  }

  // Stiffness of the springs to the input: so much a square pixel where the photos say nothing,
  // next to nothing where they are full of texture.
  void FindAnchors() {
    const std::vector<double> doubts = FindDoubts();
    anchors_.assign(mesh_.vertices.size(), 0.0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const double area = 0.5 * FaceNormalTimesTwiceArea(mesh_, f).norm();
      for (const int v : mesh_.faces[f]) {
        const size_t vertex = static_cast<size_t>(v);
        const double scale = pixel_size_[vertex];
        anchors_[vertex] += options_.anchor * doubts[vertex] * area / (3 * scale * scale);
      }
    }
  }

  // #V: 1 where the photos show no texture around a vertex, or do not see it in pairs; 0 where they
  // are full of it.
  std::vector<double> FindDoubts() const {
    std::vector<double> masses(mesh_.vertices.size(), 0.0), pixels(mesh_.vertices.size(), 0.0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (const int v : mesh_.faces[f]) {
        masses[static_cast<size_t>(v)] += terms_.mass[f];
        pixels[static_cast<size_t>(v)] += terms_.pixels[f];
      }
    }
    for (size_t v = 0; v < masses.size(); ++v) {
      const double doubt = pixels[v] > 0 ? 1 - masses[v] / pixels[v] : 1.0;
      masses[v] = std::clamp(doubt, 0.0, 1.0);
    }
    return masses;
  }

  // Of the thin plate and the springs, by vertex.
  std::vector<double> SmoothEnergies(const std::vector<Eigen::Vector3d>& positions,
                                     const std::vector<Eigen::Vector3d>& directions) const {
    std::vector<double> energies = smoothness_.Energies();
    for (size_t v = 0; v < energies.size(); ++v) {
      const double x = directions[v].dot(positions[v] - input_[v]) / pixel_size_[v];
      energies[v] += anchors_[v] * x * x;
    }
    return energies;
  }

  bool AnyActive() const {
    return std::any_of(states_.begin(), states_.end(),
                       [](const RegionState& state) { return !state.frozen; });
  }

  void SumRegions(const PhotoTerms& terms, const std::vector<double>& smoothness,
                  std::vector<RegionState>* states) const {
    for (RegionState& state : *states) {
      if (!state.frozen) state.photo_error = state.mass = 0;
      state.smoothness = 0;
    }
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      RegionState& state = (*states)[static_cast<size_t>(regions_.of_face[f])];
      if (state.frozen) continue;
      state.photo_error += terms.error[f];
      state.mass += terms.mass[f];
    }
    for (size_t v = 0; v < smoothness.size(); ++v) {
      if (region_of_vertex_[v] < 0) continue;
      (*states)[static_cast<size_t>(region_of_vertex_[v])].smoothness += smoothness[v];
    }
  }

  double MeanPhotoError() const {
    double error = 0, mass = 0;
    for (const RegionState& state : states_) {
      error += state.photo_error;
      mass += state.mass;
    }
    return mass > 0 ? error / mass : 0.0;
  }

  void RecordEnergy() {
    double energy = 0;
    for (const RegionState& state : states_) {
      energy += photo_scale_ * state.photo_error + state.smoothness;
    }
    summary_.energies.push_back(energy);
  }

  // Displacements in pixels that lower the energy to second order.
  std::vector<double> FindStep() {
    const size_t count = mesh_.vertices.size();
    std::vector<double> gradient = smoothness_.Gradient(context_);
    std::vector<double> diagonal = smoothness_.HessianDiagonal();
    for (size_t v = 0; v < count; ++v) {
      const double scale = pixel_size_[v];
      const double curvature = kCurvatureShare * photo_scale_ * terms_.curvature[v] * scale * scale;
      gradient[v] += photo_scale_ * terms_.gradient[v] * scale;
      const double damping = region_of_vertex_[v] < 0
                                 ? 0.0
                                 : states_[static_cast<size_t>(region_of_vertex_[v])].damping;
      const double spring = 2.0 * anchors_[v];
      gradient[v] += spring * directions_[v].dot(mesh_.vertices[v] - input_[v]) / scale;
      diagonal[v] = curvature + spring + damping * (curvature + diagonal[v]);
    }
    StepSolution solution = SolveStep(smoothness_, diagonal, gradient, fixed_, kMaxSolverIterations,
                                      kSolverTolerance, context_);
    for (double& x : solution.x) x = std::clamp(x, -options_.max_step_px, options_.max_step_px);
    return std::move(solution.x);
  }

  SurfaceBeforeStep Surface() const {
    return {mesh_, smoothness_.rings(), input_, directions_, pixel_size_, fixed_, on_rim_};
  }

  // Makes the plate stiff but at the creases that the surface has now. What is minimised changes.
  void SoftenAtCreases() {
    smoothness_.SetFactors(
        creases_->Factors(smoothness_.SquaredLaplacians(), smoothness_.rings(), context_));
    smoothness_.SetGeometry(mesh_.vertices, directions_, pixel_size_, context_);
    SumRegions(terms_, SmoothEnergies(mesh_.vertices, directions_), &states_);
    summary_.energies.pop_back();
    RecordEnergy();
  }

  // One step of all parts of the surface. False if the level has converged.
  bool Step() {
    // A level's first step brings out the creases that the coarser one could not see.
    if (creases_ && summary_.num_iterations > 0) SoftenAtCreases();
    const double energy_before = summary_.energies.back();
    bool any_accepted = false;
    for (int color = 0; color < colors_.num_colors; ++color) {
      if (colors_.num_colors > 1) ActivateColor(color);
      any_accepted |= StepOfColor(color);
    }
    RecordEnergy();
    ++summary_.num_iterations;
    const double gain = energy_before - summary_.energies.back();
    return !any_accepted || gain > options_.min_relative_gain * energy_before;
  }

  // Of what may move, accepted or taken back region by region. False if no region accepted it.
  bool StepOfColor(int color) {
    std::vector<double> step = FindStep();
    HoldRims(Surface(), &step);
    StopFolds(Surface(), &step);
    TriangleMesh trial;
    trial.vertices = Displaced(Surface(), step);
    trial.faces.swap(mesh_.faces);
    std::vector<Eigen::Vector3d> directions = VertexDirections(trial);
    PhotoTerms terms = EvaluatePhotoTerms(images_, views_, trial, directions, pairs_, active_,
                                          energy_options_, context_);
    trial.faces.swap(mesh_.faces);
    smoothness_.SetGeometry(trial.vertices, directions, pixel_size_, context_);
    std::vector<RegionState> states = states_;
    SumRegions(terms, SmoothEnergies(trial.vertices, directions), &states);
    const std::vector<uint8_t> rejected = Judge(states, color);
    Commit(rejected, std::move(trial.vertices), std::move(directions), std::move(terms));
    smoothness_.SetGeometry(mesh_.vertices, directions_, pixel_size_, context_);
    SumRegions(terms_, SmoothEnergies(mesh_.vertices, directions_), &states_);
    UpdateActivity();
    return std::any_of(rejected.begin(), rejected.end(), [](uint8_t r) { return !r; });
  }

  // The whole level by L-BFGS, along fixed directions and with the thin plate of the start.
  void SearchAlongLines() {
    if (options_.max_num_iterations == 0) return;
    const double plate_at_start = summary_.energies.back() - photo_scale_ * terms_.TotalError();
    const std::vector<double> plate_gradient = smoothness_.Gradient(context_);
    std::vector<double> curved, scratch;
    TriangleMesh trial;
    trial.faces = mesh_.faces;
    const auto function = [&](const std::vector<double>& x, std::vector<double>* gradient) {
      trial.vertices = Displaced(Surface(), x);
      PhotoTerms terms = EvaluatePhotoTerms(images_, views_, trial, directions_, pairs_, active_,
                                            energy_options_, context_);
      smoothness_.ApplyHessian(x, context_, &scratch, &curved);
      double energy = photo_scale_ * terms.TotalError() + plate_at_start;
      if (gradient != nullptr) gradient->assign(x.size(), 0.0);
      for (size_t v = 0; v < x.size(); ++v) {
        const double scale = pixel_size_[v], spring = 2.0 * anchors_[v];
        const double offset = directions_[v].dot(mesh_.vertices[v] - input_[v]) / scale;
        energy += x[v] * (plate_gradient[v] + spring * offset + 0.5 * (curved[v] + spring * x[v]));
        if (gradient == nullptr || fixed_[v]) continue;
        (*gradient)[v] = photo_scale_ * scale * terms.gradient[v] + plate_gradient[v] + curved[v] +
                         spring * (offset + x[v]);
      }
      return energy;
    };
    summary_.energies.clear();
    std::vector<double> step = MinimizeByLbfgs(
        mesh_.vertices.size(), function, {options_.max_num_iterations, options_.min_relative_gain},
        &summary_.energies);
    summary_.num_iterations = static_cast<int>(summary_.energies.size()) - 1;
    StopFolds(Surface(), &step);
    mesh_.vertices = Displaced(Surface(), step);
    directions_ = VertexDirections(mesh_);
    terms_ =
        EvaluatePhotoTerms(images_, views_, mesh_, {}, pairs_, active_, energy_options_, context_);
    smoothness_.SetGeometry(mesh_.vertices, directions_, pixel_size_, context_);
    SumRegions(terms_, SmoothEnergies(mesh_.vertices, directions_), &states_);
  }

  // Which regions got worse. Adapts damping, and freezes what has converged, of those that moved.
  std::vector<uint8_t> Judge(const std::vector<RegionState>& trial, int color) {
    std::vector<uint8_t> rejected(states_.size(), 0);
    const std::vector<uint8_t> is_evaluated = EvaluatedRegions();
    for (size_t r = 0; r < states_.size(); ++r) {
      RegionState& state = states_[r];
      if (!is_evaluated[r]) continue;
      const double before = photo_scale_ * state.photo_error + state.smoothness;
      const double kept = state.mass > 0 ? trial[r].mass / state.mass : 1.0;
      // Compared over as many pixels as before.
      const double photo = trial[r].mass > 0 ? trial[r].photo_error / kept : 0.0;
      const double after = photo_scale_ * photo + trial[r].smoothness;
      rejected[r] = after > before || kept < kMinMassKept;
      if (ColorOf(static_cast<int32_t>(r)) != color) continue;
      if (rejected[r]) {
        ++summary_.num_rejected_regions;
        state.damping = std::min(state.damping * kDampingRaise, kMaxDamping);
        state.frozen = ++state.rejections >= kMaxRejections;
      } else {
        state.rejections = 0;
        state.damping = std::max(state.damping * kDampingFall, kMinDamping);
        state.frozen = before - after < options_.min_relative_gain * before;
      }
    }
    return rejected;
  }

  std::vector<uint8_t> EvaluatedRegions() const {
    std::vector<uint8_t> is_evaluated(states_.size(), 0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      is_evaluated[static_cast<size_t>(regions_.of_face[f])] |= active_[f];
    }
    return is_evaluated;
  }

  // Vertices with a face in a rejected region stay as they were, with their old derivatives.
  void Commit(const std::vector<uint8_t>& rejected, std::vector<Eigen::Vector3d>&& positions,
              std::vector<Eigen::Vector3d>&& directions, PhotoTerms&& terms) {
    // Of vertices with a face that was not evaluated, the derivatives are not known anew.
    std::vector<uint8_t> stays(mesh_.vertices.size(), 0), is_partial(mesh_.vertices.size(), 0);
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (!active_[f]) {
        for (const int v : mesh_.faces[f]) is_partial[static_cast<size_t>(v)] = 1;
      }
      const bool is_rejected = rejected[static_cast<size_t>(regions_.of_face[f])] != 0;
      if (!is_rejected && active_[f]) {
        terms_.error[f] = terms.error[f];
        terms_.mass[f] = terms.mass[f];
      }
      if (!is_rejected) continue;
      for (const int v : mesh_.faces[f]) stays[static_cast<size_t>(v)] = 1;
    }
    for (size_t v = 0; v < stays.size(); ++v) {
      if (stays[v] || is_partial[v]) continue;
      terms_.gradient[v] = terms.gradient[v];
      terms_.curvature[v] = terms.curvature[v];
      if (fixed_[v]) continue;
      mesh_.vertices[v] = positions[v];
      directions_[v] = directions[v];
    }
  }

  const ImageStore& images_;
  const std::vector<PosedCamera>& views_;
  const FacePairs& pairs_;
  const std::vector<Eigen::Vector3d>& input_;
  const MeshRefinerOptions& options_;
  PhotoEnergyOptions energy_options_;
  TriangleMesh& mesh_;
  const RunContext& context_;
  double photo_scale_;
  Smoothness smoothness_;
  const FaceRegions& regions_;
  std::vector<RegionState> states_;
  std::optional<CreaseWeights> creases_;  // none: the plate is the same everywhere
  ClusterColors colors_;                  // one colour where all parts move at once
  std::vector<int32_t> region_of_vertex_;
  std::vector<uint8_t> active_, fixed_;
  std::vector<uint8_t> on_rim_;  // #V: at a border of the mesh, or of what pairs see
  std::vector<double> pixel_size_, anchors_;
  std::vector<Eigen::Vector3d> directions_;
  PhotoTerms terms_;
  RefinementLevelSummary summary_;
};

}  // namespace

std::vector<PosedCamera> MakeLevelViews(const Scene& scene, const ImageStore& images, int level) {
  std::vector<PosedCamera> views;
  for (int v = 0; v < scene.num_views(); ++v) {
    views.push_back({images.Camera(v, level), scene.views[static_cast<size_t>(v)].cam_from_world});
  }
  return views;
}

PhotoEnergyOptions MakePhotoEnergyOptions(const MeshRefinerOptions& options, int level,
                                          const RunContext& context) {
  PhotoEnergyOptions result;
  result.level = level;
  result.depth_tolerance = options.depth_tolerance;
  result.correlation.radius = options.window_radius;
  result.correlation.noise_variance =
      static_cast<float>(options.noise_gray_levels * options.noise_gray_levels);
  result.map_budget_bytes = context.memory_budget_bytes / 4;
  return result;
}

RefinementLevelSummary OptimizeLevel(const ImageStore& images,
                                     const std::vector<PosedCamera>& views,
                                     const FaceRegions& regions, const FacePairs& pairs,
                                     const std::vector<Eigen::Vector3d>& input,
                                     const MeshRefinerOptions& options, int level,
                                     TriangleMesh* mesh, const RunContext& context) {
  return LevelOptimizer(images, views, regions, pairs, input, options, level, mesh, context).Run();
}

}  // namespace lsmvs
