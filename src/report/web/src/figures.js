// The table of figures, the chart of depth errors, and the run.
import { SERIES } from './colors.js';

const el = (name, attributes = {}, ...children) => {
  const svg = ['svg', 'g', 'line', 'path', 'text', 'circle', 'rect'].includes(name);
  const node = svg ? document.createElementNS('http://www.w3.org/2000/svg', name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};

const count = (n) => (n === undefined ? '' : n.toLocaleString('en-US'));
const share = (x) => x.toFixed(3);
const fine = (x) => x.toFixed(4);
const tenths = (x) => x.toFixed(1);
const small = (x) => (x === 0 ? '0' : x < 0.001 ? '< 0.001' : x >= 100 ? x.toFixed(0) : x >= 10 ? x.toFixed(1) : x.toPrecision(3));
export const bytes = (n) => (n >= 2 ** 30 ? `${(n / 2 ** 30).toFixed(1)} GB` : n >= 1e5 ? `${(n / 2 ** 20).toFixed(1)} MB` : `${Math.ceil(n / 1024)} kB`);
export const duration = (s) => (s >= 3600 ? `${(s / 3600).toFixed(1)} h` : s >= 100 ? `${(s / 60).toFixed(1)} min` : `${s.toFixed(1)} s`);
const yes = (b) => (b ? 'yes' : 'no');

function truthRows(meshes) {
  const first = meshes.map((m) => m.figures.surface).find(Boolean);
  if (!first) return [];
  const unit = first.gsd && first.unit_in_world === first.gsd ? 'GSD' : 'units';
  const rows = [{ group: `Against the ground truth${unit === 'GSD' ? ` (1 GSD, a pixel on the surface, is ${small(first.gsd)} units)` : ''}` }];
  const surface = (m) => (m.figures.surface?.status === 'ok' ? m.figures.surface : undefined);
  first.thresholds.forEach((t, k) => rows.push({ name: `F1 within ${t} ${unit}`, get: (m) => surface(m)?.f1[k], show: share, best: 'max' }));
  const last = Math.min(2, first.thresholds.length - 1);
  rows.push({ name: `Accuracy within ${first.thresholds[last]} ${unit}`, get: (m) => surface(m)?.accuracy.shares[last], show: share, best: 'max' });
  rows.push({ name: `Completeness within ${first.thresholds[last]} ${unit}`, get: (m) => surface(m)?.completeness.shares[last], show: share, best: 'max' });
  const scaled = (key, part) => (m) => (surface(m) === undefined ? undefined : surface(m)[part][key] / first.unit_in_world);
  rows.push({ name: `Mean distance to the truth, ${unit}`, get: scaled('mean', 'accuracy'), show: small, best: 'min' });
  rows.push({ name: `Median distance to the truth, ${unit}`, get: scaled('median', 'accuracy'), show: small, best: 'min' });
  rows.push({ name: `95 % of the distances, ${unit}`, get: scaled('percentile_95', 'accuracy'), show: small, best: 'min' });
  return rows;
}

function rowsOf(meshes) {
  const photometric = (key) => (m) => m.figures.photometric?.[key];
  const silhouettes = (key) => (m) => m.figures.silhouettes?.[key];
  const mesh = (key) => (m) => m.figures.mesh?.[key];
  const cloud = (key) => (m) => m.figures.cloud?.[key];
  const texture = (key) => (m) => m.figures.texture?.[key];
  const atlas = (key) => (m) => m.figures.atlas?.[key];
  return [
    ...truthRows(meshes),
    { group: 'Against the photos' },
    { name: 'Covered share of the photos', get: photometric('coverage'), show: share, best: 'max' },
    { name: 'Mean correlation (ZNCC) where covered', get: photometric('mean_zncc'), show: share, best: 'max' },
    { name: 'Score (both together)', get: photometric('score'), show: share, best: 'max' },
    { group: 'Texture or vertex colours drawn at the poses of the photos' },
    { name: 'PSNR, dB', get: texture('psnr'), show: (x) => x.toFixed(2), best: 'max' },
    { name: 'SSIM', get: texture('ssim'), show: fine, best: 'max' },
    { name: '1 - NCC', get: texture('one_minus_ncc'), show: fine, best: 'min' },
    { name: 'Step at seams over the step inside', get: atlas('seam_ratio'), show: share, best: 'min' },
    { name: 'Charts', get: atlas('charts'), show: count },
    { name: 'Share of the texels in use', get: atlas('utilisation'), show: share, best: 'max' },
    { group: 'Seen from the poses of the photos' },
    { name: 'Holes (enclosed background), share of the mesh', get: silhouettes('hole_share'), show: fine, best: 'min' },
    { name: 'Torn (narrow gaps and bays), share of the mesh', get: silhouettes('torn_share'), show: fine, best: 'min' },
    { name: 'Length of the rim (a disc has 4.5)', get: silhouettes('rim'), show: tenths, best: 'min' },
    { name: 'Crumbs (lumps, noise and true edges), share of the mesh', get: silhouettes('crumb_share'), show: share, best: 'min' },
    { group: 'Mesh' },
    { name: 'Faces', get: mesh('faces'), show: count },
    { name: 'Vertices', get: mesh('vertices'), show: count },
    { name: 'Manifold', get: mesh('manifold'), show: yes },
    { name: 'Border edges', get: mesh('border_edges'), show: count },
    { name: 'Non-manifold edges', get: mesh('nonmanifold_edges'), show: count, best: 'min' },
    { name: 'Components', get: mesh('components'), show: count },
    { group: 'Cloud' },
    { name: 'Points', get: cloud('points'), show: count },
    { name: 'Photos that see a point', get: cloud('mean_views'), show: tenths },
    { name: 'Share of the photos’ cells of 4 × 4 pixels with a point', get: cloud('coverage'), show: share, best: 'max' },
    { group: 'Cost' },
    { name: 'Time from the cloud to the mesh', get: (m) => m.seconds, show: duration, best: 'min' },
    { name: 'Peak memory', get: (m) => m.peak_bytes, show: bytes, best: 'min' },
    { name: 'File', get: (m) => m.file_bytes, show: bytes },
  ];
}

// Rows without any value, and groups without rows, are left out.
function usedRows(meshes) {
  const rows = rowsOf(meshes).filter((row) => row.group || meshes.some((m) => row.get(m) !== undefined));
  return rows.filter((row, i) => !row.group || (rows[i + 1] && !rows[i + 1].group));
}

function bestIndices(row, values) {
  const known = values.filter((v) => v !== undefined && v !== null);
  if (!row.best || known.length < 2) return new Set();
  const best = Math[row.best](...known);
  const shown = row.show(best);
  const marked = values.map((v, i) => (v !== undefined && v !== null && row.show(v) === shown ? i : -1)).filter((i) => i >= 0);
  return marked.length === values.length ? new Set() : new Set(marked);
}

export function fillTable(table, meshes) {
  table.append(el('caption', { class: 'hidden' }, 'Figures of the meshes and clouds; the best value of a row is marked'));
  const head = el('tr', {}, el('th', { scope: 'col' }, meshes.some((m) => m.figures.cloud) ? 'Mesh or cloud' : 'Mesh'));
  for (const m of meshes) head.append(el('th', { scope: 'col' }, m.title, el('small', {}, m.file)));
  table.append(el('thead', {}, head));
  const body = el('tbody');
  for (const row of usedRows(meshes)) {
    if (row.group) {
      body.append(el('tr', { class: 'group' }, el('th', { colspan: meshes.length + 1, scope: 'rowgroup' }, row.group)));
      continue;
    }
    const values = meshes.map(row.get);
    const best = bestIndices(row, values);
    const line = el('tr', {}, el('th', { scope: 'row' }, row.name));
    values.forEach((value, i) => {
      const text = value === undefined || value === null ? '–' : row.show(value);
      const cell = el('td', best.has(i) ? { class: 'best' } : {}, el('span', {}, text));
      if (best.has(i)) cell.append(el('span', { class: 'hidden' }, ' (best)'));
      line.append(cell);
    });
    body.append(line);
  }
  table.append(body);
}

function cumulative(histogram) {
  let sum = 0;
  return histogram.bins.map((n) => (sum += n) / Math.max(1, histogram.pixels));
}

function marker(shape, x, y, color) {
  if (shape % 3 === 0) return el('circle', { cx: x, cy: y, r: 4, fill: color });
  if (shape % 3 === 1) return el('rect', { x: x - 3.5, y: y - 3.5, width: 7, height: 7, fill: color });
  return el('path', { d: `M${x} ${y - 5}l5 8h-10z`, fill: color });
}

// Curves of the share of pixels below an error; false if no mesh has them.
export function fillChart(box, meshes) {
  const series = meshes.map((m, i) => ({ title: m.title, index: i, histogram: m.figures.depth_errors?.all })).filter((s) => s.histogram);
  if (!series.length) return false;
  const bins = series[0].histogram.bins.length;
  const width = 760, height = 330, left = 48, right = 16, top = 16, bottom = 46 + 20 * Math.ceil(series.length / 2);
  const x = (b) => left + (b / bins) * (width - left - right), y = (s) => height - bottom - s * (height - top - bottom);
  const text = series.map((s) => `${s.title}: ${(100 * cumulative(s.histogram)[0]).toFixed(0)} % within 1, ${(100 * cumulative(s.histogram).at(-1)).toFixed(0)} % within ${bins}`).join('; ');
  const svg = el('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `Share of pixels by depth error. ${text}` });
  for (let s = 0; s <= 1; s += 0.25) {
    svg.append(el('line', { class: 'axis', x1: left, x2: width - right, y1: y(s), y2: y(s) }), el('text', { x: left - 8, y: y(s) + 4, 'text-anchor': 'end' }, `${100 * s} %`));
  }
  for (let b = 0; b <= bins; ++b) svg.append(el('text', { x: x(b), y: height - bottom + 18, 'text-anchor': 'middle' }, String(b)));
  svg.append(el('text', { x: (left + width - right) / 2, y: height - bottom + 36, 'text-anchor': 'middle' }, 'error of the depth, pixels on the surface'));
  series.forEach((s, k) => {
    const color = SERIES[s.index % SERIES.length];
    const points = [0, ...cumulative(s.histogram)].map((v, b) => [x(b), y(v)]);
    svg.append(el('path', { d: `M${points.map((p) => p.join(' ')).join('L')}`, fill: 'none', stroke: color, 'stroke-width': 2 }));
    points.slice(1).forEach((p) => svg.append(marker(s.index, ...p, color)));
    const legendX = left + (k % 2) * 340, legendY = height - bottom + 58 + 20 * Math.floor(k / 2);
    svg.append(marker(s.index, legendX + 5, legendY - 4, color), el('text', { x: legendX + 18, y: legendY }, s.title));
  });
  box.append(svg);
  return true;
}

function pairsTable(caption, head, pairs) {
  const body = el('tbody');
  for (const [first, ...rest] of pairs) body.append(el('tr', {}, el('th', { scope: 'row' }, first), ...rest.map((r) => el('td', {}, r))));
  return el('table', { class: 'wide' }, el('caption', { class: 'hidden' }, caption),
    el('thead', {}, el('tr', {}, ...head.map((h) => el('th', { scope: 'col' }, h)))), body);
}

export function fillRun(box, report) {
  if (report.stages.length) {
    const rows = report.stages.map((s) => [s.name, duration(s.seconds), s.peak_bytes ? bytes(s.peak_bytes) : '–']);
    box.append(el('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Timings' }, pairsTable('Timings', ['Step', 'Time', 'Peak memory'], rows)));
  }
  if (report.options.length) {
    const rows = report.options.map((o) => [o.name, o.value]);
    box.append(el('details', {}, el('summary', {}, `Options (${rows.length})`), pairsTable('Options', ['Option', 'Value'], rows)));
  }
  return report.stages.length + report.options.length > 0;
}

export function fillList(list, items) {
  for (const item of items) list.append(el('li', {}, ...item));
  return items.length > 0;
}
export { el, count };
