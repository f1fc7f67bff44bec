// The panel: what is shown, in which colours, at which step.

const element = id => document.getElementById(id);
// For labels; after Okabe and Ito, told apart by most eyes.
const LABEL_COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442",
                       "#7a7a7a", "#5b3fa0", "#8c510a", "#1b4d3e", "#e7298a"];

const state = {field: null, column: "", step: 0, amount: 1, scale: 1, low: null, high: null};
let picture, eye;

function shortNumber(value) {
  if (value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5)) return String(+value.toPrecision(5)).replace("-", "−");
  const [mantissa, exponent] = value.toExponential(3).split("e");
  const power = String(+exponent).replace(/[-0-9]/g, digit => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]);
  return (+mantissa + "·10" + power).replace("-", "−");
}

function plainNumber(value) {
  return String(+value.toPrecision(6));
}

/** Least and largest value of the chosen column, over all steps or in this one. */
function naturalRange() {
  const spans = state.field.columns[state.column];
  const used = element("over").value === "one" ? [spans[state.step]] : spans;
  let low = Math.min(...used.map(span => span[2])), high = Math.max(...used.map(span => span[3]));
  if (state.column === "magnitude") [low, high] = [0, high || 1];
  const least = 1e-5 * Math.max(Math.abs(low), Math.abs(high)) || 1;
  if (high - low < least) [low, high] = [low - least / 2, high + least / 2];
  return [low, high];
}

/** The labels in a field of labels, over all steps; null for fields of quantities. */
function labels() {
  if (!state.field.labels) return null;
  const seen = new Set();
  manifest.steps.forEach((_, step) => values(step).forEach(each => seen.add(Math.round(each))));
  return [...seen].sort((one, other) => one - other);
}

function values(step) {
  return picture.arrays[`${state.field.name}/${state.column}/${step}`];
}

function texture(bytes, filter) {
  const made = new THREE.DataTexture(bytes, bytes.length / 4, 1, THREE.RGBAFormat);
  made.minFilter = made.magFilter = filter;
  made.needsUpdate = true;
  return made;
}

function mapBytes(name) {
  const text = manifest.maps[name], bytes = new Uint8Array(4 * 256).fill(255);
  for (let k = 0; k < 256; ++k)
    for (let c = 0; c < 3; ++c) bytes[4 * k + c] = parseInt(text.substr(6 * k + 2 * c, 2), 16);
  return bytes;
}

function showColours() {
  const named = labels(), {uniforms} = picture;
  if (uniforms.map.value) uniforms.map.value.dispose();
  if (named) {
    const bytes = new Uint8Array(4 * named.length).fill(255);
    named.forEach((_, k) => [1, 3, 5].forEach((at, c) => {
      bytes[4 * k + c] = parseInt(LABEL_COLOURS[k % 12].substr(at, 2), 16);
    }));
    uniforms.map.value = texture(bytes, THREE.NearestFilter);
    [uniforms.low.value, uniforms.high.value, uniforms.bands.value] = [-0.5, named.length - 0.5, 0];
  } else {
    if (state.low === null) [state.low, state.high] = naturalRange();
    uniforms.map.value = texture(mapBytes(element("map").value), THREE.LinearFilter);
    [uniforms.low.value, uniforms.high.value] = [state.low, state.high];
    uniforms.bands.value = element("bands").checked ? 10 : 0;
  }
  picture.colour(values(state.step), state.field.onVertices, named && new Map(named.map((each, k) => [each, k])));
  showLegend(named);
  eye.draw();
}

function showLegend(named) {
  const {title, unit} = state.field, part = state.column ? ", " + state.column : "";
  element("legend_title").textContent = title + part + (unit ? ` [${unit}]` : "");
  element("legend_body").hidden = Boolean(named);
  for (const id of ["low", "high", "map", "bands", "over"]) element(id).disabled = Boolean(named);
  element("categories").innerHTML = (named || []).slice(0, 24).map((each, k) =>
    `<li><i style="background:${LABEL_COLOURS[k % 12]}"></i>${each}</li>`).join("");
  if (named) return;
  element("low").value = plainNumber(state.low);
  element("high").value = plainNumber(state.high);
  const bar = element("bar").getContext("2d"), bytes = mapBytes(element("map").value);
  const bands = element("bands").checked ? 10 : 256;
  for (let row = 0; row < 256; ++row) {
    const place = (Math.floor((255 - row) / 256 * bands) + 0.5) / bands, k = 4 * Math.min(255, Math.floor(256 * place));
    bar.fillStyle = `rgb(${bytes[k]},${bytes[k + 1]},${bytes[k + 2]})`;
    bar.fillRect(0, row, 1, 1);
  }
  const all = state.field.columns[state.column];
  const beyond = [Math.min(...all.map(span => span[0])) < state.low * (1 - 1e-5 * Math.sign(state.low)),
                  Math.max(...all.map(span => span[1])) > state.high * (1 + 1e-5 * Math.sign(state.high))];
  element("ticks").innerHTML = ticks(state.low, state.high).map(value => {
    const sign = value === state.low && beyond[0] ? "≤ " : value === state.high && beyond[1] ? "≥ " : "";
    return `<li style="bottom:${100 * (value - state.low) / (state.high - state.low)}%">${sign}${shortNumber(value)}</li>`;
  }).join("");
}

