#!/usr/bin/env bash
# The comparison of the README, from nothing: renders a scene that is known exactly, reconstructs it with lsmvs, runs those of
# COLMAP's meshers that the installed colmap can run on the same cloud, and measures all meshes against the truth.
#   scripts/compare_meshers.sh [FOLDER]      (default: build/comparison; replaced)
# LSMVS_COMPARISON_SHAPE (relief), _VIEWS (16), _WIDTH (1280): the scene; smaller is faster. Ends with the table and the path
# of the page.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:-$PWD/build/comparison}
shape=${LSMVS_COMPARISON_SHAPE:-relief}
views=${LSMVS_COMPARISON_VIEWS:-16}
width=${LSMVS_COMPARISON_WIDTH:-1280}
bin=$PWD/build/release/bin
export QT_QPA_PLATFORM=offscreen  # colmap of Debian is linked with Qt

scripts/setup.sh
scripts/build.sh release
if [ -e "$folder" ] && [ ! -e "$folder/.made-by-compare-meshers" ]; then
  echo "error: $folder is there and was not made by this script; give another folder" >&2
  exit 2
fi
rm -rf "$folder"
mkdir -p "$folder"
touch "$folder/.made-by-compare-meshers"

echo "Rendering $views photos"
"$bin/make_synthetic_workspace" --output "$folder/scene" --format dense --image_extension jpg --shape "$shape" \
  --num_views "$views" --width "$width" --height $((width * 3 / 4)) --seed 1 \
  --Photo.noise_sigma 2 --Photo.gain_sigma 0.05 --Photo.weak_fraction 0.1 --Photo.cast_shadows 1
mv "$folder/scene/gt_mesh.ply" "$folder/gt_mesh.ply"
"$bin/lsmvs-mesher" "$folder/scene"
page=$("$bin/lsmvs" mesh_comparer --workspace_path "$folder/scene" --ground_truth_path "$folder/gt_mesh.ply" --run_colmap \
  --title "Meshes of a rendered scene ($shape)")

python3 - "$folder/scene/lsmvs/report/report.json" <<'EOF'
import json, sys
report = json.load(open(sys.argv[1]))
first = report['meshes'][0]['figures']['surface']
shares = [f'F1@{t:g}' for t in first['thresholds']]
print('\n| mesh | ' + ' | '.join(shares) + ' | mean distance | photo score | faces | manifold | seconds | peak MB |')
print('|---' * (len(shares) + 7) + '|')
for mesh in report['meshes']:
    f = mesh['figures']
    cells = [f'{x:.3f}' for x in f['surface']['f1']]
    cells += [f"{f['surface']['accuracy']['mean'] / first['unit_in_world']:.2f}", f"{f['photometric']['score']:.3f}"]
    cells += [f"{f['mesh']['faces']:,}", 'yes' if f['mesh']['manifold'] else 'no']
    cells += [f"{mesh['seconds']:.0f}" if 'seconds' in mesh else '-', f"{mesh['peak_bytes'] / 2**20:.0f}" if 'peak_bytes' in mesh else '-']
    print('| ' + mesh['title'] + ' | ' + ' | '.join(cells) + ' |')
for missing in report['missing']:
    print(f"\n{missing['title']}: {missing['reason']}")
EOF
printf '\npage: %s\n' "$page"
