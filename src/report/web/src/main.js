import { errorGradient } from './colors.js';
import { count, el, fillChart, fillList, fillRun, fillTable } from './figures.js';
import { unpackMesh } from './unpack.js';
import { STYLES, Viewer } from './viewer.js';

const $ = (id) => document.getElementById(id);
const report = JSON.parse($('report').textContent);
const { meshes, clouds, photos } = report;
const layouts = [];
let viewer = null;
let layout = null;
let photoIndex = null; // chosen in the list
const shown = []; // mesh of each view

const say = (text) => { $('status').textContent = text; };
const isColored = (mesh) => mesh.packed.colors || mesh.packed.texture;
const reveal = (id, wanted) => { $(id).hidden = !wanted; };
const narrow = () => window.matchMedia('(max-width: 720px)').matches;

function fillTexts() {
  document.title = report.title;
  $('title').textContent = report.title;
  $('subtitle').textContent = report.workspace;
  const facts = [[count(photos.length), photos.length === 1 ? 'photo' : 'photos'], [count(meshes.length), meshes.length === 1 ? 'mesh' : 'meshes']];
  $('highlights').append(...facts.map(([value, name]) => el('div', {}, el('dt', {}, name), el('dd', {}, value))));
  fillTable($('table'), [...meshes, ...clouds]);
  const simplified = meshes.filter((m) => m.faces_shown < m.figures.mesh.faces);
  if (simplified.length) {
    reveal('simplified', true);
    $('simplified').textContent = `Simplified for this page, not for the figures: ${simplified
      .map((m) => `${m.title} (${count(m.figures.mesh.faces)} faces, ${count(m.faces_shown)} shown)`).join(', ')}.`;
  }
  $('table-note').textContent = '★ marks the best value of a row. More faces or a closed mesh are not better by themselves. ' +
    'Coverage and correlation must be read together.';
  reveal('histogram', fillChart($('chart'), meshes));
  reveal('run', fillRun($('run-body'), report));
  reveal('missing', fillList($('missing-list'), report.missing.map((m) => [el('strong', {}, m.title), `: ${m.reason}`])));
  reveal('notes', fillList($('notes-list'), report.notes.map((n) => [n])));
  $('footer').textContent = `Made by ${report.program}. This page is one file and loads nothing from the network.`;
}

// A group of radio buttons that look like one control.
function radios(box, name, choices, onChoose) {
  for (const { value, label, disabled, title } of choices) {
    const input = el('input', { type: 'radio', name, value, id: `${name}-${value}` });
    input.disabled = !!disabled;
    input.addEventListener('change', () => onChoose(value));
    box.append(el('label', { class: 'toggle', ...(title ? { title } : {}) }, input, el('span', {}, label)));
  }
}

function paneFigure(i) {
  const { surface, photometric } = meshes[i].figures;
  if (surface?.status === 'ok') {
    const k = Math.min(2, surface.thresholds.length - 1);
    return `F1@${surface.thresholds[k]} ${surface.f1[k].toFixed(3)}`;
  }
  return photometric ? `photo score ${photometric.score.toFixed(3)}` : `${count(meshes[i].figures.mesh?.faces)} faces`;
}

function meshSelect(view, label, onChange) {
  const select = el('select', { 'aria-label': label }, ...meshes.map((m, i) => el('option', { value: i }, m.title)));
  select.value = shown[view];
  select.addEventListener('change', () => {
    shown[view] = Number(select.value);
    onChange();
    say(`${label}: ${meshes[shown[view]].title}`);
  });
  for (const type of ['pointerdown', 'wheel', 'keydown']) select.addEventListener(type, (e) => e.stopPropagation());
  return select;
}

function makePane(views) {
  const figure = el('span', { class: 'figure' });
  const pane = { element: el('div', { class: views.length > 1 ? 'pane two' : 'pane' }), meshes: [] };
  const update = () => {
    pane.meshes = views.map((v) => shown[v]);
    figure.textContent = views.length > 1 ? '' : paneFigure(shown[views[0]]);
    viewer.request();
  };
  views.forEach((v, k) => {
    const select = meshSelect(v, views.length > 1 ? `Mesh on the ${k ? 'right' : 'left'}` : `Mesh in view ${v + 1}`, update);
    if (k) select.classList.add('right');
    pane.element.append(select);
  });
  pane.element.append(figure);
  update();
  return pane;
}

