// Viridis, as src/evaluation/error_colors.cc has it.
const STOPS = [
  [68, 1, 84], [72, 36, 117], [65, 68, 135], [53, 95, 141], [42, 120, 142], [33, 145, 140], [34, 168, 132],
  [68, 191, 112], [122, 209, 81], [189, 223, 38], [253, 231, 37],
];
export const UNKNOWN = [150, 150, 150];

export function errorColor(value) {
  const place = Math.min(Math.max(value, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(place), STOPS.length - 2);
  return STOPS[low].map((c, k) => Math.round(c + (place - low) * (STOPS[low + 1][k] - c)));
}

export function errorGradient() {
  return `linear-gradient(90deg, ${STOPS.map((c) => `rgb(${c})`).join(', ')})`;
}

// Colours of the meshes in charts; told apart by people who do not tell red from green, and marked by shape as well.
export const SERIES = ['#0b6bcb', '#d9730d', '#0d8a6a', '#b0459b', '#7a6a00', '#5b646d'];
