#!/usr/bin/env bash
# From nothing to a mesh: installs what is missing, builds, and reconstructs a scene.
#   scripts/demo.sh                 renders photos of a scene that is known exactly, and measures the result against it
#   scripts/demo.sh PATH_TO_PHOTOS  takes your photos (the folder is only read)
# Everything is written to build/demo (or $LSMVS_DEMO_DIR), which is replaced. 15 minutes on 2 cores, mostly for installing
# and building.
set -euo pipefail
cd "$(dirname "$0")/.."

photos=${1:-}
case $photos in -h | --help) sed -n '2,/^[^#]/{s/^# \{0,1\}//p}' "$0"; exit ;; esac
if [ -n "$photos" ]; then
  [ -d "$photos" ] || { echo "error: $photos is not a folder of photos" >&2; exit 2; }
  photos=$(cd "$photos" && pwd)
fi
project=${LSMVS_DEMO_DIR:-$PWD/build/demo}
bin=$PWD/build/release/bin
export QT_QPA_PLATFORM=offscreen  # colmap of Debian is linked with Qt

# step TITLE COMMAND...: runs it quietly; shows the end of its output if it fails.
step() {
  local title=$1 log begin=$SECONDS
  shift
  log=$project/logs/$(echo "$title" | tr -cs 'a-zA-Z0-9' '-' | sed 's/-*$//').log
  mkdir -p "$project/logs"
  printf '%-44s' "$title"
  if ! "$@" >"$log" 2>&1; then
    echo " failed; the end of $log:"
    tail -n 20 "$log"
    exit 1
  fi
  printf '%5d s\n' $((SECONDS - begin))
}

# Whether a command of the installed colmap knows an option: some were renamed in 4.0.
knows() { colmap "$1" --help 2>/dev/null | grep -- "--$2 " >/dev/null; }

render_scene() {
  "$bin/make_synthetic_workspace" --output "$project" --overwrite 1 --format photos --image_extension jpg \
    --shape relief --num_views 16 --width 1280 --height 960 --seed 1 \
    --Photo.noise_sigma 2 --Photo.gain_sigma 0.05 --Photo.weak_fraction 0.1 --Photo.cast_shadows 1
}

extract_features() {
  local options=(--SiftExtraction.use_gpu 0)
  knows feature_extractor FeatureExtraction.use_gpu && options=(--FeatureExtraction.use_gpu 0)
  # The rendered photos come from one ideal camera; of other photos COLMAP reads what EXIF says.
  if [ -z "$photos" ]; then
    options+=(--ImageReader.single_camera 1 --ImageReader.camera_model PINHOLE
      --ImageReader.camera_params 1536,1536,640,480 --SiftExtraction.max_num_features 3000)
  fi
  colmap feature_extractor --database_path "$project/database.db" --image_path "$project/images" \
    "${options[@]}"
}

match_features() {
  local matcher=exhaustive_matcher options=(--SiftMatching.use_gpu 0)
  # Every pair of many photos would take hours: then neighbours in the order of their names.
  [ "$(find -L "$project/images" -type f | wc -l)" -gt 200 ] && matcher=sequential_matcher
  knows $matcher FeatureMatching.use_gpu && options=(--FeatureMatching.use_gpu 0)
  colmap $matcher --database_path "$project/database.db" "${options[@]}"
}

find_cameras() {
  local options=()
  [ -z "$photos" ] && options=(--Mapper.ba_refine_focal_length 0 --Mapper.ba_refine_extra_params 0)
  mkdir -p "$project/mapper"
  colmap mapper --database_path "$project/database.db" --image_path "$project/images" \
    --output_path "$project/mapper" "${options[@]}"
  [ -d "$project/mapper/0" ] || { echo "the photos do not fit together"; return 1; }
}

# Moves the model into the frame of the truth, by the known centres of the cameras.
align_with_truth() {
  mkdir -p "$project/sparse/0"
  colmap model_aligner --input_path "$project/mapper/0" --output_path "$project/sparse/0" \
    --ref_images_path "$project/camera_centers.txt" --ref_is_gps 0 --alignment_type custom \
    --robust_alignment 0 --robust_alignment_max_error 0.01
}

scripts/setup.sh
echo "Building"
scripts/build.sh release

rm -rf "$project"
mkdir -p "$project"
if [ -z "$photos" ]; then
  step "Rendering 16 photos" render_scene
else
  ln -s "$photos" "$project/images"
fi
step "COLMAP: features" extract_features
step "COLMAP: matches" match_features
step "COLMAP: cameras and sparse points" find_cameras
if [ -z "$photos" ]; then
  step "COLMAP: alignment with the truth" align_with_truth
else
  mv "$project/mapper" "$project/sparse"
fi

"$bin/lsmvs-mesher" "$project"

workspace=$project/dense/0
mesh=$workspace/meshed-refined.ply
picture=$project/mesh.png
"$bin/lsmvs" mesh_renderer --input_path "$mesh" --workspace_path "$workspace" --output_path "$picture" >/dev/null
truth=()
[ -z "$photos" ] && truth=(--ground_truth_path "$project/gt_mesh.ply")
echo
"$bin/lsmvs" mesh_evaluator --input_path "$mesh" --workspace_path "$workspace" "${truth[@]}"
printf '\nmesh:    %s\npicture: %s\n%d minutes in all\n' "$mesh" "$picture" $(((SECONDS + 30) / 60))