function setLayout(name) {
  layout = name;
  const wipe = name === 'wipe';
  const numViews = wipe ? 1 : Number(name);
  const panes = $('panes');
  const columns = narrow() ? (numViews === 4 ? 2 : 1) : numViews === 4 ? 2 : numViews;
  panes.replaceChildren();
  panes.style.gridTemplateColumns = `repeat(${columns}, 1fr)`;
  panes.style.gridTemplateRows = `repeat(${Math.ceil(numViews / columns)}, 1fr)`;
  viewer.panes = wipe ? [makePane([0, 1])] : Array.from({ length: numViews }, (_, v) => makePane([v]));
  panes.append(...viewer.panes.map((p) => p.element));
  reveal('wipe-box', wipe);
  reveal('wipe-line', wipe);
  $('stage').classList.toggle('wiping', wipe);
  $(`layout-${name}`).checked = true;
  viewer.request();
  say(wipe ? 'One view, two meshes with a slider' : `${numViews} linked views`);
}

function setWipe(share) {
  viewer.set({ wipe: share });
  $('wipe-line').style.left = `${100 * share}%`;
}

function setStyle(style) {
  viewer.set({ style });
  $(`style-${style}`).checked = true;
  const legend = $('legend');
  legend.hidden = style !== 'errors';
  if (!legend.hidden && !legend.childElementCount) {
    const bar = el('i');
    bar.style.background = errorGradient();
    const [low, high] = report.error_caption.split('|').slice(1);
    legend.append(bar, el('div', {}, el('span', {}, low ?? 'right'), el('span', {}, high ?? 'wrong')), el('span', {}, report.error_caption.split('|')[0]));
  }
  say(`Surface: ${style}`);
}

function setPhoto(i) {
  photoIndex = i;
  $('photo').value = i === null ? '' : String(i);
  viewer.choosePhoto(i);
  if (i !== null) {
    viewer.rig.hold(i);
    say(`At the pose of ${photos[i].name}`);
  }
}

function stepPhoto(step) {
  if (!photos.length) return;
  setPhoto(photoIndex === null ? (step > 0 ? 0 : photos.length - 1) : (photoIndex + step + photos.length) % photos.length);
}

function setBlend(percent) {
  $('blend').value = String(percent);
  if (percent > 0 && viewer.rig.photo === null && photos.length) setPhoto(photoIndex ?? Math.max(0, report.key_photo));
  viewer.set({ blend: percent / 100 });
}

function toggle(id) {
  const box = $(id);
  viewer.set({ [id]: box.checked });
  say(`${box.parentElement.textContent.trim()} ${box.checked ? 'on' : 'off'}`);
}

function overview() {
  viewer.rig.overview($('cameras').checked);
  say('Overview');
}

// The list shows no photo while the camera is elsewhere.
function onRigChange() {
  if (!viewer || viewer.rig.photo !== null || photoIndex === null) return;
  $('photo').value = '';
}

const TURN = Math.PI / 36;
const KEYS = {
  ArrowLeft: (s) => (s ? viewer.rig.move(-0.05, 0) : viewer.rig.turn(-TURN, 0)),
  ArrowRight: (s) => (s ? viewer.rig.move(0.05, 0) : viewer.rig.turn(TURN, 0)),
  ArrowUp: (s) => (s ? viewer.rig.move(0, 0.05) : viewer.rig.turn(0, TURN)),
  ArrowDown: (s) => (s ? viewer.rig.move(0, -0.05) : viewer.rig.turn(0, -TURN)),
  '+': () => viewer.rig.zoom(0.9),
  '=': () => viewer.rig.zoom(0.9),
  '-': () => viewer.rig.zoom(1.1),
  Home: () => overview(),
  n: () => stepPhoto(1),
  p: () => stepPhoto(-1),
  b: () => setBlend(Number($('blend').value) > 0 ? 0 : 50),
  w: () => $('wireframe').click(),
  f: () => $('facets').click(),
  h: () => $('borders').click(),
  c: () => $('cameras').click(),
};
STYLES.forEach((style, k) => { KEYS[k + 1] = () => !$(`style-${style}`).disabled && setStyle(style); });

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target !== $('stage')) return;
  const action = KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
  if (!action) return;
  action(event.shiftKey);
  event.preventDefault();
}

// A click (not a drag) on a drawn camera jumps to its photo.
function watchClicks(stage) {
  let down = null;
  stage.addEventListener('pointerdown', (e) => { down = [e.clientX, e.clientY]; }, true);
  stage.addEventListener('pointerup', (e) => {
    if (!down || Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4) return;
    const photo = viewer.photoAt(e.clientX, e.clientY);
    if (photo !== null) setPhoto(photo);
  }, true);
}