/** Both ends, and between them what is round. */
function ticks(low, high) {
  const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find(each => each * power >= raw);
  const between = [];
  for (let k = Math.ceil(low / step); k * step < high; ++k)
    if (k * step - low > 0.35 * step && high - k * step > 0.35 * step) between.push(+(k * step).toPrecision(12));
  return [low, ...between, high];
}

function showShape() {
  picture.move(state.step, state.amount * state.scale);
  picture.inside.visible = element("show_inverted").checked && picture.arrays["inside" + state.step].length > 0;
  element("scale").value = plainNumber(state.scale);
  eye.draw();
}

function showStep() {
  const {t, inverted} = manifest.steps[state.step];
  element("step").value = state.step;
  element("step_name").textContent = `t = ${shortNumber(t)}  (${state.step + 1} of ${manifest.steps.length})`;
  element("step").setAttribute("aria-valuetext", `t = ${t}`);
  element("inverted_label").hidden = !manifest.steps.some(step => step.inverted);
  element("inverted_count").textContent = `inverted elements: ${inverted}`;
  if (element("over").value === "one") state.low = null;
  showShape();
  showColours();
}

function chooseField(name) {
  state.field = manifest.fields.find(field => field.name === name);
  element("field").value = name;
  const columns = Object.keys(state.field.columns);
  state.column = columns[0];
  element("column").innerHTML = columns.map(each => `<option>${each}</option>`).join("");
  element("column_label").hidden = columns.length < 2;
  state.low = null;
  showColours();
}

/** How many times a displacement must be drawn to be a tenth of the body's size, in round numbers. */
function visibleScale() {
  const size = 2 * picture.rest.reduce((most, each) => Math.max(most, Math.abs(each)), 0);
  let largestMove = 0;
  manifest.steps.forEach((_, step) => picture.arrays["u" + step].forEach(each => {
    largestMove = Math.max(largestMove, Math.abs(each));
  }));
  if (!largestMove) return 1;
  const wanted = 0.1 * size / largestMove, power = 10 ** Math.floor(Math.log10(wanted));
  return wanted < 4 ? 1 : power * [5, 2, 1].find(each => each * power <= wanted);
}

function showRest(shown) {
  picture.outline.visible = picture.ghost.visible = element("show_rest").checked = shown;
}

function setScale(value) {
  if (Number.isFinite(value)) state.scale = value;
  showShape();
}

function showReading(event) {
  const found = event && eye.hit(event.clientX, event.clientY);
  if (!found) { element("reading").textContent = ""; return; }
  const {triangle, vertex} = found, {arrays} = picture, {field} = state;
  const row = field.onVertices ? vertex : arrays.triangle_cells[triangle];
  const named = field.onVertices ? `vertex ${arrays.vertices[vertex]}` : `cell ${arrays.cells[row]}`;
  const at = [0, 1, 2].map(axis => shortNumber(+(arrays.rest[3 * vertex + axis] + manifest.center[axis]).toPrecision(4)));
  element("reading").textContent = `${field.title}${state.column ? ", " + state.column : ""}: ` +
    `${shortNumber(values(state.step)[row])}${field.unit ? " " + field.unit : ""}\n` +
    `${named}, at rest near (${at.slice(0, manifest.flat ? 2 : 3).join(", ")})`;
}

function changeStep(by) {
  const count = manifest.steps.length;
  state.step = (state.step + by + count) % count;
  showStep();
}

let player = 0;
function play() {
  if (manifest.steps.length < 2) return;
  if (player) { clearInterval(player); player = 0; }
  else player = setInterval(() => changeStep(1), Math.max(40, Math.min(400, 6000 / manifest.steps.length)));
  element("play").textContent = player ? "❚❚" : "▶";
  element("play").setAttribute("aria-label", player ? "Pause" : "Play");
}

function toggle(id) {
  element(id).checked = !element(id).checked;
  element(id).dispatchEvent(new Event("change"));
}