// The line between two meshes can be dragged as well as the slider.
function watchWipe(stage) {
  const slider = $('wipe');
  slider.addEventListener('input', () => setWipe(slider.value / 1000));
  $('wipe-box').addEventListener('pointerdown', (e) => e.stopPropagation());
  $('wipe-box').addEventListener('keydown', (e) => e.stopPropagation());
  let dragging = false;
  const place = (e) => {
    const box = stage.getBoundingClientRect();
    slider.value = String(Math.round((1000 * (e.clientX - box.left)) / box.width));
    setWipe(slider.value / 1000);
  };
  stage.addEventListener('pointerdown', (e) => {
    const box = stage.getBoundingClientRect();
    if (layout !== 'wipe' || Math.abs(e.clientX - box.left - viewer.settings.wipe * box.width) > 14) return;
    dragging = true;
    e.stopImmediatePropagation();
    stage.setPointerCapture(e.pointerId);
  }, true);
  stage.addEventListener('pointermove', (e) => { if (dragging) { e.stopImmediatePropagation(); place(e); } }, true);
  for (const type of ['pointerup', 'pointercancel']) stage.addEventListener(type, () => { dragging = false; }, true);
}

function connect() {
  const numMeshes = meshes.length;
  radios($('layout'), 'layout', [
    ...(numMeshes === 1 || narrow() ? [{ value: '1', label: '1 view' }] : []),
    ...[2, 3, 4].filter((n) => n <= Math.max(numMeshes, numMeshes > 1 ? 2 : 0)).map((n) => ({ value: String(n), label: `${n} views` })),
    ...(numMeshes > 1 ? [{ value: 'wipe', label: 'Wipe', title: 'Two meshes in one view, with a line to drag between them' }] : []),
  ], setLayout);
  const hasColors = meshes.some(isColored), hasErrors = meshes.some((m) => m.packed.errors);
  radios($('style'), 'style', [
    { value: 'clay', label: 'Clay' },
    { value: 'color', label: 'Colour', disabled: !hasColors, title: hasColors ? '' : 'No mesh has texture or vertex colours' },
    { value: 'normals', label: 'Normals' },
    { value: 'errors', label: 'Errors', disabled: !hasErrors, title: hasErrors ? '' : 'No errors were measured' },
  ], setStyle);
  for (const id of ['wireframe', 'facets', 'borders', 'cameras']) $(id).addEventListener('change', () => toggle(id));
  const list = $('photo');
  list.append(el('option', { value: '' }, 'Choose a photo'), ...photos.map((p, i) => el('option', { value: i }, p.name)));
  list.addEventListener('change', () => setPhoto(list.value === '' ? null : Number(list.value)));
  $('previous').addEventListener('click', () => stepPhoto(-1));
  $('next').addEventListener('click', () => stepPhoto(1));
  $('blend').addEventListener('input', () => setBlend(Number($('blend').value)));
  reveal('photo-tools', photos.length > 0);
  $('overview').addEventListener('click', overview);
  $('stage').addEventListener('keydown', onKey);
  watchClicks($('stage'));
}

function showProgress(done) {
  const percent = Math.round((100 * done) / meshes.length);
  $('loading').setAttribute('aria-valuenow', String(percent));
  $('loading-bar').style.width = `${percent}%`;
  $('loading-text').textContent = done < meshes.length ? `Loading mesh ${done + 1} of ${meshes.length}` : 'Loaded';
  if (done === meshes.length) {
    $('loading').classList.add('done');
    say('All meshes are loaded');
  }
}

async function loadMeshes() {
  let drawn = performance.now();
  for (let i = 0; i < meshes.length; ++i) {
    showProgress(i);
    viewer.addMesh(i, await unpackMesh($(`mesh-${i}`), meshes[i].packed, report.focus));
    if (performance.now() - drawn < 500) continue; // drawing large meshes takes time, too
    viewer.request();
    drawn = performance.now();
  }
  viewer.request();
  showProgress(meshes.length);
}

const nextPaint = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

async function start() {
  fillTexts();
  await nextPaint(); // the figures are there to read while the browser starts its 3D engine
  connect();
  for (let v = 0; v < 4; ++v) shown.push(v % meshes.length);
  watchWipe($('stage')); // before the rig, so that the line gets the pointer first
  try {
    viewer = new Viewer($('canvas'), $('stage'), report, onRigChange);
  } catch (error) {
    $('loading').textContent = 'This browser cannot draw in 3D (WebGL 2 is missing or switched off). The figures are below.';
    $('tools').hidden = true;
    return;
  }
  setLayout(meshes.length === 1 ? '1' : narrow() ? '2' : String(Math.min(meshes.length, 4)));
  setStyle(meshes.length && meshes.every(isColored) ? 'color' : 'clay');
  setWipe(0.5);
  if (report.key_photo >= 0) setPhoto(report.key_photo);
  let wasNarrow = narrow();
  window.addEventListener('resize', () => {
    if (narrow() !== wasNarrow) setLayout(layout);
    wasNarrow = narrow();
  });
  await loadMeshes();
}

// What tests look at.
window.lsmvsReport = { report, loaded: start(), get viewer() { return viewer; } };