const KEYS = {
  ArrowLeft: () => eye.turn(-0.1, 0), ArrowRight: () => eye.turn(0.1, 0),
  ArrowUp: () => eye.turn(0, -0.1), ArrowDown: () => eye.turn(0, 0.1),
  "+": () => eye.zoom(0.9), "=": () => eye.zoom(0.9), "-": () => eye.zoom(1 / 0.9),
  0: () => eye.look("start"), x: () => eye.look("x"), y: () => eye.look("y"), z: () => eye.look("z"),
  e: () => toggle("show_edges"), "[": () => changeStep(-1), "]": () => changeStep(1), " ": play};

function savePicture() {
  eye.drawNow();
  const link = document.createElement("a");
  link.href = eye.canvas.toDataURL("image/png");
  link.download = document.title.replace(/[^\w.-]+/g, "_") + ".png";
  link.click();
}

function listen() {
  const on = (id, event, act) => element(id).addEventListener(event, act);
  on("field", "change", event => chooseField(event.target.value));
  on("column", "change", event => { state.column = event.target.value; state.low = null; showColours(); });
  on("map", "change", showColours);
  on("bands", "change", showColours);
  on("over", "change", () => { state.low = null; showColours(); });
  for (const end of ["low", "high"])
    on(end, "change", event => {
      const value = event.target.value.trim();
      if (value === "") state.low = null;  // an empty end: as it was
      else if (Number.isFinite(+value)) state[end] = +value;
      showColours();
    });
  on("amount", "input", event => { state.amount = +event.target.value; showShape(); });
  on("scale", "change", event => setScale(+event.target.value));
  on("true_scale", "click", () => setScale(1));
  on("auto_scale", "click", () => setScale(visibleScale()));
  on("show_edges", "change", event => { picture.edges.visible = event.target.checked; eye.draw(); });
  on("show_rest", "change", event => { showRest(event.target.checked); eye.draw(); });
  on("show_inverted", "change", event => { picture.uniforms.marks.value = +event.target.checked; showShape(); });
  on("views", "click", event => event.target.dataset.view && eye.look(event.target.dataset.view));
  on("save", "click", savePicture);
  on("step", "input", event => { state.step = +event.target.value; showStep(); });
  on("play", "click", play);
  on("canvas", "keydown", event => {
    const act = !event.ctrlKey && !event.metaKey && !event.altKey && KEYS[event.key];
    if (act) { act(); event.preventDefault(); }
  });
  let pending = null;
  on("canvas", "pointermove", event => {
    if (event.buttons || pending) return;
    pending = setTimeout(() => { pending = null; showReading(event); }, 60);
  });
  on("canvas", "pointerleave", () => { clearTimeout(pending); pending = null; showReading(null); });
}

function listRegions() {
  element("regions").innerHTML = manifest.regions.map(each =>
    `<label class="check"><input type="checkbox" checked value="${each}"> region ${each}</label>`).join("");
  element("regions").addEventListener("change", () => {
    const boxes = [...element("regions").querySelectorAll("input:checked")];
    picture.showRegions(new Set(boxes.map(box => +box.value)));
    eye.draw();
  });
}

function listChoices() {
  element("field").innerHTML = manifest.fields.map(field =>
    `<option value="${field.name}">${field.title}</option>`).join("");
  element("map").innerHTML = Object.keys(manifest.maps).map(each => `<option>${each}</option>`).join("");
  const several = manifest.steps.length > 1;
  element("timeline").hidden = element("over_label").hidden = !several;
  element("step").max = manifest.steps.length - 1;
  listRegions();
}

/** Light or dark: as the system says, until the button is pressed. */
function chooseTheme() {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const set = theme => { root.dataset.theme = theme; };
  set(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => set(dark.matches ? "dark" : "light"));
  element("theme").addEventListener("click", () => set(root.dataset.theme === "dark" ? "light" : "dark"));
}

async function start() {
  chooseTheme();
  const arrays = await unpack();
  picture = new BodyPicture(arrays);
  try {
    eye = new Eye(element("canvas"), picture);
  } catch (problem) {
    fail("this browser offers no WebGL");
    return;
  }
  listChoices();
  state.step = manifest.steps.length - 1;
  picture.edges.visible = element("show_edges").checked = picture.count < 12000;
  showRest(true);
  state.scale = visibleScale();
  if (state.scale < 4 || manifest.flat) state.scale = 1;
  listen();
  chooseField(manifest.fields[0].name);
  showStep();
  eye.look("start");
  eye.drawNow();
  root.dataset.viewer = "ready";
}

start();
